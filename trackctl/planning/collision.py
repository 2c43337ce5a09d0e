"""Collisions of the footprint with blocked cells, at a pose and along arcs.

Blocked cells count as whole squares. A distance transform answers far from obstacles; near them the footprint, grown
by what it may move until the next check, is scanned row by row against counts of blocked cells: no corner is cut.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.planning.collision_grid import CollisionGrid
from trackctl.planning.footprint import Footprint

Array = NDArray[np.float64]
Counts = NDArray[np.int32]

HALF_DIAGONAL = math.sqrt(0.5)
#: Growth of the footprint above which a scan costs more than the steps it spares, in cells.
COARSEST_SCAN = 8.0
#: Growth of the footprint that can be scanned at all, over its reach.
LARGEST_GROWTH = 2.0
TINY = 1e-12
#: A row that no cell has.
NOWHERE = -(2**31)


class Obstacles(NamedTuple):
    """A collision grid and a footprint, made ready for the kernels.

    Attributes
    ----------
    before
        Number of blocked cells in a row before a column, shape (n_rows, n_columns + 1).
    distance
        As of `CollisionGrid`. [m]
    resolution, x, y, cos_yaw, sin_yaw
        As of `CollisionGrid`.
    margin
        Kept between footprint and blocked cells. [m]
    footprint
        Of the vehicle.
    spans
        Work space: first and last column of a part in each of its rows, shape (2, n).
    """

    before: Counts
    distance: Array
    resolution: float
    x: float
    y: float
    cos_yaw: float
    sin_yaw: float
    margin: float
    footprint: Footprint
    spans: Array


def obstacles_of(grid: CollisionGrid, footprint: Footprint, margin: float = 0.0) -> Obstacles:
    """Count the blocked cells along the rows of a grid.

    Parameters
    ----------
    grid
        What is blocked.
    footprint
        About the mass centre.
    margin
        To keep from blocked cells. [m]
    """
    n_rows, n_columns = grid.blocked.shape
    before = np.zeros((n_rows, n_columns + 1), np.int32)
    np.cumsum(grid.blocked, axis=1, out=before[:, 1:])
    frame = (float(grid.resolution), float(grid.x), float(grid.y), float(grid.cos_yaw), float(grid.sin_yaw))
    distance = np.array(grid.distance, dtype=np.float64, order="C")
    tallest = 2.0 * ((1.0 + LARGEST_GROWTH) * footprint.reach + margin) / grid.resolution
    return Obstacles(before, distance, *frame, float(margin), footprint, np.empty((2, math.ceil(tallest) + 4)))


@inlined
def cell_position(obstacles: Obstacles, x: float, y: float) -> tuple[float, float]:
    """Column and row of a point, with fractions: a cell's centre lies at halves. [cells]"""
    dx, dy = x - obstacles.x, y - obstacles.y
    column = (obstacles.cos_yaw * dx + obstacles.sin_yaw * dy) / obstacles.resolution
    return column, (obstacles.cos_yaw * dy - obstacles.sin_yaw * dx) / obstacles.resolution


@inlined
def free_radius(obstacles: Obstacles, column: float, row: float) -> float:
    """Distance from a point to the nearest blocked square, or less; not above 0 outside the grid. [m]"""
    n_rows, n_columns = obstacles.distance.shape
    if not (0.0 <= column < n_columns and 0.0 <= row < n_rows):
        return 0.0
    i, j = int(row), int(column)
    off = math.hypot(column - j - 0.5, row - i - 0.5) + HALF_DIAGONAL
    return float(obstacles.distance[i, j]) - off * obstacles.resolution


@kernel
def disc_clearance(obstacles: Obstacles, x: float, y: float, cos_yaw: float, sin_yaw: float) -> float:
    """Distance from the footprint to the nearest blocked square, or less; negative where discs do not tell. [m]"""
    discs = obstacles.footprint.discs
    clearance = np.inf
    for i in range(discs.shape[0]):
        across, along = discs[i, 1], discs[i, 0]
        column, row = cell_position(
            obstacles, x + cos_yaw * along - sin_yaw * across, y + sin_yaw * along + cos_yaw * across
        )
        clearance = min(clearance, free_radius(obstacles, column, row) - discs[i, 2])
    return clearance


@kernel
def _bounds(
    obstacles: Obstacles, part: int, column: float, row: float, cos_yaw: float, sin_yaw: float
) -> tuple[float, float, float, float]:
    """Least and greatest column and row of a part. [cells]"""
    left, right, low, high = np.inf, -np.inf, np.inf, -np.inf
    for i in range(obstacles.footprint.first[part], obstacles.footprint.first[part + 1]):
        along, across = obstacles.footprint.vertices[i]
        x = column + (cos_yaw * along - sin_yaw * across) / obstacles.resolution
        y = row + (sin_yaw * along + cos_yaw * across) / obstacles.resolution
        left, right, low, high = min(left, x), max(right, x), min(low, y), max(high, y)
    return left, right, low, high


@inlined
def _row_is_clear(before: Counts, row: int, first: float, last: float) -> bool:
    """Whether no blocked cell of a row has its centre between two columns; there are none outside the grid."""
    start, stop = math.ceil(first - 0.5), math.floor(last - 0.5)
    if start > stop:
        return True
    if row < 0 or row >= before.shape[0] or start < 0 or stop >= before.shape[1] - 1:
        return False
    return bool(before[row, stop + 1] == before[row, start])


