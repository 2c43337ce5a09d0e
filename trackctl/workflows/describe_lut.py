"""`info`: what a look-up table holds, and how it was made, without loading it."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np

from trackctl.files.lut_details import StoredSensitivity, count_cells_beyond, read_sensitivity
from trackctl.files.lut_reader import LutHeader, read_lut_header
from trackctl.lut.axes import Array
from trackctl.profiles.terrain import TERRAIN_QUANTITIES, TerrainProfile
from trackctl.profiles.vehicle import VEHICLE_QUANTITIES, VehicleProfile
from trackctl.units import factor_to_si

RATES = ("sprocket_rate_left", "sprocket_rate_right")
TRACTIONS = ("traction_left", "traction_right")
#: Steps that differ by less than this share are even.
EVENNESS = 1e-6
#: Root attributes that have a section of their own, by how their names begin; the others are settings.
SECTIONS = {
    "step_": "steps",
    "certificate_near_straight_": "certificate_near_straight",
    "certificate_": "certificate",
    "swarm_check_": "swarm_check",
}
#: Root attributes that every table has, told on their own.
ORIGIN = ("title", "created", "history", "trackctl_version")
MARKS = ("Conventions",)


class RightTurns(StrEnum):
    """Where the answers to right turns come from."""

    STORED = "stored"
    MIRRORED = "mirrored"
    MISSING = "missing"


@dataclass(frozen=True, slots=True)
class AxisDescription:
    """Nodes of one axis.

    Attributes
    ----------
    count
        Number of nodes.
    low, high
        First and last, None if there are none.
    step
        Between nodes, None where there is not one even step.
    """

    count: int
    low: float | None
    high: float | None
    step: float | None


@dataclass(frozen=True, slots=True, eq=False)
class LutDescription:
    """A table in numbers.

    Attributes
    ----------
    file
        Where it is.
    header
        Axes, profiles, gravity, attributes, cells of each status.
    beyond_rate, beyond_force
        Converged cells beyond the vehicle's `max_sprocket_rate` and `max_track_force`, None if it has no such limit.
    sensitivity
        The analysis that the steps were drawn from, if they were drawn from one.
    """

    file: Path
    header: LutHeader
    beyond_rate: int
    beyond_force: int | None
    sensitivity: StoredSensitivity | None

    @property
    def axes(self) -> dict[str, AxisDescription]:
        """The axes by name with unit, radius (of left turns) beside curvature."""
        axes = self.header.axes
        return {
            "slope_rad": described_axis(axes.slope),
            "velocity_mps": described_axis(axes.velocity),
            "radius_m": described_axis(axes.radius[axes.curvature > 0.0][::-1]),
            "curvature_1pm": described_axis(axes.curvature),
            "heading_rad": described_axis(axes.heading),
        }

    @property
    def right_turns(self) -> RightTurns:
        """Where the answers to right turns come from."""
        if self.header.axes.curvature[0] < 0.0:
            return RightTurns.STORED
        return RightTurns.MIRRORED if self.header.vehicle.cog_left == 0.0 else RightTurns.MISSING

    @property
    def sections(self) -> dict[str, dict[str, object]]:
        """The root attributes by section, without what every table has."""
        sections: dict[str, dict[str, object]] = {name: {} for name in (*SECTIONS.values(), "settings")}
        for name, value in self.header.attributes.items():
            start = next((start for start in SECTIONS if name.startswith(start)), "")
            if name not in ORIGIN + MARKS:
                sections[SECTIONS.get(start, "settings")][name.removeprefix(start)] = value
        return sections


def describe_lut(path: Path) -> LutDescription:
    """Describe a table in constant memory, whatever its size.

    Raises
    ------
    LutFormatError
        If the file is no table.
    """
    header = read_lut_header(path)
    vehicle = header.vehicle
    force = vehicle.max_track_force
    return LutDescription(
        path,
        header,
        count_cells_beyond(path, RATES, vehicle.max_sprocket_rate),
        None if force is None else count_cells_beyond(path, TRACTIONS, force),
        read_sensitivity(path),
    )


def described_axis(nodes: Array) -> AxisDescription:
    """Nodes of an axis, ascending."""
    if nodes.size == 0:
        return AxisDescription(0, None, None, None)
    steps = np.diff(nodes)
    even = steps.size > 0 and np.ptp(steps) <= EVENNESS * steps.mean()
    low, high = float(nodes[0]), float(nodes[-1])
    return AxisDescription(nodes.size, low, high, (high - low) / steps.size if even else None)


def profile_numbers(profile: VehicleProfile | TerrainProfile) -> dict[str, float]:
    """The numbers of a profile under the keys of its file, those left out there left out here."""
    quantities = VEHICLE_QUANTITIES if isinstance(profile, VehicleProfile) else TERRAIN_QUANTITIES
    values = {quantity.key: getattr(profile, quantity.name) for quantity in quantities}
    return {key: value / factor_to_si(key) for key, value in values.items() if value is not None}


def document(found: LutDescription) -> dict[str, object]:
    """A description as JSON has it: all keys with their unit, null for what is no finite number."""
    header = found.header
    described = {
        "file": str(found.file),
        **{name: header.attributes.get(name) for name in ORIGIN},
        "vehicle": {"name": header.vehicle.name, **profile_numbers(header.vehicle)},
        "terrain": {"name": header.terrain.name, **profile_numbers(header.terrain)},
        "gravity_mps2": header.gravity,
        "axes": {name: asdict(axis) for name, axis in found.axes.items()},
        "heading_is_periodic": header.axes.heading_is_periodic,
        "right_turns": found.right_turns,
        "cells": header.axes.size,
        "status": {status.name.lower(): count for status, count in header.status_counts.items()},
        "beyond_max_sprocket_rate": found.beyond_rate,
        "beyond_max_track_force": found.beyond_force,
        **found.sections,
        "sensitivity": found.sensitivity and [asdict(index) for index in found.sensitivity.indices],
    }
    return {name: plain(value) for name, value in described.items()}


def plain(value: object) -> object:
    """A value in the types of JSON."""
    if isinstance(value, dict):
        return {str(name): plain(inner) for name, inner in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
