"""Poses along arcs, straights and turns on the spot, in closed form."""

from __future__ import annotations

import math

from trackctl.compiled import kernel

#: Turned by less than this, a chord's length is told by its series. [rad]
SMALL_TURN = 1e-4


@kernel
def wrapped(angle: float) -> float:
    """The angle's equal in [-pi, pi). [rad]"""
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)


@kernel
def advanced(x: float, y: float, tangent: float, curvature: float, length: float) -> tuple[float, float, float]:
    """Pose after an arc or a straight: a chord in the direction halfway.

    Parameters
    ----------
    x, y
        Start. [m]
    tangent
        There. [rad]
    curvature
        Left positive. [1/m]
    length
        Negative backwards. [m]
    """
    half = 0.5 * curvature * length
    chord = length * (1.0 - half * half / 6.0) if abs(half) < SMALL_TURN else length * math.sin(half) / half
    return x + chord * math.cos(tangent + half), y + chord * math.sin(tangent + half), tangent + 2.0 * half