@kernel
def _cut_spans(first: Array, last: Array, normal_x: float, normal_y: float, offset: float, row: float) -> None:
    """Cut spans of columns, one for each row of cells from the given centre on, to the inside of an edge. [cells]"""
    n_rows = first.size
    if abs(normal_x) < TINY:
        for i in range(n_rows):
            if normal_y * (row + i) > offset:
                last[i] = -np.inf
        return
    at, slope = (offset - normal_y * row) / normal_x, normal_y / normal_x
    if normal_x > 0.0:
        for i in range(n_rows):
            last[i] = min(last[i], at - slope * i)
    else:
        for i in range(n_rows):
            first[i] = max(first[i], at - slope * i)


@kernel
def _lay_down(
    obstacles: Obstacles, part: int, column: float, row: float, cos_yaw: float, sin_yaw: float, growth: float
) -> tuple[int, int]:
    """Fill `spans` with the columns of a convex part grown by some cells and a half; its rows, the end excluded.

    The sum of a convex polygon and a square has the edges of both: it touches a blocked square where the square's
    centre lies inside.
    """
    left, right, low, high = _bounds(obstacles, part, column, row, cos_yaw, sin_yaw)
    grown = growth + 0.5
    start, stop = math.ceil(low - grown - 0.5), math.floor(high + grown - 0.5) + 1
    count = max(0, stop - start)
    first, last = obstacles.spans[0, :count], obstacles.spans[1, :count]
    first[:] = left - grown
    last[:] = right + grown
    edges = obstacles.footprint.edges
    for i in range(obstacles.footprint.first[part], obstacles.footprint.first[part + 1]):
        normal_x = cos_yaw * edges[i, 0] - sin_yaw * edges[i, 1]
        normal_y = sin_yaw * edges[i, 0] + cos_yaw * edges[i, 1]
        offset = edges[i, 2] / obstacles.resolution + normal_x * column + normal_y * row
        offset += growth + 0.5 * (abs(normal_x) + abs(normal_y))
        _cut_spans(first, last, normal_x, normal_y, offset, start + 0.5)
    return start, start + count


@kernel
def _first_touched(
    obstacles: Obstacles, part: int, column: float, row: float, cos_yaw: float, sin_yaw: float, growth: float
) -> tuple[int, float, float]:
    """The first row in which a convex part, grown by some cells on all sides, touches blocked squares.

    Returns
    -------
    tuple
        The row, `NOWHERE` if the part is clear, and the first and last column of the part there.
    """
    start, stop = _lay_down(obstacles, part, column, row, cos_yaw, sin_yaw, growth)
    before, spans = obstacles.before, obstacles.spans
    for i in range(start, stop):
        if not _row_is_clear(before, i, spans[0, i - start], spans[1, i - start]):
            return i, spans[0, i - start], spans[1, i - start]
    return NOWHERE, 0.0, 0.0


@kernel
def is_clear(obstacles: Obstacles, x: float, y: float, cos_yaw: float, sin_yaw: float, growth: float) -> bool:
    """Whether the footprint, grown on all sides by its margin and some more, touches no blocked square.

    Corners are grown as mitres: what is called clear is so by the round measure too. Growth by more than twice the
    footprint's reach is never called clear.

    Parameters
    ----------
    obstacles
        What to keep clear of.
    x, y
        Of the mass centre. [m]
    cos_yaw, sin_yaw
        Of the body in the world.
    growth
        Beyond the margin. [m]
    """
    if growth > LARGEST_GROWTH * obstacles.footprint.reach:
        return False
    column, row = cell_position(obstacles, x, y)
    grid_cos = cos_yaw * obstacles.cos_yaw + sin_yaw * obstacles.sin_yaw
    grid_sin = sin_yaw * obstacles.cos_yaw - cos_yaw * obstacles.sin_yaw
    cells = (growth + obstacles.margin) / obstacles.resolution
    for part in range(obstacles.footprint.first.size - 1):
        if _first_touched(obstacles, part, column, row, grid_cos, grid_sin, cells)[0] != NOWHERE:
            return False
    return True


@kernel
def touched_cell(obstacles: Obstacles, x: float, y: float, yaw: float) -> tuple[int, int]:
    """Row and column of a blocked square that the footprint with its margin touches, perhaps one outside the grid.

    The row is `NOWHERE` where it touches none.
    """
    column, row = cell_position(obstacles, x, y)
    cos_yaw, sin_yaw = math.cos(yaw), math.sin(yaw)
    grid_cos = cos_yaw * obstacles.cos_yaw + sin_yaw * obstacles.sin_yaw
    grid_sin = sin_yaw * obstacles.cos_yaw - cos_yaw * obstacles.sin_yaw
    cells = obstacles.margin / obstacles.resolution
    for part in range(obstacles.footprint.first.size - 1):
        i, first, last = _first_touched(obstacles, part, column, row, grid_cos, grid_sin, cells)
        if i != NOWHERE:
            j = math.ceil(first - 0.5)
            while _row_is_clear(obstacles.before, i, j + 0.5, j + 0.5) and j < last:
                j += 1
            return i, j
    return NOWHERE, 0


@kernel
def cleared_movement(obstacles: Obstacles, x: float, y: float, yaw: float, wanted: float) -> float:
    """How far each point of the footprint may move from a pose without touching, as far as is quickly told.

    Parameters
    ----------
    obstacles
        What to keep clear of.
    x, y
        Of the mass centre. [m]
    yaw
        Of the body. [rad]
    wanted
        Enough for the caller. [m]

    Returns
    -------
    float
        At least `wanted` where that is clear, or else negative. [m]
    """
    cos_yaw, sin_yaw = math.cos(yaw), math.sin(yaw)
    by_discs = disc_clearance(obstacles, x, y, cos_yaw, sin_yaw) - obstacles.margin
    if by_discs >= wanted:
        return by_discs
    if wanted <= COARSEST_SCAN * obstacles.resolution and is_clear(obstacles, x, y, cos_yaw, sin_yaw, wanted):
        return wanted
    return -1.0
