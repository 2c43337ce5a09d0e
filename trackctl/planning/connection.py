"""Exact ways between two poses: the cheapest that is free."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import borrowing_kernel
from trackctl.planning.dubins import WORD_COUNT, WORDS, dubins_word, seen_from
from trackctl.planning.pieces import Task, Way, way_cost, way_is_free

Array = NDArray[np.float64]


@borrowing_kernel
def _write_dubins(way: Way, radius: float, word: int, pieces: tuple[float, float, float]) -> None:
    for i in range(3):
        way.curvature[i] = WORDS[word, i] / radius
        way.length[i] = pieces[i] * radius
        way.pivot[i] = 0.0


@borrowing_kernel
def connect(
    task: Task,
    start: tuple[float, float, float, int],
    end: tuple[float, float, float],
    radius: float,
    bound: float,
    way: Way,
) -> tuple[float, int]:
    """The cheapest free way between two poses that the vehicle's gears allow; as `connect_dubins`."""
    return connect_dubins(task, start, end, radius, bound, way)


@borrowing_kernel
def connect_dubins(
    task: Task,
    start: tuple[float, float, float, int],
    end: tuple[float, float, float],
    radius: float,
    bound: float,
    way: Way,
) -> tuple[float, int]:
    """The cheapest free word forwards of one radius.

    Parameters
    ----------
    task
        Obstacles and costs.
    start
        x, y, tangent and gear before. [m], [rad]
    end
        x, y, tangent. [m], [rad]
    radius
        Of the turns. [m]
    bound
        Only what is cheaper counts.
    way
        Is given the pieces.

    Returns
    -------
    tuple
        Its cost, infinite where there is none, and the number of pieces.
    """
    x, y, tangent, gear = start
    local_x, local_y, turn = seen_from(x, y, tangent, end[0], end[1], end[2], radius)
    best, best_word = bound, -1
    for word in range(WORD_COUNT):
        pieces = dubins_word(local_x, local_y, turn, word)
        length = (pieces[0] + pieces[1] + pieces[2]) * radius
        if not length * task.ground.forward.least_rate < best:
            continue
        _write_dubins(way, radius, word, pieces)
        cost = way_cost(task, x, y, tangent, gear, way, 3, best)
        if cost < best and way_is_free(task, x, y, tangent, way, 3):
            best, best_word = cost, word
    if best_word < 0:
        return np.inf, 0
    _write_dubins(way, radius, best_word, dubins_word(local_x, local_y, turn, best_word))
    return best, 3
