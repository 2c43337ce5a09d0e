"""Exact ways between two poses: the cheapest that is free."""

from __future__ import annotations

import math

import numpy as np

from trackctl.compiled import inlined, kernel
from trackctl.planning import reeds_shepp
from trackctl.planning.dubins import WORD_COUNT, WORDS, dubins_word, seen_from
from trackctl.planning.pieces import Task, Way, pivot_cost, way_cost, way_is_free
from trackctl.planning.pose import wrapped

#: Words tried at most, in the order of their lengths.
TRIED = 8
#: Numbers of the first word of each kind: Dubins' forwards and backwards, those of Reeds and Shepp, and turns on the
#: spot with a straight between them, forwards and backwards; and of all.
BACKWARDS, BOTH_GEARS = WORD_COUNT, 2 * WORD_COUNT
TURNS = BOTH_GEARS + reeds_shepp.WORD_COUNT
TURNS_BACKWARDS, ALL_WORDS = TURNS + 1, TURNS + 2

Pose = tuple[float, float, float]


@kernel
def _write_dubins(local: Pose, word: int, way: Way) -> int:
    pieces = dubins_word(local[0], local[1], local[2], word)
    if pieces[1] == np.inf:
        return 0
    for i in range(3):
        way.curvature[i], way.length[i], way.pivot[i] = WORDS[word, i], pieces[i], 0.0
    return 3


@kernel
def _write_turns(local: Pose, forth: float, way: Way) -> int:
    heading = math.atan2(forth * local[1], forth * local[0])
    way.curvature[:3] = 0.0
    way.length[0], way.length[1], way.length[2] = 0.0, forth * math.hypot(local[0], local[1]), 0.0
    way.pivot[0], way.pivot[1], way.pivot[2] = wrapped(heading), 0.0, wrapped(local[2] - heading)
    return 3


@kernel
def _write(local: Pose, radius: float, word: int, way: Way) -> int:
    """Write a word to a pose seen from the start in turning radii; the number of pieces, 0 where it does not exist."""
    sense = 1.0
    if word < BACKWARDS:
        count = _write_dubins(local, word, way)
    elif word < BOTH_GEARS:
        sense, count = -1.0, _write_dubins((-local[0], local[1], -local[2]), word - BACKWARDS, way)
    elif word < TURNS:
        count = reeds_shepp.write_word(local[0], local[1], local[2], word - BOTH_GEARS, way)
    else:
        count = _write_turns(local, 1.0 if word == TURNS else -1.0, way)
    for i in range(count):
        way.curvature[i] /= radius
        way.length[i] *= sense * radius
    return count


@kernel
def _estimate(task: Task, gear: int, way: Way, count: int) -> float:
    """Least cost that some pieces may have."""
    if count == 0:
        return np.inf
    length, cusps = reeds_shepp.length_and_cusps(way, count)
    turning = 0.0
    for i in range(count):
        if way.pivot[i] != 0.0:
            turning += pivot_cost(task, way.pivot[i])
    changes = cusps + (1 if gear * way.length[0] < 0.0 else 0)
    return float(length * task.least_rate + (changes * task.gear_change if changes else 0.0) + turning)


@inlined
def _is_allowed(task: Task, word: int) -> bool:
    """Whether the vehicle can do what a word asks for."""
    if word >= TURNS and task.pivot_rate == np.inf:
        return False
    return task.can_reverse or word < BACKWARDS or word == TURNS


@kernel
def _estimate_all(task: Task, gear: int, local: Pose, radius: float, way: Way) -> int:
    """Note the least cost of every word, infinite where it does not exist or cannot be driven; the number of words."""
    count = ALL_WORDS if task.can_reverse or task.pivot_rate < np.inf else BACKWARDS
    for word in range(count):
        task.estimates[word] = np.inf
        if _is_allowed(task, word):
            task.estimates[word] = _estimate(task, gear, way, _write(local, radius, word, way))
    return count


@kernel
def connect(
    task: Task,
    start: tuple[float, float, float, int],
    end: tuple[float, float, float],
    radius: float,
    bound: float,
    way: Way,
) -> tuple[float, int]:
    """The cheapest free word of one radius: Dubins', with a reverse gear Reeds and Shepp's, or turns on the spot.

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
    local = seen_from(x, y, tangent, end[0], end[1], end[2], radius)
    words = task.estimates[: _estimate_all(task, gear, local, radius, way)]
    best, best_word = bound, int(np.int64(-1))  # no literal: numba would compile `_write` for it, too
    for _ in range(TRIED):
        word = int(np.argmin(words))
        if not words[word] < best:
            break
        words[word] = np.inf
        count = _write(local, radius, word, way)
        cost = way_cost(task, x, y, tangent, gear, way, count, best)
        if cost < best and way_is_free(task, x, y, tangent, way, count):
            best, best_word = cost, word
    if best_word < 0:
        return np.inf, 0
    return best, _write(local, radius, best_word, way)
