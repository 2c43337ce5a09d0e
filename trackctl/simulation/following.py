"""Driving along a target: start on it, feedback of heading or pose, and what the motion makes of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from trackctl.simulation.motion import End, Integration, State, integration
from trackctl.simulation.path import Path
from trackctl.simulation.path_rule import PathCommands
from trackctl.simulation.run_state import Settings
from trackctl.simulation.slopes import Slopes
from trackctl.simulation.track_speeds import TrackSpeeds, ramp, speed_pieces
from trackctl.simulation.vehicle_rates import Scene

Array = NDArray[np.float64]

#: Period of the feedback. [s]
PERIOD = 0.02
#: Counter-turning of the tracks for a turn, over that without slip.
TURNING_GAIN = 1.5


class Feedback(Enum):
    """What is measured and fed back."""

    NONE = "none"
    HEADING = "heading"
    POSE = "pose"


@dataclass(frozen=True, slots=True)
class Reference:
    """Where the vehicle should be: pose with the tangent in place of the yaw, sideslip, and speed."""

    x: float
    y: float
    tangent: float
    sideslip: float
    speed: float


def start_on(commands: PathCommands) -> State:
    """The state at the start of a target."""
    path, speed, sideslip = commands.path, float(commands.path.speed[0]), float(commands.sideslip[0])
    return State(
        float(path.x[0]),
        float(path.y[0]),
        float(path.tangent[0]) - sideslip,
        speed * math.cos(sideslip),
        speed * math.sin(sideslip),
        float(commands.yaw_rate[0]),
    )


def track_speeds(commands: PathCommands) -> TrackSpeeds:
    """The commands over time."""
    return TrackSpeeds(commands.time, commands.track_speed_left, commands.track_speed_right)


def corrections(
    feedback: Feedback, reference: Reference, pose: Array, length: float, gauge: float
) -> tuple[float, float]:
    """What feedback adds to the left and right track speed. [m/s]

    r_c = -|v| 2/L e_psi - v e_y/L^2 and V_lr += -|v|/L e_s -+ 1.5 (B/2) r_c, with the errors along and across the path
    and of the yaw; heading feedback knows the last only.
    """
    ahead, left = pose[0] - reference.x, pose[1] - reference.y
    cos, sin = math.cos(reference.tangent), math.sin(reference.tangent)
    along, across = cos * ahead + sin * left, cos * left - sin * ahead
    yaw = math.remainder(pose[2] - (reference.tangent - reference.sideslip), 2.0 * math.pi)
    if feedback is Feedback.HEADING:
        along = across = 0.0
    pace = abs(reference.speed)
    turning = -pace * 2.0 / length * yaw - reference.speed * across / length**2
    both, each = -pace / length * along, TURNING_GAIN * 0.5 * gauge * turning
    return both - each, both + each


def follow(
    scene: Scene,
    commands: PathCommands,
    feedback: Feedback,
    start: State,
    tolerance: float,
    *,
    steady_start: bool,
    duration: float = math.inf,
    most_turn: float = math.inf,
    slopes: Slopes | None = None,
) -> tuple[Integration, End]:
    """Drive along a target under its commands, corrected by feedback at 50 Hz; see `motion.simulate`.

    Between two corrections the track speeds change linearly. Slopes over time take the place of the scene's, in steps
    of the commands' samples or the corrections.
    """
    end = min(float(commands.time[-1]), float(commands.time[0]) + duration)
    speeds = track_speeds(commands).until(end)
    settings = Settings(tolerance, math.inf, most_turn)
    before = (float(speeds.left[0]), float(speeds.right[0])) if steady_start else None
    simulation = integration(scene, start, float(speeds.time[0]), before)
    if feedback is Feedback.NONE and slopes is None:
        return simulation, simulation.advance(speed_pieces(speeds), settings)
    if feedback is Feedback.NONE and slopes is not None:
        return simulation, drive_over(simulation, speeds, slopes, settings)
    time = np.append(np.arange(speeds.time[0], end - 0.5 * PERIOD, PERIOD), end)
    forward = np.stack([np.interp(time, speeds.time, values) for values in (speeds.left, speeds.right)], axis=1)
    references = sampled(commands, time)
    now = forward[0]
    for i in range(time.size - 1):
        added = corrections(feedback, references[i], simulation.pose, scene.model.length, scene.model.gauge)
        after = forward[i + 1] + added
        if slopes is not None:
            simulation.scene = slopes.scene_at(scene, 0.5 * float(time[i] + time[i + 1]))
        status = simulation.advance(ramp(time[i], time[i + 1], now, after), settings)
        if status != End.DONE:
            return simulation, status
        now = after
    return simulation, End.DONE


def drive_over(simulation: Integration, speeds: TrackSpeeds, slopes: Slopes, settings: Settings) -> End:
    """Drive with the slope of the middle of each piece of the track speeds."""
    for i in range(speeds.time.size - 1):
        part = slice(i, i + 2)
        simulation.scene = slopes.scene_at(simulation.scene, float(speeds.time[part].mean()))
        piece = TrackSpeeds(speeds.time[part], speeds.left[part], speeds.right[part])
        status = simulation.advance(speed_pieces(piece), settings)
        if status != End.DONE:
            return status
    return End.DONE


def sampled(commands: PathCommands, time: Array) -> list[Reference]:
    """The target at some times, interpolated smoothly: chords between samples would be fed back as errors."""
    from scipy.interpolate import Akima1DInterpolator  # takes its time

    path = commands.path
    columns = (path.x, path.y, path.tangent, commands.sideslip, path.speed)
    rows = np.stack([Akima1DInterpolator(commands.time, values)(time) for values in columns], axis=1)
    return [Reference(*row) for row in rows.tolist()]


def deviation(path: Path, x: Array, y: Array) -> Array:
    """Distance of points from a path, taken as straight between its samples, shape of `x`. [m]"""
    from scipy.spatial import KDTree  # takes its time

    corners = np.stack((path.x, path.y), axis=1)
    # A place where it stands is one corner; a path has two.
    corners = corners[np.append(True, np.diff(corners, axis=0).any(axis=1))]
    corners = np.repeat(corners, 2, axis=0) if len(corners) == 1 else corners
    points = np.stack((x, y), axis=1)
    # The two nearest: where a path closes, the end of one lap and the start of the next are the same place.
    nearest = KDTree(corners).query(points, k=2)[1].T
    distance = np.full(x.size, np.inf)
    for first in np.concatenate((nearest - 1, nearest)):
        start = corners[np.clip(first, 0, len(corners) - 2)]
        side = corners[np.clip(first, 0, len(corners) - 2) + 1] - start
        square = np.maximum((side**2).sum(axis=1), np.finfo(np.float64).tiny)
        share = np.clip(((points - start) * side).sum(axis=1) / square, 0.0, 1.0)
        distance = np.minimum(distance, np.hypot(*(points - start - share[:, None] * side).T))
    return distance
