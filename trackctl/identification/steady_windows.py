"""Stretches of a log in which the tracks hold their speeds, and the mean twist of the body over each."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Length of a stretch, and how long the speeds must have held before it for the motion to be steady. [s]
LENGTH, LEAD = 1.0, 0.5
#: How far speeds may be from their mean and still hold. [-], [m/s]
HOLDS, HOLDS_AT_REST = 0.1, 0.03
#: Time after which a stretch is tried again where speeds did not hold. [s]
NEXT_TRY = 0.1
#: Longest time between rows, as a share of the stretch.
LONGEST_STEP = 0.5
#: Slowest track that counts as rolling. [m/s]
SLOWEST = 0.02
#: Margin to the half turn of a shoe on the ground that ends the model. [-]
MOST_TURN = 1.25
#: Standard deviation of a pose's coordinates [m] and heading. [rad]
POSITION_STD, HEADING_STD = 0.02, math.radians(0.1)


@dataclass(frozen=True, slots=True, eq=False)
class SteadyWindows:
    """Steady motions, one a row.

    Attributes
    ----------
    speeds : ndarray, shape (n, 2)
        Left and right track speed. [m/s]
    twists : ndarray, shape (n, 3)
        Forward and lateral velocity [m/s] and yaw rate [rad/s] of the mass centre.
    stds : ndarray, shape (3,)
        Of the twists, as far as the sensors go.
    """

    speeds: Array
    twists: Array
    stds: Array


def steady_windows(rows: Array) -> SteadyWindows:
    """The steady stretches of a log, end to end.

    Parameters
    ----------
    rows : ndarray, shape (n, 6)
        Time [s], left and right track speed [m/s], x, y [m] and yaw [rad] of the mass centre; NaN where there is none.
    """
    rows = rows[np.isfinite(rows[:, :3]).all(axis=1)]
    rows = rows[np.append(True, np.diff(np.maximum.accumulate(rows[:, 0])) > 0.0)] if len(rows) else rows
    time, speeds, poses = rows[:, 0], rows[:, 1:3], rows[:, 3:]
    posed = np.flatnonzero(np.isfinite(poses).all(axis=1))
    found_speeds, twists, end = [], [], -math.inf
    for start in posed:
        if time[start] < end or time[start] < time[0] + LEAD:
            continue
        first = np.searchsorted(time, time[start] - LEAD)
        last = posed[np.searchsorted(time[posed], time[start] + LENGTH - 1e-6) :][:1]
        if not last.size or time[last[0]] > time[start] + 2.0 * LENGTH:
            continue
        stretch = slice(first, last[0] + 1)
        if not holds(time[stretch], speeds[stretch]):
            end = time[start] + NEXT_TRY
            continue
        end, duration = time[last[0]], time[last[0]] - time[start]
        found_speeds.append(np.average(speeds[start : last[0]], axis=0, weights=np.diff(time[start : last[0] + 1])))
        twists.append(body_displacement(poses[start], poses[last[0]]) / duration)
    noise = math.sqrt(2.0) / LENGTH
    stds = noise * np.array([POSITION_STD, POSITION_STD, HEADING_STD])
    return SteadyWindows(np.reshape(found_speeds, (-1, 2)), np.reshape(twists, (-1, 3)), stds)


def holds(time: Array, speeds: Array) -> bool:
    """Whether the track speeds hold, without a gap in them."""
    mean = speeds.mean(axis=0)
    off = np.abs(speeds - mean).max(axis=0)
    close = np.all(off <= HOLDS * np.abs(mean) + HOLDS_AT_REST)
    return bool(close and np.diff(time).max(initial=0.0) <= LONGEST_STEP * LENGTH)


def body_displacement(start: Array, end: Array) -> Array:
    """The constant twist, times its duration, that leads from one pose to another: the logarithm of SE(2)."""
    dx, dy = end[:2] - start[:2]
    turned = math.remainder(end[2] - start[2], 2.0 * math.pi)
    cos, sin = math.cos(start[2]), math.sin(start[2])
    x, y = cos * dx + sin * dy, cos * dy - sin * dx
    half = 0.5 * turned
    cotangent = half / math.tan(half) if abs(half) > 1e-6 else 1.0 - half * half / 3.0
    return np.array([cotangent * x + half * y, cotangent * y - half * x, turned])


def within_model(windows: SteadyWindows, contact_length: float) -> tuple[SteadyWindows, NDArray[np.bool_]]:
    """The stretches that the slope-steering model may hold for, all made forward, and which of them went backward.

    Driving backward is driving forward for a vehicle that looks the other way: its left track is the right one, and
    the velocities change sign. Outside the model are a track that stands still or turns against the other, and a shoe
    that turns by half a turn while on the ground.
    """
    slowest = np.maximum(SLOWEST, MOST_TURN * np.abs(windows.twists[:, 2]) * contact_length / math.pi)
    forward = np.all(windows.speeds > slowest[:, None], axis=1)
    backward = np.all(windows.speeds < -slowest[:, None], axis=1)
    kept = forward | backward
    back = backward[kept]
    speeds, twists = windows.speeds[kept].copy(), windows.twists[kept].copy()
    speeds[back] = -speeds[back][:, ::-1]
    twists[back, :2] *= -1.0
    return SteadyWindows(speeds, twists, windows.stds), back
