"""Shortest ways between poses for a vehicle that only drives forwards: arc, straight, arc or arc, arc, arc.

Dubins, On curves of minimal length with a constraint on average curvature, and with prescribed initial and terminal
positions and tangents, 1957, doi:10.2307/2372560; closed forms after Shkel and Lumelsky, Classification of the Dubins
set, 2001, doi:10.1016/S0921-8890(00)00127-5.
"""

from __future__ import annotations

import math

import numpy as np

from trackctl.compiled import kernel

FULL_CIRCLE = 2.0 * math.pi
#: A turn this close below the full circle is none, and circles this close to touching do: rounding. [rad], [radii]
ROUNDING = 1e-12

#: Sense of rotation of the three pieces of each word: LSL, RSR, LSR, RSL, RLR, LRL.
WORDS = np.array(
    [[1.0, 0.0, 1.0], [-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, 1.0]]
)
WORD_COUNT = 6


@kernel
def _turn(angle: float) -> float:
    """The angle's equal in [0, 2 pi), a full circle by rounding being none. [rad]"""
    rest = angle - FULL_CIRCLE * math.floor(angle / FULL_CIRCLE)
    return 0.0 if rest > FULL_CIRCLE - ROUNDING else rest


@kernel
def _straight_in_between(x: float, y: float, turn: float, first: float, last: float) -> tuple[float, float, float]:
    """Arc, straight, arc to a pose seen from the start, in radii.

    The straight is the tangent of two unit circles: on the same side as far as the centres, or across.
    """
    across = x - last * math.sin(turn), y - first + last * math.cos(turn)
    squared = across[0] * across[0] + across[1] * across[1]
    apart = first * last < 0.0
    if apart:
        squared -= 4.0
        if squared < -ROUNDING:
            return np.inf, np.inf, np.inf
    straight = math.sqrt(max(squared, 0.0))
    heading = math.atan2(across[1], across[0])
    if apart:
        heading += first * math.atan2(2.0, straight)
    return _turn(first * heading), straight, _turn(last * (turn - heading))


@kernel
def _arc_in_between(x: float, y: float, turn: float, first: float) -> tuple[float, float, float]:
    """Arc, long arc the other way round, arc to a pose seen from the start, in radii."""
    across = x - first * math.sin(turn), y - first + first * math.cos(turn)
    distance = math.hypot(across[0], across[1])
    if distance > 4.0 + ROUNDING:
        return np.inf, np.inf, np.inf
    middle = FULL_CIRCLE - 2.0 * math.asin(min(0.25 * distance, 1.0))
    heading = math.atan2(across[1], across[0])
    begin = _turn(first * heading + 0.5 * middle)
    return begin, middle, _turn(first * turn - begin + middle)


@kernel
def dubins_word(x: float, y: float, turn: float, word: int) -> tuple[float, float, float]:
    """Lengths of a word's three pieces to a pose seen from the start.

    Parameters
    ----------
    x, y
        Of the end in the start's frame, in turning radii.
    turn
        Change of the tangent. [rad]
    word
        Row of `WORDS`.

    Returns
    -------
    tuple
        In turning radii, not negative; infinite where the word does not lead there.
    """
    if word < 4:
        return _straight_in_between(x, y, turn, WORDS[word, 0], WORDS[word, 2])
    return _arc_in_between(x, y, turn, WORDS[word, 0])


@kernel
def seen_from(
    x: float, y: float, tangent: float, end_x: float, end_y: float, end_tangent: float, unit: float
) -> tuple[float, float, float]:
    """A pose in another's frame, lengths in some unit."""
    cos_tangent, sin_tangent = math.cos(tangent), math.sin(tangent)
    dx, dy = (end_x - x) / unit, (end_y - y) / unit
    return cos_tangent * dx + sin_tangent * dy, cos_tangent * dy - sin_tangent * dx, end_tangent - tangent


@kernel
def dubins_length(
    x: float, y: float, tangent: float, end_x: float, end_y: float, end_tangent: float, radius: float
) -> float:
    """Length of the shortest way between two poses. [m]"""
    local_x, local_y, turn = seen_from(x, y, tangent, end_x, end_y, end_tangent, radius)
    shortest = np.inf
    for word in range(WORD_COUNT):
        first, middle, last = dubins_word(local_x, local_y, turn, word)
        shortest = min(shortest, first + middle + last)
    return float(shortest * radius)
