import math

import numpy as np
import pytest
from planning_cases import driven

from trackctl.planning.dubins import dubins_length
from trackctl.planning.families import (
    arc_to_point,
    distance_to_point,
    single_arc,
    way_to_point,
)
from trackctl.planning.pieces import new_way

WAY = new_way()
POINTS = np.random.default_rng(0).uniform(-4.0, 4.0, (300, 2))


def end_of(count):
    pieces = list(zip(*(part[:count] for part in WAY), strict=True))
    return driven((0.0, 0.0, 0.0), pieces, step=100.0)[-1], pieces


def test_a_single_arc_goes_through_its_point():
    curvature, length = single_arc(2.0, 2.0)
    assert (curvature, length) == pytest.approx((0.5, math.pi))
    assert single_arc(3.0, 0.0) == (0.0, 3.0)
    reached = 0
    for x, y in POINTS:
        count = arc_to_point(x, y, 1.5, WAY)
        if count:
            end, pieces = end_of(count)
            assert end[:2] == pytest.approx((1.5 * x, 1.5 * y), abs=1e-9)
            assert abs(pieces[0][0]) <= 1.0 / 1.5
            reached += 1
    assert reached > 100


def test_two_pieces_end_at_their_point():
    for x, y in POINTS:
        count = way_to_point(x, y, 1.5, WAY)
        assert count == 2
        end, pieces = end_of(count)
        assert end[:2] == pytest.approx((1.5 * x, 1.5 * y), abs=1e-9)
        assert min(length for _, length, _ in pieces) >= 0.0


def test_two_pieces_are_the_shortest_way_whatever_the_tangent():
    for x, y in POINTS[:60]:
        way_to_point(x, y, 1.0, WAY)
        length = WAY.length[:2].sum()
        shortest = min(dubins_length(0.0, 0.0, 0.0, x, y, turn, 1.0) for turn in np.linspace(-math.pi, math.pi, 721))
        assert length <= shortest + 1e-9
        # The length changes by at most a radius per radian of the end's tangent.
        assert shortest <= length + 4.0 * math.pi / 720.0


def test_distance_is_the_length_of_the_shortest():
    for x, y in POINTS:
        way_to_point(x, y, 1.0, WAY)
        assert distance_to_point(0.0, 0.0, 0.0, x, y, 1.0) == pytest.approx(WAY.length[:2].sum(), abs=1e-9)
