"""Whether start and goal are joined at all: a flood fill over cells that the mass centre might be in."""

from __future__ import annotations

import numpy as np

from trackctl.compiled import kernel
from trackctl.planning.collision import HALF_DIAGONAL, Obstacles, cell_position
from trackctl.planning.footprint import Footprint


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
def are_joined(obstacles: Obstacles, start: tuple[float, float], goal: tuple[float, float], radius: float) -> bool:
    """Whether a disc might get from one point to another; no is certain, for it and all that contains it.

    A cell counts as free unless the disc touches a blocked cell's centre from everywhere in it.

    Parameters
    ----------
    obstacles
        Distances to blocked cells.
    start, goal
        x, y, in the grid. [m]
    radius
        Of the disc. [m]
    """
    n_rows, n_columns = obstacles.distance.shape
    needed = radius + obstacles.margin - HALF_DIAGONAL * obstacles.resolution
    column, row = cell_position(obstacles, start[0], start[1])
    goal_column, goal_row = cell_position(obstacles, goal[0], goal[1])
    target = int(goal_row) * n_columns + int(goal_column)
    seen = np.zeros(n_rows * n_columns, np.bool_)
    queue = np.empty(n_rows * n_columns, np.int32)
    queue[0] = int(row) * n_columns + int(column)
    seen[queue[0]] = True
    head, tail = 0, 1
    while head < tail and not seen[target]:
        i, j = queue[head] // n_columns, queue[head] % n_columns
        head += 1
        for k in range(max(i - 1, 0), min(i + 2, n_rows)):
            for m in range(max(j - 1, 0), min(j + 2, n_columns)):
                cell = k * n_columns + m
                if not seen[cell] and obstacles.distance[k, m] >= needed:
                    seen[cell] = True
                    queue[tail] = cell
                    tail += 1
    return bool(seen[target])
