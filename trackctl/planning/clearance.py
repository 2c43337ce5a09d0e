"""Clearance of a driven path: exact distances between footprint and blocked squares, and proof between the samples."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.planning.collision import HALF_DIAGONAL, Obstacles, cell_position, free_radius, is_clear

Array = NDArray[np.float64]

CORNERS = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])


@inlined
def _distance_to_edge(x: float, y: float, start: Array, end: Array) -> float:
    """From a point to a polygon's edge. [m]"""
    along_x, along_y = end[0] - start[0], end[1] - start[1]
    share = ((x - start[0]) * along_x + (y - start[1]) * along_y) / (along_x * along_x + along_y * along_y)
    share = min(1.0, max(0.0, share))
    return math.hypot(x - start[0] - share * along_x, y - start[1] - share * along_y)


@kernel
def _distance_to_cell(
    obstacles: Obstacles, part: int, column: float, row: float, cos_yaw: float, sin_yaw: float
) -> float:
    """From a convex part at the origin to a square of the grid, 0 if they overlap. [m]

    They overlap unless one of their edges parts them; apart, a corner of the one is nearest to the other.

    Parameters
    ----------
    obstacles
        The footprint and the width of a cell.
    part
        Of the footprint.
    column, row
        Centre of the square from the body's origin, along the grid. [m]
    cos_yaw, sin_yaw
        Of the body in the grid.
    """
    footprint, half = obstacles.footprint, 0.5 * obstacles.resolution
    first, last = footprint.first[part], footprint.first[part + 1]
    nearest, apart = np.inf, False
    low_x, high_x, low_y, high_y = np.inf, -np.inf, np.inf, -np.inf
    for i in range(first, last):
        along, across = footprint.vertices[i]
        x, y = cos_yaw * along - sin_yaw * across - column, sin_yaw * along + cos_yaw * across - row
        low_x, high_x, low_y, high_y = min(low_x, x), max(high_x, x), min(low_y, y), max(high_y, y)
        nearest = min(nearest, math.hypot(max(abs(x) - half, 0.0), max(abs(y) - half, 0.0)))
        normal_x = cos_yaw * footprint.edges[i, 0] - sin_yaw * footprint.edges[i, 1]
        normal_y = sin_yaw * footprint.edges[i, 0] + cos_yaw * footprint.edges[i, 1]
        outside = normal_x * column + normal_y * row - footprint.edges[i, 2] - half * (abs(normal_x) + abs(normal_y))
        apart |= outside > 0.0
    if not apart and low_x <= half and high_x >= -half and low_y <= half and high_y >= -half:
        return 0.0
    for k in range(4):
        corner_x, corner_y = column + 2.0 * half * CORNERS[k, 0], row + 2.0 * half * CORNERS[k, 1]
        body_x, body_y = cos_yaw * corner_x + sin_yaw * corner_y, cos_yaw * corner_y - sin_yaw * corner_x
        for i in range(first, last):
            after = footprint.vertices[i + 1 if i + 1 < last else first]
            nearest = min(nearest, _distance_to_edge(body_x, body_y, footprint.vertices[i], after))
    return nearest


@inlined
def _is_blocked(obstacles: Obstacles, row: int, column: int) -> bool:
    n_rows, n_columns = obstacles.distance.shape
    if row < 0 or row >= n_rows or column < 0 or column >= n_columns:
        return True
    return bool(obstacles.before[row, column + 1] > obstacles.before[row, column])


@kernel
def clearance_at(obstacles: Obstacles, x: float, y: float, yaw: float, bound: float) -> float:
    """Distance from the footprint to the nearest blocked square, or the bound if that is less; 0 where they touch.

    Parameters
    ----------
    obstacles
        Grid and footprint; the margin does not count.
    x, y, yaw
        Of the mass centre and the body. [m], [rad]
    bound
        What is farther need not be told. [m]
    """
    column, row = cell_position(obstacles, x, y)
    resolution, footprint = obstacles.resolution, obstacles.footprint
    if free_radius(obstacles, column, row) - footprint.reach >= bound:
        return bound
    cos_yaw = math.cos(yaw) * obstacles.cos_yaw + math.sin(yaw) * obstacles.sin_yaw
    sin_yaw = math.sin(yaw) * obstacles.cos_yaw - math.cos(yaw) * obstacles.sin_yaw
    window = (footprint.reach + bound) / resolution + HALF_DIAGONAL
    for i in range(math.floor(row - window), math.ceil(row + window) + 1):
        for j in range(math.floor(column - window), math.ceil(column + window) + 1):
            off_x, off_y = (j + 0.5 - column) * resolution, (i + 0.5 - row) * resolution
            farthest = bound + footprint.reach + HALF_DIAGONAL * resolution
            if off_x * off_x + off_y * off_y > farthest * farthest or not _is_blocked(obstacles, i, j):
                continue
            for part in range(footprint.first.size - 1):
                bound = min(bound, _distance_to_cell(obstacles, part, off_x, off_y, cos_yaw, sin_yaw))
    return bound


@kernel
def _least_clearance(obstacles: Obstacles, x: Array, y: Array, yaw: Array, bound: float) -> float:
    for i in range(x.size):
        bound = clearance_at(obstacles, x[i], y[i], yaw[i], bound)
    return bound


def least_clearance(obstacles: Obstacles, x: Array, y: Array, yaw: Array, bound: float = 2.0) -> float:
    """Least distance from the footprint to a blocked square at some poses, the bound if that is less. [m]

    Parameters
    ----------
    obstacles
        Grid and footprint; the margin does not count.
    x, y, yaw : ndarray, shape (n,)
        Of the mass centre and the body. [m], [rad]
    bound
        What is farther need not be told: the time grows with its square. [m]
    """
    return float(_least_clearance(obstacles, *_contiguous(x, y, yaw), bound))


def _contiguous(x: Array, y: Array, yaw: Array) -> tuple[Array, Array, Array]:
    return np.ascontiguousarray(x, float), np.ascontiguousarray(y, float), np.ascontiguousarray(yaw, float)


@kernel
def _first_hit(obstacles: Obstacles, x: Array, y: Array, yaw: Array) -> int:
    for i in range(x.size):
        moved = 0.0
        for k in (i - 1, i + 1):
            if 0 <= k < x.size:
                turned = abs(yaw[k] - yaw[i]) * obstacles.footprint.reach
                moved = max(moved, 0.5 * (math.hypot(x[k] - x[i], y[k] - y[i]) + turned))
        if not is_clear(obstacles, x[i], y[i], math.cos(yaw[i]), math.sin(yaw[i]), moved):
            return i
    return -1


def first_hit(obstacles: Obstacles, x: Array, y: Array, yaw: Array) -> int | None:
    """Index of the first pose at which a sampled path is not proved clear, margin included; None if all of it is.

    The footprint is grown at each sample by half of what it moves to the next and from the last one, so that nothing
    in between is missed: samples should not lie farther apart than a fraction of a cell and of the footprint's reach.

    Parameters
    ----------
    obstacles
        Grid, footprint and margin.
    x, y, yaw : ndarray, shape (n,)
        Of the mass centre and the body, yaw without jumps of full circles. [m], [rad]
    """
    index = _first_hit(obstacles, *_contiguous(x, y, yaw))
    return None if index < 0 else index
