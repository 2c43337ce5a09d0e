"""From track speeds to the body's twist by the tracks' instantaneous centres of rotation (ICR).

Track ICRs lie at (x, y_l) and (x, y_r) in the body frame; without slip at (0, B/2) and (0, -B/2). They depend on the
lateral acceleration a and the curvature k that the track speeds ask for, eq. (11) of [1]_, with constant offsets and a
factor on each track speed besides.

References
----------
.. [1] Online slip model identification of tracked vehicles by ICRs and an EKF, 2016, doi 10.1155/2016/6375652.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel

Array = NDArray[np.float64]

#: Least sum of track speeds that a curvature is taken from. [m/s]
LEAST_SPEED = 0.05
#: Least distance of the track ICRs from each other, and largest of each from the body's axes, over the gauge. What is
#: learned at some speeds leads beyond at others.
LEAST_DISTANCE, FARTHEST = 0.2, 5.0


class Icrs(NamedTuple):
    """Left and right y of the track ICRs, and their common x. [m]"""

    left: float
    right: float
    x: float


class Twist(NamedTuple):
    """Velocity of the body in its own frame. [m/s], [m/s], [rad/s]"""

    forward: float
    left: float
    turn: float


@inlined
def lateral_acceleration(gauge: float, left: float, right: float) -> float:
    """Of the track speeds without slip, a = |V_r^2 - V_l^2| / (2 B). [m/s2]"""
    return abs(right * right - left * left) / (2.0 * gauge)


@inlined
def curvature(gauge: float, left: float, right: float) -> float:
    """Of the track speeds without slip, k = 2 |V_r - V_l| / (B (|V_r| + |V_l|)), bounded also at rest. [1/m]"""
    return 2.0 * abs(right - left) / (gauge * max(abs(right) + abs(left), LEAST_SPEED))


@kernel
def icr_positions(p: Array, gauge: float, left: float, right: float) -> Icrs:
    """ICRs of the tracks by the parameters p, at least `LEAST_DISTANCE` gauges apart and `FARTHEST` gauges away."""
    a, k = lateral_acceleration(gauge, left, right), curvature(gauge, left, right)
    far = FARTHEST * gauge
    y_l = min(max(0.5 * gauge + p[0] * a + p[1] * k + p[6], -far), far)
    y_r = min(max(-0.5 * gauge - p[2] * a - p[3] * k + p[7], -far), far)
    if y_l - y_r < LEAST_DISTANCE * gauge:
        half = 0.5 * LEAST_DISTANCE * gauge
        middle = min(max(0.5 * (y_l + y_r), half - far), far - half)
        y_l, y_r = middle + half, middle - half
    return Icrs(y_l, y_r, min(max(p[4] * a + p[5] * k + p[8], -far), far))


@kernel
def icr_stds(P: Array, gauge: float, left: float, right: float) -> Icrs:
    """Standard deviations of the ICRs for a covariance P of the parameters, their bounds left aside. [m]"""
    a, k = lateral_acceleration(gauge, left, right), curvature(gauge, left, right)
    return Icrs(sum_std(P, a, k, 0, 6), sum_std(P, -a, -k, 2, 7), sum_std(P, a, k, 4, 8))


@inlined
def sum_std(P: Array, a: float, k: float, first: int, offset: int) -> float:
    """Standard deviation of a p_i + k p_(i+1) + p_j for i = `first` and j = `offset`."""
    variance = a * a * P[first, first] + k * k * P[first + 1, first + 1] + P[offset, offset]
    variance += 2.0 * (a * k * P[first, first + 1] + a * P[first, offset] + k * P[first + 1, offset])
    return math.sqrt(max(variance, 0.0))


@kernel
def twist_of(p: Array, gauge: float, left: float, right: float) -> Twist:
    """Twist of the body under track speeds, v_x = (V_r y_l - V_l y_r)/d, omega = (V_r - V_l)/d, v_y = -x omega."""
    icrs = icr_positions(p, gauge, left, right)
    V_l, V_r = (1.0 + p[9]) * left, (1.0 + p[10]) * right
    d = icrs.left - icrs.right
    turn = (V_r - V_l) / d
    return Twist((V_r * icrs.left - V_l * icrs.right) / d, -icrs.x * turn, turn)


@kernel
def twist_slopes(p: Array, gauge: float, left: float, right: float, slopes: Array) -> None:
    """Derivatives of the twist by y_l, y_r, x, V_l and V_r, a row each of `slopes`, shape (5, 3).

    a and k count as given: they are of the speeds as measured.
    """
    icrs = icr_positions(p, gauge, left, right)
    V_l, V_r = (1.0 + p[9]) * left, (1.0 + p[10]) * right
    d = icrs.left - icrs.right
    turn = (V_r - V_l) / d
    if d > LEAST_DISTANCE * gauge * (1.0 + 1e-12):
        slopes[0, 0], slopes[0, 2] = -turn * icrs.right / d, -turn / d
        slopes[1, 0], slopes[1, 2] = turn * icrs.left / d, turn / d
    else:  # only the middle moves
        slopes[0, 0], slopes[0, 2] = 0.5 * turn, 0.0
        slopes[1, 0], slopes[1, 2] = 0.5 * turn, 0.0
    slopes[2, 0], slopes[2, 2] = 0.0, 0.0
    slopes[3, 0], slopes[3, 2] = -icrs.right / d, -1.0 / d
    slopes[4, 0], slopes[4, 2] = icrs.left / d, 1.0 / d
    for row in range(5):
        slopes[row, 1] = -icrs.x * slopes[row, 2]
    slopes[2, 1] = -turn


class Arc(NamedTuple):
    """sin(q)/q and (1 - cos q)/q of the angle turned along an arc, and their derivatives by q."""

    sine: float
    cosine: float
    sine_slope: float
    cosine_slope: float


@inlined
def arc(angle: float) -> Arc:
    """The displacement along an arc of constant twist: (S u_x - C u_y, C u_x + S u_y)."""
    if abs(angle) < 1e-4:
        square = angle * angle
        return Arc(1.0 - square / 6.0, 0.5 * angle, -angle / 3.0, 0.5 - square / 8.0)
    sine, cosine = math.sin(angle) / angle, (1.0 - math.cos(angle)) / angle
    return Arc(sine, cosine, (math.cos(angle) - sine) / angle, (math.sin(angle) - cosine) / angle)
