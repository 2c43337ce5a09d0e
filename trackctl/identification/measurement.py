"""From a pose in the log to an update of the parameters: windows, innovations, their noise, gate and guard."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.identification.filter_state import POSES, Pose, Ring, State
from trackctl.identification.kalman import (
    HEADING,
    HEADING_GATE,
    HEADING_ROWS,
    MOST_REJECTIONS,
    POSE_GATE,
    POSE_ROWS,
    accept,
    add_model_error,
    drift,
    misfit,
    try_update,
    widen,
)
from trackctl.identification.track_history import mean_twist, travel, travel_slopes

Array = NDArray[np.float64]

#: A window may be shorter than asked for by this factor.
SHORTEST_WINDOW = 0.5
#: How often an update that overshoots is taken back, and by how much R grows each time.
RETREATS, RETREAT = 6, 4.0
#: Growth of the misfit that an update may cause, as when it is at rounding. [-]
SLACK = 0.01


@inlined
def wrap(angle: float) -> float:
    """The angle within half a turn. [rad]"""
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)


@kernel
def window_start(state: State, poses: Ring, time: float) -> int:
    """Number of the pose whose age is nearest to the window, or of the newest for velocities; -1 if there is none."""
    best, nearest = -1, math.inf
    for number in range(state.poses - 1, max(0, state.poses - POSES) - 1, -1):
        pose_time = poses[number % POSES].time
        off = abs(time - pose_time - state.window)
        if pose_time < state.continuous_since or off > nearest:
            break
        best, nearest = number, off
        if state.by_velocity:
            return best
    if best >= 0 and time - poses[best % POSES].time < SHORTEST_WINDOW * state.window:
        return -1
    return best


@kernel
def measured_motion(state: State, start: Pose, pose: Pose, predicted_turn: float, z: Array) -> None:
    """Pose change in the frame of the window's start, or of its middle for velocities."""
    turned = wrap(pose.yaw - start.yaw - predicted_turn) + predicted_turn
    frame = start.yaw + 0.5 * turned if state.by_velocity else start.yaw
    cos, sin = math.cos(frame), math.sin(frame)
    dx, dy = pose.x - start.x, pose.y - start.y
    z[0], z[1], z[2] = cos * dx + sin * dy, cos * dy - sin * dx, turned


@kernel
def add_sensor_noise(state: State, z: Array, R: Array) -> None:
    """R = G S G' + S of a window: the start's heading has a lever arm, half of both ends' in the middle frame."""
    position, heading = state.position_variance, state.heading_variance
    lever = 0.5 if state.by_velocity else 1.0
    R[0, 0] += 2.0 * position + lever * z[1] * z[1] * heading
    R[1, 1] += 2.0 * position + lever * z[0] * z[0] * heading
    R[2, 2] += 2.0 * heading
    R[0, 1] -= lever * z[0] * z[1] * heading
    R[1, 0] = R[0, 1]
    if not state.by_velocity:  # there the two ends cancel
        R[0, 2] -= z[1] * heading
        R[1, 2] += z[0] * heading
        R[2, 0], R[2, 1] = R[0, 2], R[1, 2]


@kernel
def measure(state: State, ring: Ring, poses: Ring, pose: Pose) -> int:
    """Innovation, H and R of a pose in the estimate; returns the number of rows, 0 where there is nothing to compare.

    Overlapping windows share their errors: R grows by how many of them there are.
    """
    estimate, motion = state.estimate, state.motion
    number = window_start(state, poses, pose.time)
    if number < 0:
        return 0
    start = poses[number % POSES]
    if state.by_velocity:
        known = mean_twist(ring, state.intervals, estimate.p, state.gauge, start.time, pose.time, motion)
    else:
        known = travel_slopes(ring, state.intervals, estimate.p, state.gauge, start.time, pose.time, motion)
    if not known:
        return 0
    z, R = state.measured, estimate.R
    measured_motion(state, start, pose, motion.pose[HEADING], z)
    if not (pose.has_position and start.has_position):
        z[0], z[1] = motion.pose[0], motion.pose[1]
    for i in range(3):
        estimate.innovation[i] = z[i] - motion.pose[i]
        for j in range(3):
            R[i, j] = state.speed_variance * motion.noise[i, j]
    estimate.H[:] = motion.slope
    add_sensor_noise(state, z, R)
    state.window_began = start.time
    return POSE_ROWS if pose.has_position and start.has_position else HEADING_ROWS


@kernel
def is_finite(values: Array) -> bool:
    """Whether all values are finite."""
    finite = True
    for value in values:
        finite = finite and math.isfinite(value)
    return finite


@kernel
def take(state: State, ring: Ring, poses: Ring, pose: Pose) -> int:
    """Update the estimate by a pose; returns the number of rows that `measure` found, negative where refused."""
    estimate = state.estimate
    since = min(pose.time - state.updated_at, state.window)
    state.updated_at = pose.time
    if not state.learns:
        return 0
    drift(estimate, since)
    rows = measure(state, ring, poses, pose)
    if rows == 0:
        return 0
    if not is_finite(estimate.innovation):
        return -rows
    add_model_error(estimate, rows, state.motion.rolled, state.motion.turned, since)
    sharing = max(1.0, (pose.time - state.window_began) / since)
    chi_square = try_update(estimate, rows, sharing)
    if state.gates and not chi_square <= (POSE_GATE if rows == POSE_ROWS else HEADING_GATE):
        estimate.rejections += 1
        if estimate.rejections <= MOST_REJECTIONS or not math.isfinite(chi_square):
            return -rows
        widen(estimate)
        try_update(estimate, rows, sharing)
    if not guarded(state, ring, pose, rows, sharing):
        return -rows
    accept(estimate)
    return rows


@kernel
def guarded(state: State, ring: Ring, pose: Pose, rows: int, sharing: float) -> bool:
    """Shorten the trial update until the measurement fits better after it than before.

    Over a window of several radians a linear step may overshoot, to ICRs that turn the body the wrong way round.
    """
    estimate, innovation = state.estimate, state.after
    scale = sharing
    before = misfit(estimate, rows, estimate.innovation) * scale
    for _ in range(RETREATS):
        if state.by_velocity:
            known = mean_twist(
                ring, state.intervals, estimate.trial_p, state.gauge, state.window_began, pose.time, state.motion
            )
            for i in range(3):
                innovation[i] = state.measured[i] - state.motion.pose[i]
        else:
            known = travel(
                ring, state.intervals, estimate.trial_p, state.gauge, state.window_began, pose.time, innovation
            )
            for i in range(3):
                innovation[i] = state.measured[i] - innovation[i]
        if known and misfit(estimate, rows, innovation) * scale <= before * (1.0 + SLACK) + SLACK:
            return True
        scale *= RETREAT
        try_update(estimate, rows, scale)
    return False
