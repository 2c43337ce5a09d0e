import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackctl.profiles.footprint import MAX_VERTICES, counter_clockwise, footprint_problem, rectangle

SQUARE = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
L_SHAPE = ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0))


def regular_polygon(count):
    angles = [2.0 * math.pi * k / count for k in range(count)]
    return tuple((math.cos(angle), math.sin(angle)) for angle in angles)


def test_rectangle_is_about_the_origin_and_counter_clockwise():
    assert rectangle(1.0, 0.8) == ((-0.5, -0.4), (0.5, -0.4), (0.5, 0.4), (-0.5, 0.4))
    assert counter_clockwise(rectangle(1.0, 0.8)) == rectangle(1.0, 0.8)


def test_clockwise_corners_are_turned_round():
    assert counter_clockwise(SQUARE[::-1]) == SQUARE


@pytest.mark.parametrize("polygon", [SQUARE, SQUARE[:3], L_SHAPE, regular_polygon(MAX_VERTICES)])
def test_simple_polygons_pass(polygon):
    assert footprint_problem(polygon) is None
    assert footprint_problem(polygon[::-1]) is None


@given(st.integers(0, 5))
def test_any_corner_may_come_first(start):
    assert footprint_problem(L_SHAPE[start:] + L_SHAPE[:start]) is None


@pytest.mark.parametrize(
    "polygon",
    [
        (),
        SQUARE[:2],
        regular_polygon(MAX_VERTICES + 1),
        ((0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)),  # a bow tie
        ((0.0, 0.0), (3.0, 1.0), (1.0, 0.0), (0.0, 1.0)),  # a lopsided one, with an area
        ((0.0, 0.0), (1.0, 0.0), (2.0, 0.0)),  # no area
        ((0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (0.0, 1.0)),  # a corner twice
        ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 0.0), (0.0, 1.0)),  # a corner on an edge
        ((0.0, 0.0), (2.0, 0.0), (1.0, 0.0), (1.0, 1.0)),  # an edge folded back
        ((0.0, 0.0), (1.0, 0.0), (math.nan, 1.0)),
        ((0.0, 0.0), (1.0, 0.0), (math.inf, 1.0)),
        ((0.0, 0.0), (1.0, 0.0), (51.0, 1.0)),
    ],
)
def test_other_outlines_are_refused(polygon):
    assert footprint_problem(polygon)
