import math
from dataclasses import replace

import numpy as np
import pytest

from trackctl.errors import MapError
from trackctl.geometry.circle import Circle
from trackctl.planning.blocked_cell import describe_cell
from trackctl.planning.elevation import Elevation
from trackctl.planning.occupancy import FREE, OCCUPIED, UNKNOWN, GridFrame, Occupancy
from trackctl.planning.planning_map import MAX_CELLS, PlanningMap, collision_grid, grid_frame, overridden, slope_field
from trackctl.planning.slope_field import gradient_at
from trackctl.profiles.footprint import rectangle

BODY = rectangle(1.0, 0.6)


def gridded(cells, resolution=0.5, x=2.0, y=-1.0, yaw=0.4):
    cells = np.array(cells, np.int8)
    frame = GridFrame(*cells.shape, resolution, x, y, yaw)
    return PlanningMap(file="a.yaml", occupancy=Occupancy(cells, frame, "a.pgm"))


def laid(planning_map, **options):
    return collision_grid(planning_map, slope_field(planning_map, BODY), **options)


@pytest.mark.parametrize("seed", range(3))
def test_distances_are_those_of_all_pairs(seed):
    random = np.random.default_rng(seed)
    cells = np.where(random.random((17, 23)) < 0.03, OCCUPIED, FREE)
    grid = laid(gridded(cells))
    # The cells just outside are blocked too.
    blocked = np.argwhere(np.pad(cells != FREE, 1, constant_values=True)) - 1
    for row, column in np.ndindex(cells.shape):
        nearest = np.hypot(*(blocked - (row, column)).T).min()
        assert grid.distance[row, column] == pytest.approx(0.5 * nearest, abs=1e-12)
    np.testing.assert_array_equal(grid.distance == 0.0, grid.blocked)


def test_the_grid_lies_where_its_image_does():
    grid = laid(gridded(np.zeros((4, 5))))
    assert (grid.x, grid.y, grid.resolution) == (2.0, -1.0, 0.5)
    assert (grid.cos_yaw, grid.sin_yaw) == (math.cos(0.4), math.sin(0.4))


def test_unknown_cells_are_blocked_unless_allowed():
    known = gridded([[FREE, UNKNOWN, OCCUPIED]])
    assert laid(known).blocked.tolist() == [[False, True, True]]
    assert laid(known, allow_unknown=True).blocked.tolist() == [[False, False, True]]


def test_obstacles_lie_in_the_world_however_the_grid_is_turned():
    shapes = {"circles": (Circle(3.0, 2.0, 1.0),), "polygons": (((5.0, 1.0), (6.0, 1.0), (5.0, 3.0)),)}
    for yaw, x, y in ((0.0, 0.0, -2.0), (0.5, 2.0, -4.0), (-1.2, -3.0, 5.0), (3.0, 8.0, 9.0)):
        empty = gridded(np.zeros((120, 120)), 0.1, x, y, yaw)
        grid = laid(replace(empty, **shapes))
        area = grid.blocked.sum() * 0.01
        # Cells on the border, of length 2 pi and 1 + 2 + sqrt 5, overshoot by less than a cell's diagonal on it.
        assert math.pi + 1.0 < area < math.pi + 1.0 + 0.1 * math.sqrt(2.0) * (2.0 * math.pi + 5.3)
        frame = empty.occupancy.frame
        assert grid.blocked[frame.cell(3.0, 2.0)]
        assert grid.blocked[frame.cell(5.1, 1.1)]
        assert not grid.blocked[frame.cell(4.3, 2.0)]


def test_a_map_of_shapes_alone_has_room_around_them():
    shapes = PlanningMap(file="a", circles=(Circle(1.0, 2.0, 1.0),), start=(-9.0, 2.0, 0.0), goal=(11.0, 2.0, 0.0))
    frame = grid_frame(shapes)
    assert (frame.x, frame.y, frame.resolution) == (-19.0, -9.0, 0.05)
    assert (frame.n_columns, frame.n_rows) == (800, 440)
    assert grid_frame(replace(shapes, resolution=0.5)).n_columns == 80
    bounded = grid_frame(replace(shapes, bounds=(-10.0, 0.0, 12.0, 4.0)))
    assert (bounded.x, bounded.y, bounded.n_columns, bounded.n_rows) == (-10.0, 0.0, 440, 80)


def test_wide_maps_of_shapes_get_wide_cells_and_too_many_are_refused():
    wide = PlanningMap(file="wide.yaml", bounds=(0.0, 0.0, 1000.0, 500.0))
    frame = grid_frame(wide)
    assert (frame.resolution, frame.n_columns, frame.n_rows) == (1.0, 1000, 500)
    with pytest.raises(MapError, match=f"wide.yaml: 1000 m x 500 m in cells of 0.01 m .* allowed: up to {MAX_CELLS}"):
        grid_frame(replace(wide, resolution=0.01))


