import math

import numpy as np
import pytest
from planning_cases import driven, pose_error

from trackctl.planning.dubins import WORD_COUNT, WORDS, dubins_length, dubins_word, seen_from

ORIGIN = (0.0, 0.0, 0.0)


def length(start, end, radius=1.0):
    return dubins_length(*map(float, start), *map(float, end), radius)


def random_poses(count, seed=0, size=4.0):
    stream = np.random.default_rng(seed)
    return np.column_stack((stream.uniform(-size, size, (count, 2)), stream.uniform(-math.pi, math.pi, count)))


@pytest.mark.parametrize(
    ("end", "expected"),
    [
        ((5.0, 0.0, 0.0), 5.0),
        ((0.0, 2.0, math.pi), math.pi),
        ((1.0, -1.0, -0.5 * math.pi), 0.5 * math.pi),
        ((0.0, 0.0, math.pi), 7.0 * math.pi / 3.0),  # RLR of pi/3, 5 pi/3, pi/3
        ((-3.0, 0.0, 0.0), 2.0 * math.pi + 3.0),  # a half turn, back, a half turn
        ((0.0, 5.0, math.pi), math.pi + 3.0),
        (ORIGIN, 0.0),
    ],
)
def test_closed_forms(end, expected):
    assert length(ORIGIN, end) == pytest.approx(expected, abs=1e-12)


def test_lengths_scale_with_the_radius():
    for start, end in zip(random_poses(50), random_poses(50, seed=1), strict=True):
        larger = length((*2.5 * start[:2], start[2]), (*2.5 * end[:2], end[2]), radius=2.5)
        assert larger == pytest.approx(2.5 * length(start, end), abs=1e-10)


def test_every_word_ends_at_its_goal():
    found = np.zeros(WORD_COUNT, int)
    for x, y, turn in random_poses(400):
        for word in range(WORD_COUNT):
            pieces = dubins_word(x, y, turn, word)
            if math.isfinite(sum(pieces)):
                assert min(pieces) >= 0.0
                way = [(sense, piece, 0.0) for sense, piece in zip(WORDS[word], pieces, strict=True)]
                assert pose_error(driven(ORIGIN, way, step=100.0)[-1], (x, y, turn)) < 1e-12
                found[word] += 1
    assert found.min() > 50


def test_no_chain_of_arcs_and_straights_is_shorter():
    stream = np.random.default_rng(2)
    for _ in range(2000):
        count = stream.integers(1, 6)
        senses, lengths = stream.integers(-1, 2, count), stream.exponential(1.0, count)
        end = driven(ORIGIN, [(float(s), piece, 0.0) for s, piece in zip(senses, lengths, strict=True)], 100.0)[-1]
        assert length(ORIGIN, end) <= lengths.sum() + 1e-9


def test_a_single_word_is_no_longer_than_it_was_built():
    """Chains that are words of moderate arcs come back as they are: nothing longer is called shortest."""
    for sense, arc, straight in ((1.0, 0.7, 2.0), (-1.0, 1.4, 5.0)):
        end = driven(ORIGIN, [(sense, arc, 0.0), (0.0, straight, 0.0), (-sense, 0.4, 0.0)], 100.0)[-1]
        assert length(ORIGIN, end) == pytest.approx(arc + straight + 0.4, abs=1e-12)


def test_symmetries():
    for start, end in zip(random_poses(200), random_poses(200, seed=1), strict=True):
        forth = length(start, end)
        back = length((*end[:2], end[2] + math.pi), (*start[:2], start[2] + math.pi))
        mirrored = length(start * (1.0, -1.0, -1.0), end * (1.0, -1.0, -1.0))
        turn = np.array([[0.6, -0.8], [0.8, 0.6]])
        angle = math.atan2(0.8, 0.6)
        moved = [(*(turn @ pose[:2] + (3.0, -7.0)), pose[2] + angle) for pose in (start, end)]
        assert [back, mirrored, length(*moved)] == pytest.approx([forth] * 3, abs=1e-9)


def test_metric():
    poses = random_poses(60, size=3.0)
    for a, b, c in zip(poses[::3], poses[1::3], poses[2::3], strict=True):
        assert length(a, b) >= math.hypot(*(a - b)[:2]) - 1e-12
        assert length(a, c) <= length(a, b) + length(b, c) + 1e-9


def test_a_pose_seen_from_another():
    x, y, turn = seen_from(1.0, 2.0, 0.5 * math.pi, 1.0, 5.0, math.pi, 1.5)
    assert (x, y, turn) == pytest.approx((2.0, 0.0, 0.5 * math.pi), abs=1e-15)
