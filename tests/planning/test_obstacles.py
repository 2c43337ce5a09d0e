import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trackctl.geometry.circle import Circle
from trackctl.planning.obstacles import block_circle, block_polygon
from trackctl.planning.occupancy import GridFrame

FRAME = GridFrame(40, 50, 0.1, -2.0, 1.0, 0.7)


def drawn(block, shape, frame=FRAME):
    blocked = np.zeros((frame.n_rows, frame.n_columns), np.bool_)
    block(blocked, frame, shape)
    return blocked


def cells_of(points, frame=FRAME):
    """Cells that hold one of the points."""
    found = np.zeros((frame.n_rows, frame.n_columns), np.bool_)
    for cell in (frame.cell(x, y) for x, y in points):
        if cell is not None:
            found[cell] = True
    return found


def polygon_points(corners, random, count=3000):
    """Random points of a triangle."""
    a, b, c = np.array(corners)
    u, v = random.random((2, count, 1))
    u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
    return a + u * (b - a) + v * (c - a)


places = st.tuples(st.floats(-4.0, 2.0), st.floats(0.0, 6.0))


@settings(max_examples=30, deadline=None)
@given(places, st.floats(0.0, 2.0))
def test_a_circle_blocks_the_cells_nearer_than_its_radius(centre, radius):
    blocked = drawn(block_circle, Circle(*centre, radius))
    # In the grid's own axes: the nearest point of a cell's square is the centre, cut off at its sides.
    column, row = FRAME.to_grid(*centre)
    for i in range(FRAME.n_rows):
        for j in range(FRAME.n_columns):
            nearest = min(max(column, j), j + 1), min(max(row, i), i + 1)
            distance = math.dist(nearest, (column, row)) * FRAME.resolution
            if abs(distance - radius) > 1e-9:
                assert blocked[i, j] == (distance < radius)


triangles = st.tuples(places, places, places).filter(lambda corners: area(corners) > 1e-6)


def area(corners):
    a, b, c = np.array(corners)
    return 0.5 * abs(np.linalg.det(np.stack((b - a, c - a))))


@settings(max_examples=50, deadline=None)
@given(triangles, st.integers(0, 1000))
def test_no_point_of_a_polygon_is_outside_its_cells(corners, seed):
    blocked = drawn(block_polygon, corners)
    inside = polygon_points(corners, np.random.default_rng(seed))
    # Points within rounding of a cell's border may count to either cell.
    column, row = FRAME.to_grid(*inside.T)
    off_border = (np.abs(column - np.round(column)) > 1e-9) & (np.abs(row - np.round(row)) > 1e-9)
    assert not (cells_of(inside[off_border]) & ~blocked).any()


@settings(max_examples=50, deadline=None)
@given(triangles)
def test_every_cell_of_a_polygon_is_near_it(corners):
    """A convex polygon and a square are apart where an edge of either parts them; else they touch."""
    columns, rows = FRAME.to_grid(*np.array(corners).T)
    points = np.stack((columns, rows), axis=1)
    for i, j in zip(*np.nonzero(drawn(block_polygon, corners)), strict=True):
        square = np.array([(j, i), (j + 1, i), (j + 1, i + 1), (j, i + 1)], float)
        sides = np.concatenate((np.roll(points, -1, axis=0) - points, [(1.0, 0.0), (0.0, 1.0)]))
        for normal in np.stack((-sides[:, 1], sides[:, 0]), axis=1):
            a, b = points @ normal, square @ normal
            assert a.max() > b.min() - 1e-9
            assert b.max() > a.min() - 1e-9


def test_a_rectangle_along_the_cells_blocks_just_them():
    frame = GridFrame(10, 10, 0.5, 0.0, 0.0)
    blocked = drawn(block_polygon, ((1.0, 1.0), (2.0, 1.0), (2.0, 3.0), (1.0, 3.0)), frame)
    expected = np.zeros((10, 10), np.bool_)
    expected[2:6, 2:4] = True
    np.testing.assert_array_equal(blocked, expected)


def test_a_sliver_between_centres_is_seen():
    frame = GridFrame(10, 10, 1.0, 0.0, 0.0)
    blocked = drawn(block_polygon, ((0.0, 5.1), (10.0, 5.1), (10.0, 5.2), (0.0, 5.2)), frame)
    expected = np.zeros((10, 10), np.bool_)
    expected[5] = True
    np.testing.assert_array_equal(blocked, expected)


def test_the_order_of_corners_does_not_matter():
    corners = ((-1.0, 2.0), (0.5, 2.5), (0.0, 4.0), (-0.5, 3.0))
    np.testing.assert_array_equal(drawn(block_polygon, corners), drawn(block_polygon, corners[::-1]))


def test_a_star_that_crosses_itself_has_no_hole():
    angles = np.radians(90.0 + 144.0 * np.arange(5))
    star = tuple(zip(2.0 + 2.0 * np.cos(angles), 2.0 + 2.0 * np.sin(angles), strict=True))
    frame = GridFrame(40, 40, 0.1, 0.0, 0.0)
    assert drawn(block_polygon, star, frame)[frame.cell(2.0, 2.0)]


@pytest.mark.parametrize("shift", [(100.0, 0.0), (-100.0, 0.0), (0.0, 100.0), (0.0, -100.0)])
def test_what_lies_outside_blocks_nothing(shift):
    x, y = shift
    assert not drawn(block_circle, Circle(x, y, 3.0)).any()
    assert not drawn(block_polygon, ((x, y), (x + 1.0, y), (x, y + 1.0))).any()


def test_what_surrounds_the_grid_blocks_it_all():
    assert drawn(block_circle, Circle(0.0, 0.0, 100.0)).all()
    assert drawn(block_polygon, ((-99.0, -99.0), (99.0, -99.0), (99.0, 99.0), (-99.0, 99.0))).all()
