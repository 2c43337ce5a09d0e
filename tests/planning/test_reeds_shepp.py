import math

import numpy as np
import pytest
from planning_cases import driven, pose_error

from trackctl.planning.dubins import dubins_length
from trackctl.planning.pieces import new_way
from trackctl.planning.reeds_shepp import WORD_COUNT, length_and_cusps, reeds_shepp_length, write_word

ORIGIN = (0.0, 0.0, 0.0)
WAY = new_way()


def length(x, y, turn):
    return reeds_shepp_length(float(x), float(y), float(turn), WAY)


def random_poses(count, seed=0, size=4.0):
    stream = np.random.default_rng(seed)
    return np.column_stack((stream.uniform(-size, size, (count, 2)), stream.uniform(-math.pi, math.pi, count)))


@pytest.mark.parametrize(
    ("end", "expected"),
    [
        ((-3.0, 0.0, 0.0), 3.0),
        ((0.0, 0.0, math.pi), math.pi),  # three arcs of pi/3
        ((0.0, 2.0, math.pi), math.pi),
        ((1.0, -1.0, -0.5 * math.pi), 0.5 * math.pi),
        (ORIGIN, 0.0),
    ],
)
def test_closed_forms(end, expected):
    assert length(*end) == pytest.approx(expected, abs=1e-12)


def test_every_word_ends_at_its_goal():
    found = np.zeros(WORD_COUNT, int)
    for x, y, turn in random_poses(300):
        for word in range(WORD_COUNT):
            count = write_word(x, y, turn, word, WAY)
            if count:
                way = list(zip(*(part[:count] for part in WAY), strict=True))
                assert pose_error(driven(ORIGIN, way, step=100.0)[-1], (x, y, turn)) < 1e-11
                found[word] += 1
    assert found.min() > 20


def test_no_chain_with_cusps_is_shorter():
    stream = np.random.default_rng(2)
    for _ in range(4000):
        count = stream.integers(1, 6)
        senses, lengths = stream.integers(-1, 2, count), stream.normal(0.0, 1.0, count)
        end = driven(ORIGIN, [(float(s), piece, 0.0) for s, piece in zip(senses, lengths, strict=True)], 100.0)[-1]
        assert length(*end) <= np.abs(lengths).sum() + 1e-9


def test_never_longer_than_forwards_only():
    for x, y, turn in random_poses(300):
        assert math.hypot(x, y) - 1e-12 <= length(x, y, turn) <= dubins_length(*ORIGIN, x, y, turn, 1.0) + 1e-12


def test_symmetries():
    for x, y, turn in random_poses(200):
        mirrored, reversed_ = length(x, -y, -turn), length(-x, y, -turn)
        back = length(x * math.cos(turn) + y * math.sin(turn), x * math.sin(turn) - y * math.cos(turn), turn)
        assert [mirrored, reversed_, back] == pytest.approx([length(x, y, turn)] * 3, abs=1e-9)


def test_cusps_are_counted_over_empty_pieces():
    for i, piece in enumerate((1.0, 0.0, -2.0, 3.0, 0.0)):
        WAY.length[i] = piece
    assert length_and_cusps(WAY, 5) == (6.0, 2)
