"""Whether start and goal are joined at all: a flood fill over cells that the mass centre might be in."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.planning.collision import HALF_DIAGONAL, Obstacles, cell_position
from trackctl.planning.footprint import Footprint

Array = NDArray[np.float64]
Cells = NDArray[np.int32]


def centred_disc(footprint: Footprint) -> float:
    """Radius of the largest disc about the mass centre within the footprint, 0 if that lies outside. [m]

    Of a polygon in several parts, the largest within one part: less than the true radius, never more.
    """
    inside = [
        float(footprint.edges[first:last, 2].min())
        for first, last in zip(footprint.first[:-1], footprint.first[1:], strict=True)
    ]
    return max(0.0, *inside) if len(inside) > 1 else max(0.0, inside[0])


@kernel
def disc_way(
    obstacles: Obstacles, start: tuple[float, float], goal: tuple[float, float], reach: float, radius: float
) -> Array:
    """Points of the way with the fewest cells that a disc might take; none is certain, for it and all that contains it.

    A cell counts as free unless the disc touches the inner circle of a blocked cell from everywhere in it.

    Parameters
    ----------
    obstacles
        Distances to blocked cells.
    start, goal
        x, y, in the grid. [m]
    reach
        The way may end this far from the goal. [m]
    radius
        Of the disc. [m]

    Returns
    -------
    ndarray, shape (n, 2)
        x, y of cells from the goal to the start, empty where there is no way. [m]
    """
    n_rows, n_columns = obstacles.distance.shape
    needed = radius + obstacles.margin + (0.5 - HALF_DIAGONAL) * obstacles.resolution
    # Of wide cells too, the centre is in none that is blocked.
    needed = max(needed, 0.5 * obstacles.resolution)
    column, row = cell_position(obstacles, start[0], start[1])
    goal_column, goal_row = cell_position(obstacles, goal[0], goal[1])
    target = int(goal_row) * n_columns + int(goal_column)
    near = reach / obstacles.resolution + HALF_DIAGONAL if reach > 0.0 else -1.0
    before = np.full(n_rows * n_columns, -1, np.int32)
    queue = np.empty(n_rows * n_columns, np.int32)
    queue[0] = int(row) * n_columns + int(column)
    before[queue[0]] = queue[0]
    head, tail = 0, 1
    while head < tail and before[target] < 0:
        i, j = queue[head] // n_columns, queue[head] % n_columns
        for k in range(max(i - 1, 0), min(i + 2, n_rows)):
            for m in range(max(j - 1, 0), min(j + 2, n_columns)):
                cell = k * n_columns + m
                # Where neither cell beside a corner is free, nothing gets past the corner.
                passes = obstacles.distance[i, m] >= needed or obstacles.distance[k, j] >= needed
                if before[cell] < 0 and passes and obstacles.distance[k, m] >= needed:
                    before[cell] = queue[head]
                    if before[target] < 0 and math.hypot(m + 0.5 - goal_column, k + 0.5 - goal_row) <= near:
                        target = cell
                    queue[tail] = cell
                    tail += 1
        head += 1
    return _retraced(obstacles, before, target)


@kernel
def _retraced(obstacles: Obstacles, before: Cells, target: int) -> Array:
    """Centres of the cells from the target back to where the fill began."""
    if before[target] < 0:
        return np.empty((0, 2))
    count, cell = 1, target
    while before[cell] != cell:
        cell = before[cell]
        count += 1
    n_columns = obstacles.distance.shape[1]
    points, cell = np.empty((count, 2)), target
    for i in range(count):
        across = (cell % n_columns + 0.5) * obstacles.resolution
        up = (cell // n_columns + 0.5) * obstacles.resolution
        points[i, 0] = obstacles.x + obstacles.cos_yaw * across - obstacles.sin_yaw * up
        points[i, 1] = obstacles.y + obstacles.sin_yaw * across + obstacles.cos_yaw * up
        cell = before[cell]
    return points
