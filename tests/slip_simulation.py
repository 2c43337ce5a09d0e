"""Logs of simulated vehicles with known slip, and the errors of predictions, written apart from the package."""

from __future__ import annotations

import numpy as np

from trackctl.identification.identifier import FilterSettings, LogFilter
from trackctl.identification.slip_model import FilterKind, SlipModel

GAUGE = 2.464
HEADER = "time_s,track_speed_left_mps,track_speed_right_mps,x_m,y_m,yaw_rad"
POSITION_STD, HEADING_STD, SPEED_STD = 0.02, np.radians(0.1), 0.02


def step(pose, forward, left, turn, duration):
    """Pose after a constant twist, by the closed form of the circle."""
    x, y, yaw = pose
    angle = turn * duration
    if abs(angle) < 1e-9:
        dx, dy = forward * duration, left * duration
    else:
        sin, cos = np.sin(angle), np.cos(angle)
        dx, dy = (sin * forward - (1 - cos) * left) / turn, ((1 - cos) * forward + sin * left) / turn
    return x + np.cos(yaw) * dx - np.sin(yaw) * dy, y + np.sin(yaw) * dx + np.cos(yaw) * dy, yaw + angle


def drive(time, left, right, y_left, y_right, x):
    """Poses under track speeds with given ICRs, each holding until the next time; shape (n, 3)."""
    poses = [(0.0, 0.0, 0.0)]
    for i, duration in enumerate(np.diff(time)):
        d = y_left[i] - y_right[i]
        turn = (right[i] - left[i]) / d
        forward = (right[i] * y_left[i] - left[i] * y_right[i]) / d
        poses.append(step(poses[-1], forward, -x[i] * turn, turn, duration))
    return np.array(poses)


def log(time, left, right, poses, seed, pose_every=1, noise=1.0):
    """Rows of a log with the paper's sensor noise; poses only in every so many rows."""
    random = np.random.default_rng(seed)
    speeds = np.column_stack((left, right)) + noise * SPEED_STD * random.standard_normal((len(time), 2))
    std = [POSITION_STD, POSITION_STD, HEADING_STD]
    measured = poses + noise * random.standard_normal(poses.shape) * std
    measured[np.arange(len(time)) % pose_every != 0] = np.nan
    return np.column_stack((time, speeds, measured))


def abrupt_change(seed, pose_every=1, noise=1.0, end=14.0):
    """The paper's case 4.1 (4.2 with poses every 10 rows): straight for 2 s, then a turn with other ICRs."""
    time = 0.1 * np.arange(round(end / 0.1) + 1)
    turning = time >= 2.0 - 1e-9
    left, right = np.full_like(time, 2.0), np.where(turning, 1.0, 2.0)
    y, x = np.where(turning, 2.232, 1.232), np.where(turning, 0.5, 0.0)
    return log(time, left, right, drive(time, left, right, y, -y, x), seed, pose_every, noise)


def locked_track(seed):
    """Like the paper's case 5.2: the left track locked, ICRs that no parameters of the model make."""
    time = 0.1 * np.arange(180)
    turning = (time > 2.0) & (time < 14.0)
    left, right = np.where(turning, 0.0, 1.5), np.where(turning, 2.0 + 0.2 * np.sin(1.1 * time), 1.5)
    turn = np.abs(right - left) / GAUGE
    y_left = 0.5 * GAUGE + 0.45 * turn**0.7 + 0.08 * np.sin(0.7 * time)
    y_right = -0.5 * GAUGE - 0.05 * turn**0.7
    x = 0.75 * np.tanh(1.5 * turn) + 0.06 * np.sin(0.9 * time + 1.0)
    return log(time, left, right, drive(time, left, right, y_left, y_right, x), seed)


def many_turns(seed, rows=1200, interval=0.1, pose_every=1):
    """Random track speeds, each for 5 s, and ICRs that the parametric model can make."""
    random = np.random.default_rng(seed)
    time, hold = interval * np.arange(rows), round(5.0 / interval)
    left, right = (np.repeat(random.uniform(0.5, 2.5, rows // hold + 1), hold)[:rows] for _ in range(2))
    y = 0.65 * GAUGE + 0.1 * np.abs(right**2 - left**2) / (2.0 * GAUGE)
    return log(time, left, right, drive(time, left, right, y, -y, np.full(rows, 0.2)), seed, pose_every)


def as_csv(rows):
    """A log's text."""
    cells = (["" if np.isnan(value) else repr(value) for value in row] for row in rows.tolist())
    return "\n".join([HEADER, *(",".join(row) for row in cells)]) + "\n"


def learn(rows, gauge=GAUGE, model="parametric", kind="window", window=None, horizon=2.0):
    """All updates of a log, and the filter at its end."""
    learner = LogFilter(FilterSettings(gauge, SlipModel(model), FilterKind(kind), window, horizon))
    return np.concatenate([learner.feed(rows), learner.finish()]), learner


def mean_errors(updates, since=0.0):
    """Means of position and heading error with slip and without, shape (2, 2)."""
    known = np.isfinite(updates["error"]).all(axis=1) & (updates["pose"]["time"] >= since)
    return np.array([updates[name][known].mean(axis=0) for name in ("error", "no_slip_error")])


def reductions(errors):
    """By how much the model reduces the errors. [%]"""
    return 100.0 * (1.0 - errors[0] / errors[1])


def twist(p, gauge, left, right):
    """The model of the document, once more."""
    a, k = abs(right**2 - left**2) / (2 * gauge), 2 * abs(right - left) / (gauge * max(abs(right) + abs(left), 0.05))
    y_left, y_right = gauge / 2 + p[0] * a + p[1] * k + p[6], -gauge / 2 - p[2] * a - p[3] * k + p[7]
    x = p[4] * a + p[5] * k + p[8]
    left, right = (1 + p[9]) * left, (1 + p[10]) * right
    turn = (right - left) / (y_left - y_right)
    return (right * y_left - left * y_right) / (y_left - y_right), -x * turn, turn


def errors_against(truth, updates, rows, steps=20, since=0.0):
    """Mean errors of predictions by `p` of each update from true poses, rows 0.1 s apart; as `mean_errors`."""
    errors = []
    for update in updates:
        first = round(update["pose"]["time"] / 0.1)
        if update["pose"]["time"] < since or first + steps >= len(rows):
            continue
        for p in (update["p"], np.zeros(11)):
            pose = truth[first, 3:]
            for row in rows[first : first + steps]:
                pose = step(pose, *twist(p, GAUGE, row[1], row[2]), 0.1)
            off = np.array(pose) - truth[first + steps, 3:]
            errors.append((np.hypot(off[0], off[1]), abs(off[2])))
    return np.array(errors).reshape(-1, 2, 2).mean(axis=0)
