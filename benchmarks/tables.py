"""The tables that the benchmarks share, and the machine that they run on."""

from __future__ import annotations

import math
import os
import platform
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from trackctl.cli.compute_lut import DEFAULT_BUDGET
from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.lut.axes import FULL_CIRCLE, Array
from trackctl.lut.crew import solve_columns, threads
from trackctl.lut.grid import Ranges, default_ranges
from trackctl.lut.sweep import Seeding, Sweep
from trackctl.lut.table import Status
from trackctl.mechanics.parameters import STANDARD_GRAVITY
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.workflows.table_request import TableRequest, new_request
from trackctl.workflows.table_steps import ChosenSteps, explicit_steps, sensitivity_of, steps_from_sensitivity

SLOPE = math.radians(12.13)
THREADS = os.cpu_count() or 1


@dataclass(frozen=True, slots=True, eq=False)
class SolvedTable:
    """The cells of a table.

    Attributes
    ----------
    request
        What was solved.
    unknowns
        Left and right track speed over speed [-] and sideslip [rad], shape (*axes.shape, 3).
    status, residual
        Shape axes.shape.
    """

    request: TableRequest
    unknowns: Array
    status: NDArray[np.uint8]
    residual: Array

    @property
    def converged(self) -> NDArray[np.bool_]:
        """Which cells have an answer, shape axes.shape."""
        return self.status == Status.CONVERGED

    @property
    def name(self) -> str:
        """Vehicle and terrain."""
        return f"{self.request.vehicle.name} on {self.request.terrain.name}"


def benchmark_table() -> tuple[TableRequest, ChosenSteps]:
    """The table that rates are stated for, at the slope and steps of the slope-steering paper: 282,240 cells."""
    ranges = Ranges(velocity=(0.5, 8.0), radius=(3.0, 50.0), heading=(0.0, FULL_CIRCLE))
    request = undivided(load_vehicle("m113"), load_terrain("hard-soil"), ranges)
    steps = explicit_steps(ranges, velocity=0.5, radius=1.0, heading=math.radians(1.0))
    return request.divided(steps.divisions), steps


def default_table() -> tuple[TableRequest, ChosenSteps]:
    """What `trackctl compute-lut` compiles without an argument."""
    vehicle = load_vehicle("utv-61cm")
    request = undivided(vehicle, load_terrain("asphalt"), default_ranges(vehicle))
    found = sensitivity_of(request, THREADS)
    steps = steps_from_sensitivity(vehicle, request.ranges, DEFAULT_BUDGET, found)
    return request.divided(steps.divisions), steps


def undivided(vehicle: VehicleProfile, terrain: TerrainProfile, ranges: Ranges) -> TableRequest:
    """A table of one slope whose divisions are still to be chosen."""
    slope = np.array([SLOPE])
    return new_request(vehicle, terrain, STANDARD_GRAVITY, slope, ranges, Seeding.CONTINUATION, seed=0)


def solve_table(request: TableRequest) -> SolvedTable:
    """Solve all cells of a table."""
    sweep = request.sweep
    shape = sweep.axes.shape
    table = SolvedTable(request, np.empty((*shape, 3)), np.empty(shape, np.uint8), np.empty(shape))
    with threads(THREADS) as crew:
        for column, cells in solve_columns(sweep, range(sweep.column_count), crew):
            i, k = sweep.place(column)
            table.unknowns[i, :, k] = cells["unknowns"]
            table.status[i, :, k] = cells["status"]
            table.residual[i, :, k] = cells["residual"]
    return table


def points_of(sweep: Sweep, cells: NDArray[np.int64]) -> Array:
    """Slope [rad], velocity [m/s], curvature [1/m] and heading [rad] of cells by flat index, shape (n, 4)."""
    axes = sweep.axes
    nodes = (axes.slope, axes.velocity, axes.curvature, axes.heading)
    index = np.unravel_index(cells, axes.shape)
    return np.stack([axis[k] for axis, k in zip(nodes, index, strict=True)], axis=-1)


def print_machine() -> None:
    """Say where and when, and how busy the machine was."""
    cpu_info = Path("/proc/cpuinfo")
    lines = cpu_info.read_text().splitlines() if cpu_info.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    load = f", load average {os.getloadavg()[0]:.2f}" if hasattr(os, "getloadavg") else ""
    today = datetime.now(UTC).date().isoformat()
    cpu = names[0] if names else platform.machine()
    print(f"{today}, {cpu}, {THREADS} cores, Python {platform.python_version()}{load}")
