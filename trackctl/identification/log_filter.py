"""The filter over the rows of a log: order, gaps, spikes; and the predictions from each pose, against what came."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.identification.filter_state import MOST_WAITING, POSES, UPDATES, Pose, Ring, State, Update
from trackctl.identification.kalman import forget
from trackctl.identification.kinematics import icr_positions, icr_stds
from trackctl.identification.measurement import take, wrap
from trackctl.identification.slip_model import PARAMETERS
from trackctl.identification.track_history import append, travel, travel_slopes

Array = NDArray[np.float64]

#: A gap is longer than so many mean intervals between track speeds, and than this share of the window.
GAP, LEAST_GAP = 15.0, 0.25
#: Share of a new value in the mean interval and roughness.
NEW = 0.02
#: A track speed is a spike so many times the roughness, and this far, from both its neighbours. [-], [m/s]
SPIKE, LEAST_SPIKE = 8.0, 0.1
#: A pose that repeats the last to the bit, after the tracks have rolled so far, is held by its sensor. [m]
HELD_ROLL = 1e-3
#: Poses that a window spans if it may.
POSES_SPANNED = 3.0
#: Beyond these, numbers are none: track speeds [m/s], coordinates [m], yaw. [rad]
FASTEST, FARTHEST, MOST_TURNED = 1e3, 1e8, 1e6
#: What is learned is forgotten when recent predictions are this much worse than without slip. [-], [m], [rad]
WORSE, WORSE_POSITION, WORSE_HEADING = 1.5, 0.1, 0.05
#: Two times are one within this. [s]
SAME_TIME = 1e-6


@kernel
def advance(state: State, ring: Ring, poses: Ring, updates: Ring, rows: Array) -> None:
    """Take rows of time, left and right track speed, x, y and yaw, shape (n, 6); NaN where there is none."""
    for i in range(rows.shape[0]):
        time, left, right = rows[i, 0], rows[i, 1], rows[i, 2]
        if not go_on_to(state, ring, updates, time):
            state.skipped += 1
            continue
        if abs(left) <= FASTEST and abs(right) <= FASTEST:
            take_speeds(state, ring, time, left, right)
        pose = state.pose
        pose.time, pose.x, pose.y, pose.yaw = time, rows[i, 3], rows[i, 4], rows[i, 5]
        pose.has_position = abs(pose.x) <= FARTHEST and abs(pose.y) <= FARTHEST
        if not pose.has_position:
            pose.x = pose.y = math.nan
        if abs(pose.yaw) <= MOST_TURNED and time > state.last.time:
            if is_held(state, pose):
                state.held += 1
            else:
                take_pose(state, ring, poses, updates, pose)
        give_up(state, ring, updates)


@inlined
def gap_limit(state: State) -> float:
    """Longest time between track speeds that is no gap. [s]"""
    return float(max(GAP * state.interval, LEAST_GAP * state.window))


@kernel
def go_on_to(state: State, ring: Ring, updates: Ring, time: float) -> bool:
    """Let the track speeds hold until a time; False for a row that came late or has no time.

    A clock that jumps back by more than a gap has been set: the history starts anew, what was learned stays.
    """
    if not math.isfinite(time):
        return False
    if state.started and time < state.now:
        if time >= state.now - gap_limit(state):
            return False
        settle_all(state, ring, updates)
        state.started = False
        state.intervals = state.poses = 0
    if not state.started:
        state.started = True
        state.now = state.speeds_at = state.continuous_since = state.updated_at = time
        state.last.time = state.trusted.time = -math.inf
        state.left = state.right = math.nan
    duration = time - state.now
    if duration > 0.0 and math.isfinite(state.left):
        state.intervals = append(ring, state.intervals, state.now, duration, state.left, state.right, state.resolution)
        state.rolled += duration * (abs(state.left) + abs(state.right))
    state.now = time
    return True


@kernel
def take_speeds(state: State, ring: Ring, time: float, left: float, right: float) -> None:
    """Let new track speeds hold from now on, and mend the ones before if they prove to be a spike."""
    since = time - state.speeds_at
    if not math.isfinite(state.left):
        state.left_before, state.right_before = left, right
        state.continuous_since = time
    else:
        if state.interval > 0.0 and since > gap_limit(state):
            state.continuous_since = time
            state.gaps += 1
        if since > 0.0:
            state.interval += (min(since, state.window) - state.interval) * (NEW if state.interval > 0.0 else 1.0)
            mended_left, state.left_roughness = without_spike(state.left_before, state.left, left, state.left_roughness)
            mended_right, state.right_roughness = without_spike(
                state.right_before, state.right, right, state.right_roughness
            )
            last = ring[(state.intervals - 1) % ring.size]
            last.left += (mended_left - state.left) * min(since, last.duration)
            last.right += (mended_right - state.right) * min(since, last.duration)
            state.left_before, state.right_before = mended_left, mended_right
    state.left, state.right, state.speeds_at = left, right, time


@inlined
def without_spike(before: float, held: float, after: float, roughness: float) -> tuple[float, float]:
    """The middle one of three successive speeds, or their median if it is a spike; and the new roughness."""
    median = max(min(before, held), min(max(before, held), after))
    deviation = abs(held - median)
    limit = SPIKE * roughness + LEAST_SPIKE
    roughness += NEW * (min(deviation, limit) - roughness)
    return (median if deviation > limit else held), roughness


@inlined
def is_held(state: State, pose: Pose) -> bool:
    """Whether a sensor gives its last pose once more though the tracks have rolled."""
    last = state.last
    same = pose.yaw == last.yaw and (not pose.has_position or (pose.x == last.x and pose.y == last.y))
    return bool(same and pose.has_position == last.has_position and state.rolled > HELD_ROLL)


@kernel
def take_pose(state: State, ring: Ring, poses: Ring, updates: Ring, pose: Pose) -> None:
    """Update by a pose, and predict from it; predictions that it ends are settled before."""
    if state.now - state.speeds_at > gap_limit(state):
        state.continuous_since = state.now
    follow_poses(state, pose.time - state.last.time)
    rows = take(state, ring, poses, pose)
    if rows >= 0:
        settle_until(state, ring, updates, pose)
        copy_pose(pose, state.trusted)
    if state.updates - state.settled >= MOST_WAITING:
        settle(state, ring, updates[state.settled % UPDATES])
        state.settled += 1
    record(state, updates[state.updates % UPDATES], pose, rows)
    state.updates += 1
    if state.horizon == 0.0:
        state.settled = state.updates
    newest = poses[(state.poses - 1) % POSES]
    if rows >= 0 and (state.poses == 0 or pose.time - newest.time >= state.resolution):
        copy_pose(pose, poses[state.poses % POSES])
        state.poses += 1
    copy_pose(pose, state.last)
    state.rolled = 0.0


@inlined
def follow_poses(state: State, since: float) -> None:
    """Let the window span several poses, within its bounds: one alone would only show a mean velocity."""
    if since <= state.longest_window:
        state.pose_interval += (since - state.pose_interval) * (NEW if state.pose_interval > 0.0 else 1.0)
        spanned = POSES_SPANNED * state.pose_interval
        state.window = min(max(spanned, state.shortest_window), state.longest_window)


@inlined
def copy_pose(source: Pose, target: Pose) -> None:
    """Copy the fields of a pose."""
    target.time, target.x, target.y, target.yaw = source.time, source.x, source.y, source.yaw
    target.has_position = source.has_position


@kernel
def record(state: State, update: Update, pose: Pose, rows: int) -> None:
    """Write down an update, its prediction still open."""
    estimate = state.estimate
    copy_pose(pose, update.pose)
    left, right = (state.left, state.right) if math.isfinite(state.left) else (0.0, 0.0)
    icrs = icr_positions(estimate.p, state.gauge, left, right)
    stds = icr_stds(estimate.P, state.gauge, left, right)
    update.icr[0], update.icr[1], update.icr[2] = icrs.left, icrs.right, icrs.x
    update.icr_std[0], update.icr_std[1], update.icr_std[2] = stds.left, stds.right, stds.x
    update.p[:] = estimate.p
    for i in range(PARAMETERS):
        update.std[i] = math.sqrt(max(estimate.P[i, i], 0.0))
    update.accepted = rows >= 0
    update.innovation[:] = estimate.innovation
    for i in range(3 - abs(rows)):
        update.innovation[i] = math.nan
    update.predicted[:] = math.nan
    update.predicted_std[:] = math.nan
    update.no_slip[:] = math.nan
    update.actual[:] = math.nan
    update.error[:] = math.nan
    update.no_slip_error[:] = math.nan


@kernel
def settle_until(state: State, ring: Ring, updates: Ring, pose: Pose) -> None:
    """Settle the predictions that end before a pose, against the one interpolated between the last and it.

    A rejected pose is none: neither a start nor an end to be judged by.
    """
    last = state.trusted
    while state.settled < state.updates:
        update = updates[state.settled % UPDATES]
        end = update.pose.time + state.horizon
        if end > pose.time + SAME_TIME:
            return
        settle(state, ring, update)
        near = pose.time - last.time <= state.horizon + SAME_TIME or end >= pose.time - SAME_TIME
        if near and update.accepted and update.pose.time >= state.continuous_since:
            compare(update, last, pose, (end - last.time) / (pose.time - last.time))
            doubt(state, update)
        state.settled += 1


@kernel
def compare(update: Update, last: Pose, pose: Pose, part: float) -> None:
    """Compare what was predicted with the pose between two, `part` of the way from the first to the second."""
    actual = update.actual
    actual[2] = last.yaw + part * wrap(pose.yaw - last.yaw)
    if update.pose.has_position and pose.has_position and last.has_position:
        actual[0], actual[1] = last.x + part * (pose.x - last.x), last.y + part * (pose.y - last.y)
    for error, predicted in ((update.error, update.predicted), (update.no_slip_error, update.no_slip)):
        error[0] = math.hypot(predicted[0] - actual[0], predicted[1] - actual[1])
        error[1] = abs(wrap(predicted[2] - actual[2]))


@kernel
def doubt(state: State, update: Update) -> None:
    """Forget what was learned where it has led astray: a log at odds with itself can teach anything."""
    mean, no_slip = state.mean_error, state.mean_no_slip_error
    for i in range(2):
        if math.isfinite(update.error[i]):
            mean[i] += NEW * (update.error[i] - mean[i])
            no_slip[i] += NEW * (update.no_slip_error[i] - no_slip[i])
    if mean[0] > WORSE * no_slip[0] + WORSE_POSITION or mean[1] > WORSE * no_slip[1] + WORSE_HEADING:
        mean[:] = 0.0
        no_slip[:] = 0.0
        if state.learns:
            forget(state.estimate)
            state.resets += 1


@inlined
def into_world(start: Pose, motion: Array, end: Array) -> None:
    """Where a motion from a pose leads, as x, y and yaw."""
    cos, sin = math.cos(start.yaw), math.sin(start.yaw)
    end[0] = start.x + cos * motion[0] - sin * motion[1]
    end[1] = start.y + sin * motion[0] + cos * motion[1]
    end[2] = start.yaw + motion[2]


@kernel
def settle(state: State, ring: Ring, update: Update) -> None:
    """Predict the pose after the horizon, also without slip; with its spread where the parameters stay as they are."""
    start, motion = update.pose, state.motion
    end = start.time + state.horizon
    if state.learns:
        known = travel(ring, state.intervals, update.p, state.gauge, start.time, end, motion.pose)
    else:
        known = travel_slopes(ring, state.intervals, update.p, state.gauge, start.time, end, motion)
        predicted_std(state, start.yaw, update.predicted_std)
    if known:
        into_world(start, motion.pose, update.predicted)
        travel(ring, state.intervals, state.no_slip, state.gauge, start.time, end, state.after)
        into_world(start, state.after, update.no_slip)


@kernel
def predicted_std(state: State, yaw: float, std: Array) -> None:
    """Standard deviation of a predicted pose in the world.

    From the start's noise, the track speeds', the parameters' covariance, and the model's error.
    """
    estimate, motion = state.estimate, state.motion
    H, C, pose = motion.slope, motion.noise, motion.pose
    C *= state.speed_variance
    for i in range(3):
        for j in range(3):
            for k in range(PARAMETERS):
                for m in range(PARAMETERS):
                    C[i, j] += H[i, k] * estimate.P[k, m] * H[j, m]
    heading = state.heading_variance
    own = estimate.position_error * motion.rolled**2 + state.position_variance
    C[0, 0] += own + pose[1] * pose[1] * heading
    C[1, 1] += own + pose[0] * pose[0] * heading
    C[0, 1] -= pose[0] * pose[1] * heading
    C[2, 2] += heading + estimate.heading_error * motion.turned**2
    cos, sin = math.cos(yaw), math.sin(yaw)
    std[0] = math.sqrt(cos * cos * C[0, 0] - 2.0 * sin * cos * C[0, 1] + sin * sin * C[1, 1])
    std[1] = math.sqrt(sin * sin * C[0, 0] + 2.0 * sin * cos * C[0, 1] + cos * cos * C[1, 1])
    std[2] = math.sqrt(C[2, 2])


@kernel
def give_up(state: State, ring: Ring, updates: Ring) -> None:
    """Settle predictions whose later pose can no longer be known."""
    while state.settled < state.updates:
        update = updates[state.settled % UPDATES]
        if state.now <= update.pose.time + 2.0 * state.horizon + SAME_TIME:
            return
        settle(state, ring, update)
        state.settled += 1


@kernel
def settle_all(state: State, ring: Ring, updates: Ring) -> None:
    """Settle all predictions, at the end of a log; the last track speeds hold on."""
    if math.isfinite(state.left) and state.horizon > 0.0:
        state.intervals = append(
            ring, state.intervals, state.now, state.horizon, state.left, state.right, state.resolution
        )
    while state.settled < state.updates:
        settle(state, ring, updates[state.settled % UPDATES])
        state.settled += 1
