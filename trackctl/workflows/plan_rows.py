"""A driven plan as rows of a table, and back into what a simulation drives."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.simulation.path import Path
from trackctl.workflows.plan_drive import Driven
from trackctl.workflows.plan_line import DrivenLine, map_poses
from trackctl.workflows.plan_model import DriveModel
from trackctl.workflows.plan_turn import DrivenTurn

Array = NDArray[np.float64]

#: Between rows, over the contact length, and at most. [m]
ROW_SPACING, LONGEST_ROW = 1.0 / 12.0, 0.1
#: Rows of a stretch at least.
LEAST_ROWS = 12


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """A plan over time, arrays of shape (n,); fields as the columns of the table.

    Attributes
    ----------
    time
        Ascending from 0. [s]
    x, y, yaw
        Of the mass centre and the body, on the map; the yaw between -pi and pi. [m], [rad]
    velocity
        Negative backwards. [m/s]
    curvature
        Of the path in the plane of the ground: turn per metre travelled forwards; 0 in a turn on the spot. [1/m]
    slope, heading
        Of the ground; from up-slope to the body's x axis in its plane, from 0 to 2 pi. [rad]
    rate_left, rate_right
        Of the sprockets. [rad/s]
    sideslip
        Tangent - yaw in the plane of the ground. [rad]
    slip_left, slip_right
        Of the tracks. [-]
    segment
        Number of the stretch driven without a stop, or of the turn on the spot.
    """

    time: Array
    x: Array
    y: Array
    yaw: Array
    velocity: Array
    curvature: Array
    slope: Array
    heading: Array
    rate_left: Array
    rate_right: Array
    sideslip: Array
    slip_left: Array
    slip_right: Array
    segment: NDArray[np.int64]

    @property
    def length(self) -> float:
        """Way of the mass centre, from the speeds, which change linearly in time. [m]"""
        speed = np.abs(self.velocity)
        return float((0.5 * (speed[1:] + speed[:-1]) * np.diff(self.time)).sum())

    @property
    def path(self) -> Path:
        """Where it leads on the map, for distances."""
        nothing = np.zeros_like(self.x)
        return Path(nothing, self.x, self.y, nothing, nothing, nothing)


COLUMNS = {
    "time_s": "time",
    "x_m": "x",
    "y_m": "y",
    "yaw_rad": "yaw",
    "velocity_mps": "velocity",
    "curvature_1pm": "curvature",
    "slope_rad": "slope",
    "heading_rad": "heading",
    "sprocket_rate_left_radps": "rate_left",
    "sprocket_rate_right_radps": "rate_right",
    "sideslip_rad": "sideslip",
    "slip_left": "slip_left",
    "slip_right": "slip_right",
    "segment": "segment",
}


def columns_of(rows: Rows) -> dict[str, Array]:
    """The rows as columns of a CSV table."""
    return {header: getattr(rows, name) for header, name in COLUMNS.items()}


def rows_of(model: DriveModel, driven: Sequence[Driven]) -> Rows:
    """Rows of stretches and turns one after the other; where two of them meet there is one row."""
    parts = []
    time = 0.0
    for number, each in enumerate(driven):
        if isinstance(each, DrivenTurn):
            part = turn_rows(model, each, number, time)
        else:
            part = stretch_rows(model, each, number, time)
        time = float(part["time"][-1])
        parts.append(part if number == 0 else {name: values[1:] for name, values in part.items()})
    return Rows(**{name: np.concatenate([part[name] for part in parts]) for name in parts[0]})


def wrapped(yaw: Array) -> Array:
    """The same direction above -pi, up to pi. [rad]"""
    return math.pi - np.mod(math.pi - yaw, 2.0 * math.pi)


def stretch_rows(model: DriveModel, driven: DrivenLine, number: int, time: float) -> dict[str, Array]:
    """Rows of one stretch, in the vehicle's own terms also where it is driven backwards."""
    commands, path = driven.commands, driven.commands.path
    step = path.arc_length[1] - path.arc_length[0]
    apart = min(ROW_SPACING * model.vehicle.contact_length, LONGEST_ROW)
    stride = max(min(int(apart / step * (1.0 + 1e-9)), (path.speed.size - 1) // LEAST_ROWS), 1)
    kept = np.unique(np.append(np.arange(0, path.speed.size, stride), path.speed.size - 1))
    x, y, yaw, heading = map_poses(driven)
    radius = model.vehicle.sprocket_radius
    left, right = commands.track_speed_left / radius, commands.track_speed_right / radius
    slips = commands.slip_left, commands.slip_right
    velocity, curvature = path.speed, path.curvature
    if driven.line.backwards:
        left, right, slips = -right, -left, (-slips[1], -slips[0])
        velocity, curvature = -velocity, -curvature
    columns = {
        "time": time + commands.time,
        "x": x,
        "y": y,
        "yaw": wrapped(yaw),
        "velocity": velocity,
        "curvature": curvature,
        "slope": driven.surface_at("slope"),
        "heading": np.mod(heading, 2.0 * math.pi),
        "rate_left": left,
        "rate_right": right,
        "sideslip": commands.sideslip,
        "slip_left": slips[0],
        "slip_right": slips[1],
        "segment": np.full(x.size, number),
    }
    return {name: values[kept] for name, values in columns.items()}


def turn_rows(model: DriveModel, driven: DrivenTurn, number: int, time: float) -> dict[str, Array]:
    """Rows of a turn on the spot, on level ground."""
    x, y, yaw = driven.poses
    turn, radius, nothing = driven.turn, model.vehicle.sprocket_radius, np.zeros_like(yaw)
    return {
        "time": time + turn.time,
        "x": x,
        "y": y,
        "yaw": wrapped(yaw),
        "velocity": nothing,
        "curvature": nothing,
        "slope": nothing,
        "heading": np.mod(yaw - driven.uphill, 2.0 * math.pi),
        "rate_left": turn.track_speed_left / radius,
        "rate_right": turn.track_speed_right / radius,
        "sideslip": nothing,
        "slip_left": turn.slip_left,
        "slip_right": turn.slip_right,
        "segment": np.full(yaw.size, number),
    }
