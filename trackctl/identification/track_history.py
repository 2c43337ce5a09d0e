"""The track speeds of the last while, in a ring of intervals, and the motion that they make."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.identification.kinematics import arc, curvature, lateral_acceleration, twist_of, twist_slopes
from trackctl.identification.slip_model import PARAMETERS

Array = NDArray[np.float64]

#: Intervals kept: a minute at the finest resolution.
INTERVALS = 4096
INTERVAL = np.dtype(
    [
        ("start", np.float64),  # [s]
        ("duration", np.float64),  # [s]
        ("left", np.float64),  # distance that the left track rolls, and the right one [m]
        ("right", np.float64),
        ("squares", np.float64),  # sum of the squared durations of its rows [s2]
    ],
    align=True,
)
#: A ring of `INTERVAL`; the newest is number `count` - 1, in place (count - 1) % INTERVALS.
Ring = NDArray[np.void]

#: Motion over a stretch of time, in the body frame at its start.
MOTION = np.dtype(
    [
        ("pose", np.float64, 3),  # x, y, heading at the end [m, m, rad]
        ("slope", np.float64, (3, PARAMETERS)),  # of the pose, by the parameters
        ("noise", np.float64, (3, 3)),  # covariance of the pose, for track speeds with a variance of 1 (m/s)^2
        ("rolled", np.float64),  # mean distance that the tracks rolled, either way [m]
        ("turned", np.float64),  # their difference over the gauge, either way [rad]
        ("by_twist", np.float64, (5, 3)),  # workspace
    ],
    align=True,
)
Motion = Any


def ring() -> Ring:
    """An empty ring."""
    return np.zeros(INTERVALS, INTERVAL)


@kernel
def append(ring: Ring, count: int, start: float, duration: float, left: float, right: float, resolution: float) -> int:
    """Add track speeds that held for a while, to the last interval if that is short; returns the new count."""
    last = ring[(count - 1) % INTERVALS]
    if count == 0 or last.duration + 0.5 * duration > resolution:
        last = ring[count % INTERVALS]
        count += 1
        last.start, last.duration, last.left, last.right, last.squares = start, 0.0, 0.0, 0.0, 0.0
    last.duration += duration
    last.left += left * duration
    last.right += right * duration
    last.squares += duration * duration
    return count


@kernel
def first_at(ring: Ring, count: int, time: float) -> int:
    """Number of the interval that holds a time, or -1 where the ring does not reach back to it."""
    oldest = max(0, count - INTERVALS)
    for number in range(count - 1, oldest - 1, -1):
        if ring[number % INTERVALS].start <= time:
            return number
    return -1


@kernel
def travel(ring: Ring, count: int, p: Array, gauge: float, start: float, end: float, pose: Array) -> bool:
    """Pose after the motion from one time to another, by exact arcs; False where the ring does not reach back so far.

    The newest speeds hold on beyond the last interval.
    """
    x = y = heading = 0.0
    first = first_at(ring, count, start)
    for number in range(first, count if first >= 0 else first):
        part = ring[number % INTERVALS]
        duration = overlap(part, start, end, number == count - 1)
        u = twist_of(p, gauge, part.left / part.duration, part.right / part.duration)
        u_x, u_y, angle = u.forward * duration, u.left * duration, u.turn * duration
        along = arc(angle)
        dx, dy = along.sine * u_x - along.cosine * u_y, along.cosine * u_x + along.sine * u_y
        sin, cos = math.sin(heading), math.cos(heading)
        x += cos * dx - sin * dy
        y += sin * dx + cos * dy
        heading += angle
    pose[0], pose[1], pose[2] = x, y, heading
    return first >= 0


@inlined
def overlap(part: Any, start: float, end: float, is_last: bool) -> float:
    """How long an interval lasts between two times; the last one goes on."""
    ended = end if is_last else min(end, part.start + part.duration)
    return float(max(ended - max(start, part.start), 0.0))


@kernel
def travel_slopes(ring: Ring, count: int, p: Array, gauge: float, start: float, end: float, motion: Motion) -> bool:
    """As `travel`, with the derivatives of the pose by the parameters and its noise by that of the track speeds.

    What turns the body by dq in one interval moves the end by dq x (end - place of the interval's end): the place is
    known on the way, the end is put in last.
    """
    x = y = heading = 0.0
    H, slopes, C = motion.slope, motion.by_twist, motion.noise
    H[:] = 0.0
    C[:] = 0.0
    motion.rolled = motion.turned = 0.0
    first = first_at(ring, count, start)
    for number in range(first, count if first >= 0 else first):
        part = ring[number % INTERVALS]
        duration = overlap(part, start, end, number == count - 1)
        left, right = part.left / part.duration, part.right / part.duration
        u = twist_of(p, gauge, left, right)
        u_x, u_y, angle = u.forward * duration, u.left * duration, u.turn * duration
        along = arc(angle)
        dx, dy = along.sine * u_x - along.cosine * u_y, along.cosine * u_x + along.sine * u_y
        dx_turn = along.sine_slope * u_x - along.cosine_slope * u_y
        dy_turn = along.cosine_slope * u_x + along.sine_slope * u_y
        sin, cos = math.sin(heading), math.cos(heading)
        x += cos * dx - sin * dy
        y += sin * dx + cos * dy
        heading += angle
        motion.rolled += 0.5 * (abs(left) + abs(right)) * duration
        motion.turned += abs(right - left) / gauge * duration
        twist_slopes(p, gauge, left, right, slopes)
        for row in range(5):
            f, s, turn = slopes[row, 0] * duration, slopes[row, 1] * duration, slopes[row, 2] * duration
            ex = along.sine * f - along.cosine * s + dx_turn * turn
            ey = along.cosine * f + along.sine * s + dy_turn * turn
            slopes[row, 0] = cos * ex - sin * ey + y * turn
            slopes[row, 1] = sin * ex + cos * ey - x * turn
            slopes[row, 2] = turn
        add_slopes(H, slopes, lateral_acceleration(gauge, left, right), curvature(gauge, left, right), left, right)
        if duration > 0.0:
            add_noise(C, slopes, part.squares / (part.duration * duration))
    for column in range(PARAMETERS):
        H[0, column] -= y * H[2, column]
        H[1, column] += x * H[2, column]
    turn_noise_about_end(C, x, y)
    motion.pose[0], motion.pose[1], motion.pose[2] = x, y, heading
    return first >= 0


@kernel
def mean_twist(ring: Ring, count: int, p: Array, gauge: float, start: float, end: float, motion: Motion) -> bool:
    """The mean twist over a while, times its duration, in place of the pose of `travel_slopes`."""
    left = right = squares = total = 0.0
    H, slopes, C = motion.slope, motion.by_twist, motion.noise
    H[:] = 0.0
    C[:] = 0.0
    first = first_at(ring, count, start)
    for number in range(first, count if first >= 0 else first):
        part = ring[number % INTERVALS]
        duration = overlap(part, start, end, number == count - 1)
        share = duration / part.duration
        left += part.left * share
        right += part.right * share
        squares += part.squares * share
        total += duration
    if total <= 0.0:
        return False
    left, right = left / total, right / total
    u = twist_of(p, gauge, left, right)
    motion.pose[0], motion.pose[1], motion.pose[2] = u.forward * total, u.left * total, u.turn * total
    motion.rolled = 0.5 * (abs(left) + abs(right)) * total
    motion.turned = abs(right - left) / gauge * total
    twist_slopes(p, gauge, left, right, slopes)
    slopes *= total
    add_slopes(H, slopes, lateral_acceleration(gauge, left, right), curvature(gauge, left, right), left, right)
    add_noise(C, slopes, squares / (total * total))
    return True


@kernel
def add_slopes(H: Array, slopes: Array, a: float, k: float, left: float, right: float) -> None:
    """Add to H, by the parameters, what `slopes` has by y_l, y_r, x, V_l and V_r, shape (5, 3)."""
    for i in range(3):
        y_l, y_r, x = slopes[0, i], slopes[1, i], slopes[2, i]
        H[i, 0] += a * y_l
        H[i, 1] += k * y_l
        H[i, 2] -= a * y_r
        H[i, 3] -= k * y_r
        H[i, 4] += a * x
        H[i, 5] += k * x
        H[i, 6] += y_l
        H[i, 7] += y_r
        H[i, 8] += x
        H[i, 9] += left * slopes[3, i]
        H[i, 10] += right * slopes[4, i]


@kernel
def add_noise(C: Array, slopes: Array, variance: float) -> None:
    """Add the covariance that independent track speeds of this variance make."""
    for row in range(3, 5):
        for i in range(3):
            for j in range(3):
                C[i, j] += variance * slopes[row, i] * slopes[row, j]


@kernel
def turn_noise_about_end(C: Array, x: float, y: float) -> None:
    """Put the end into a covariance summed without it: T C T' with T = [[1, 0, -y], [0, 1, x], [0, 0, 1]]."""
    for j in range(3):
        C[0, j] -= y * C[2, j]
        C[1, j] += x * C[2, j]
    for i in range(3):
        C[i, 0] -= y * C[i, 2]
        C[i, 1] += x * C[i, 2]
