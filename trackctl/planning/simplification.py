"""Fewer pieces for a route: runs of short ones replaced by exact connections that hardly cost more."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.planning.connection import connect
from trackctl.planning.pieces import Task, lent_task
from trackctl.planning.polish import CAPACITY, WIDEST, Path, lent_path, measure, new_path, replace_stretch, swap
from trackctl.planning.route import Route

Array = NDArray[np.float64]

#: What a piece less may cost, and all of them together, over the cost of the route.
PRICE, MOST_LOSS = 2e-4, 3e-3
#: Radii that connections try, evenly in their logarithm from the smallest to `WIDEST` times that.
RADII = 14
#: Pieces that one connection replaces, at least and at most.
SHORTEST_RUN, LONGEST_RUN = 3, 12


def simplified(task: Task, route: Route) -> tuple[Route, float]:
    """A route without turns on the spot, with fewer pieces where that costs next to nothing; and its cost.

    Parameters
    ----------
    task
        Of the search that has found the route.
    route
        From start to goal, free and feasible.
    """
    path, count = new_path(), min(route.length.size, CAPACITY)
    for place, values in zip(path.pieces, (route.curvature, route.length, route.pivot), strict=True):
        place[:count] = values[:count]
    path.piece_count[0] = count
    most = (1.0 + MOST_LOSS) * measure(task, path, route.start)
    while simplify(task, path, task.radii[0] * np.geomspace(1.0, WIDEST, RADII), most):
        pass
    count = int(path.piece_count[0])
    return Route(route.start, *(part[:count].copy() for part in path.pieces)), float(path.cost[count])


@kernel
def simplify(task: Task, path: Path, radii: Array, most: float) -> bool:
    """Replace runs of a measured path from its start on, the longest first, up to a cost; whether there were any."""
    task, path = lent_task(task), lent_path(path)
    first, any_replaced = int(np.int64(0)), False  # no literal: numba would compile `_shortened` for it, too
    while first + SHORTEST_RUN <= path.piece_count[0]:
        run = min(LONGEST_RUN, path.piece_count[0] - first)
        while run >= SHORTEST_RUN and not _shortened(task, path, radii, first, run, most):
            run -= 1
        any_replaced |= run >= SHORTEST_RUN
        first += 1
    return any_replaced


@kernel
def _shortened(task: Task, path: Path, radii: Array, first: int, run: int, most: float) -> bool:
    """Replace a run by the cheapest connection of fewer pieces, if there is one that is cheap enough."""
    last, count = first + run, path.piece_count[0]
    start = path.x[first], path.y[first], path.tangent[first], path.gear[first]
    end = path.x[last], path.y[last], path.tangent[last]
    cost, before = path.cost[last] - path.cost[first], path.cost[count]
    bound = min(cost + PRICE * (run - 1) * before, cost + most - before)
    best, radius = bound, 0.0
    for each in radii:
        found, _ = connect(task, start, end, each, best, path.first)
        if found < best:
            best, radius = found, each
    if radius == 0.0:
        return False
    pieces = connect(task, start, end, radius, bound, path.first)[1]
    changed = replace_stretch(path, path.position[first], path.position[last], (pieces, int(np.int64(0))))
    if changed >= count:
        return False
    swap(path, changed)
    path.piece_count[0] = changed
    if measure(task, path, (path.x[0], path.y[0], path.tangent[0])) <= min(
        most, before * (1.0 + PRICE * (count - changed))
    ):
        return True
    swap(path, count)
    path.piece_count[0] = count
    measure(task, path, (path.x[0], path.y[0], path.tangent[0]))
    return False
