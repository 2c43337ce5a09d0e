"""Commands over time as rows of a CSV table: sprocket rates, track speeds or track forces, with or without a target."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.errors import InputFileError
from trackctl.files.csv_table import CsvTable, cell_error, column, find_header
from trackctl.simulation.path import Path
from trackctl.simulation.path_rule import PathCommands
from trackctl.simulation.track_force_drive import TrackForces
from trackctl.simulation.track_speeds import TrackSpeeds
from trackctl.workflows.unrolled_ground import PlannedGround

Array = NDArray[np.float64]

TIME = "time_s"
RATES = ("sprocket_rate_left_radps", "sprocket_rate_right_radps")
SPEEDS = ("track_speed_left_mps", "track_speed_right_mps")
FORCES = ("force_left_n", "force_right_n")
POSE = ("x_m", "y_m", "yaw_rad")
#: Of the ground under a target.
GROUND = ("slope_rad", "heading_rad", "curvature_1pm")
#: Steepest slope that a vehicle is simulated on. [rad]
STEEPEST = math.radians(45.0)
#: Share of the largest speed of a target and its tracks at which both stand still.
STANDING = 1e-6
#: Names that the speed and the sideslip of a target may have.
SPEED_NAMES, SIDESLIP_NAMES = ("velocity_mps", "speed_mps"), ("sideslip_rad", "slip_angle_rad")


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """Where a vehicle should be over time, arrays of shape (n,); the speed is negative backwards."""

    time: Array
    x: Array
    y: Array
    yaw: Array
    sideslip: Array
    speed: Array


@dataclass(frozen=True, slots=True, eq=False)
class DriveCommands:
    """Commands of a table, and the target that they stand beside and the ground under it, None where there is none."""

    commands: TrackSpeeds | TrackForces
    target: Target | None
    ground: PlannedGround | None = None


def read_commands(table: CsvTable, sprocket_radius: float) -> DriveCommands:
    """The commands of a table's rows.

    Raises
    ------
    InputFileError
        If a column is missing, there in two forms, or holds a cell that is not allowed, or if time does not ascend.
    """
    time = column(table, TIME)
    for row in np.flatnonzero(np.diff(time) <= 0.0) + 1:
        raise cell_error(table, str(find_header(table, TIME)), int(row), f"above {time[row - 1]:g}, the row before")
    if time.size < 2:
        raise InputFileError(table.file, "has one row; allowed: two or more, to drive from one to the next")
    left, right = checked_form(table)
    values = column(table, left), column(table, right)
    if (left, right) == FORCES:
        return DriveCommands(TrackForces(time, *values), read_target(table, time))
    factor = sprocket_radius if (left, right) == RATES else 1.0
    target = read_target(table, time)
    speeds = TrackSpeeds(time, factor * values[0], factor * values[1])
    return DriveCommands(speeds, target, None if target is None else read_ground(table, target))


def checked_form(table: CsvTable) -> tuple[str, str]:
    """The pair of columns that commands the vehicle."""
    found = [pair for pair in (RATES, SPEEDS, FORCES) if any(find_header(table, key) for key in pair)]
    if not found:
        forms = ", ".join(f"{left} and {right}" for left, right in (RATES, SPEEDS, FORCES))
        raise InputFileError(table.file, f"has no commands; allowed: {forms}; there are: {', '.join(table.columns)}")
    if len(found) > 1:
        both = " and ".join(find_header(table, pair[0]) or pair[0] for pair in found)
        raise InputFileError(table.file, f"columns {both} both command the vehicle; allowed: one of them")
    return found[0]


def read_target(table: CsvTable, time: Array) -> Target | None:
    """The target of a table that has all of its columns."""
    speed, sideslip = (
        next((key for key in names if find_header(table, key)), None) for names in (SPEED_NAMES, SIDESLIP_NAMES)
    )
    if speed is None or sideslip is None or not all(find_header(table, key) for key in POSE):
        return None
    x, y, yaw = (column(table, key) for key in POSE)
    return Target(time, x, y, np.unwrap(yaw), column(table, sideslip), column(table, speed))


def read_ground(table: CsvTable, target: Target) -> PlannedGround | None:
    """The ground under a target, of a table that has all of its columns, as that of `plan`."""
    if not all(find_header(table, key) for key in GROUND):
        return None
    slope, heading, curvature = (column(table, key) for key in GROUND)
    for row in np.flatnonzero((slope < 0.0) | (slope > STEEPEST)):
        raise cell_error(table, str(find_header(table, GROUND[0])), int(row), f"0 to {STEEPEST:.6g} rad")
    return PlannedGround(
        target.time, target.x, target.y, target.yaw, target.speed, curvature, slope, heading, target.sideslip
    )


def target_commands(target: Target, speeds: TrackSpeeds) -> PathCommands:
    """A target and its track speeds in the form that feedback follows.

    Where speed and tracks stand still so does the yaw, whatever its differences to the rows beside say.
    """
    length = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(target.x), np.diff(target.y)))))
    nothing, unknown = np.zeros_like(length), np.full_like(length, np.nan)
    fastest = np.abs(np.stack((target.speed, speeds.left, speeds.right))).max(axis=0)
    stands = fastest <= STANDING * fastest.max()
    yaw_rate = np.where(stands, 0.0, np.gradient(target.yaw, target.time))
    tangent = target.yaw + target.sideslip
    path = Path(length, target.x, target.y, tangent, nothing, np.where(stands, 0.0, target.speed))
    slips_and_residual = nothing, nothing, nothing
    return PathCommands(
        path, target.time, speeds.left, speeds.right, target.sideslip, yaw_rate, *slips_and_residual, unknown, unknown
    )