def test_a_map_of_nothing_is_refused():
    with pytest.raises(MapError, match="holds nothing"):
        grid_frame(PlanningMap(file="a"))


def hill(**changes):
    height = 0.1 * np.arange(20.0)[None, :] + np.zeros((10, 1))
    return Elevation(height, 1.0, 1.0, 0.5, 0.5, "hill.asc", **changes)


def test_an_elevation_grid_alone_is_a_map():
    grid = laid(PlanningMap(file="hill.asc", elevation=hill()))
    assert (grid.x, grid.y) == (0.0, 0.0)
    assert grid.blocked.shape == (200, 400)
    assert not grid.blocked.any()


def test_ground_that_is_unknown_or_beyond_the_elevation_grid_is_blocked():
    elevation = hill()
    elevation.height[4, 9] = np.nan
    beside = gridded(np.zeros((60, 120)), 0.25, -5.0, -2.0, 0.0)
    grid = laid(replace(beside, elevation=elevation))
    x, y = (-5.0 + 0.25 * (np.arange(120) + 0.5))[None, :], (-2.0 + 0.25 * (np.arange(60) + 0.5))[:, None]
    outside = (x < 0.0) | (x > 20.0) | (y < 0.0) | (y > 10.0)
    # Between the unknown node and its neighbours nothing is known either.
    unknown = (np.abs(x - 9.5) < 1.0) & (np.abs(y - 4.5) < 1.0)
    np.testing.assert_array_equal(grid.blocked, outside | unknown)
    assert "without a known slope" in describe_cell(replace(beside, elevation=elevation), 26, 58)


def test_a_map_apart_from_its_elevation_grid_is_refused():
    apart = replace(gridded(np.zeros((4, 4)), 1.0, 500.0, 0.0), elevation=hill())
    with pytest.raises(MapError, match=r"no cell lies on known ground of hill.asc, which reaches from \(0, 0\) to"):
        laid(apart)


def test_slopes_come_from_the_plane_or_the_grid_or_are_level():
    def gradient(planning_map):
        return gradient_at(slope_field(planning_map, BODY), 5.0, 5.0)

    level = PlanningMap(file="a")
    assert gradient(level) == (0.0, 0.0)
    # Up-slope is +y unless told.
    np.testing.assert_allclose(gradient(replace(level, slope=0.2)), (0.0, math.tan(0.2)), atol=1e-15)
    np.testing.assert_allclose(gradient(replace(level, slope=0.2, uphill_yaw=0.0)), (math.tan(0.2), 0.0))
    np.testing.assert_allclose(gradient(replace(level, elevation=hill())), (0.1, 0.0), atol=1e-13)


def test_options_take_the_place_of_what_the_map_says():
    own = replace(gridded(np.zeros((2, 2))), start=(1.0, 2.0, 3.0), vehicle="carrier", elevation=hill())
    changed = overridden(own, start=(4.0, 5.0, 6.0), goal=None, resolution=2.0, vehicle=None)
    assert changed.start == (4.0, 5.0, 6.0)
    assert changed.vehicle == "carrier"
    assert grid_frame(changed) == GridFrame(2, 2, 2.0, 2.0, -1.0, 0.4)
    tilted = overridden(own, slope=0.1)
    assert tilted.elevation is None
    assert overridden(tilted, uphill_yaw=1.0).uphill_yaw == 1.0
    hilly = overridden(tilted, elevation=hill())
    assert (hilly.slope, hilly.uphill_yaw) == (None, None)


@pytest.mark.parametrize(
    ("cell", "words"),
    [
        ((0, 0), "cell (0, 0) at (2.250, -0.750) m, occupied in a.pgm"),
        ((0, 1), "neither free nor occupied in a.pgm"),
        ((1, 0), "touched by circle 1, of 0.3 m about (2.1, -0.2)"),
        ((1, 2), "touched by polygon 1, from (3, -0.4) on"),
        ((2, 0), "outside the map"),
        ((0, -1), "outside the map"),
    ],
)
def test_why_a_cell_is_blocked(cell, words):
    planning_map = replace(
        gridded([[100, -1, 0], [0, 0, 0]], yaw=0.0),
        circles=(Circle(2.1, -0.2, 0.3),),
        polygons=(((3.0, -0.4), (3.4, -0.4), (3.2, -0.1)),),
    )
    assert words in describe_cell(planning_map, *cell)
