"""The look-up table that a plan reads: the user's, or one that is compiled once and kept in the user's cache folder."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import cache_root
from trackctl.errors import InputFileError, OutputError, TrackctlWarning, UsageError
from trackctl.files.atomic import whole_file
from trackctl.files.lut_match import check_matches
from trackctl.files.lut_reader import read_lut
from trackctl.files.lut_writer import write_lut
from trackctl.lut.axes import FULL_CIRCLE, Axes
from trackctl.lut.crew import solve_columns, threads
from trackctl.lut.sweep import Seeding, Sweep, column_values, load_kernels
from trackctl.lut.table import VARIABLES, Table
from trackctl.mechanics.parameters import track_model
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.workflows.table_request import digest_of

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]

HEADINGS = 36
SPEEDS = 10
#: Between two slopes of a table at most. [rad]
SLOPE_STEP = math.radians(2.0)
#: Steepest slope of a table. [rad]
STEEPEST = math.radians(44.9)
#: Curvatures about straight driving, over the width 4 K/L^2 of the tip that the sideslip has there.
NEAR_STRAIGHT = (0.25, 0.5, 1.0, 2.0)
#: From there on each is so many times the one before, at most.
GROWTH = 1.5


def slope_nodes(lowest: float, highest: float) -> Array:
    """Slopes of a table for ground between two slopes: that of a plane, or from the level on. [rad]"""
    if highest - lowest < 1e-9:
        return np.array([min(highest, STEEPEST)])
    top = min(highest, STEEPEST)
    return np.linspace(0.0, top, math.ceil(top / SLOPE_STEP) + 1)


def curvature_nodes(length: float, shear_modulus: float, sharpest: float) -> Array:
    """Curvatures from straight to the sharpest, densest about straight driving. [1/m]"""
    near = np.array(NEAR_STRAIGHT) * 4.0 * shear_modulus / length**2
    near = near[near < 0.7 * sharpest]
    first = near[-1] if near.size else 0.1 * sharpest
    count = max(math.ceil(math.log(sharpest / first) / math.log(GROWTH)), 1)
    return np.concatenate(([0.0], near[:-1], np.geomspace(first, sharpest, count + 1)))


def plan_axes(vehicle: VehicleProfile, terrain: TerrainProfile, slope: Array, sharpest: float) -> Axes:
    """Nodes of a table for plans."""
    curvature = curvature_nodes(vehicle.contact_length, terrain.shear_deformation_modulus, sharpest)
    if vehicle.cog_left != 0.0:
        curvature = np.concatenate((-curvature[:0:-1], curvature))
    return Axes(
        slope,
        np.linspace(0.0, vehicle.max_speed, SPEEDS + 1)[1:],
        curvature,
        FULL_CIRCLE * np.arange(HEADINGS) / HEADINGS,
        heading_is_periodic=True,
    )


def cached_table(
    vehicle: VehicleProfile,
    terrain: TerrainProfile,
    gravity: float,
    slope: Array,
    sharpest: float,
    progress: Progress,
    jobs: int = 1,
) -> Table:
    """The table for plans, compiled on first use and kept under a hash of all that it depends on.

    Parameters
    ----------
    vehicle, terrain, gravity
        What it is made for. Gravity: [m/s2]
    slope
        Its slopes. [rad]
    sharpest
        Its largest curvature. [1/m]
    progress
        Told the number of columns done, and of all; not called where the table is kept already.
    jobs
        Threads.
    """
    axes = plan_axes(vehicle, terrain, slope, sharpest)
    sweep = Sweep(track_model(vehicle, terrain, gravity), axes, Seeding.CONTINUATION, 0)
    nodes = {name: getattr(axes, name).tolist() for name in ("slope", "velocity", "curvature", "heading")}
    profiles = {"vehicle": asdict(vehicle), "terrain": asdict(terrain)}
    name = f"{digest_of({**profiles, 'gravity': gravity, **nodes})[:32]}.h5"
    try:
        file = cache_root() / "tables" / name
        table = read_lut(file)
        check_matches(table, vehicle, terrain, gravity, file)
        return table
    except (InputFileError, OSError):
        table = compiled_table(sweep, vehicle, terrain, gravity, progress, jobs)
    keep(name, table)
    return table


def compiled_table(
    sweep: Sweep, vehicle: VehicleProfile, terrain: TerrainProfile, gravity: float, progress: Progress, jobs: int
) -> Table:
    """Solve all columns of a table."""
    values = {name: np.empty(sweep.axes.shape) for name in VARIABLES}
    status = np.empty(sweep.axes.shape, np.uint8)
    weight, total = vehicle.mass * gravity, sweep.column_count
    load_kernels(sweep.seeding)
    progress(0, total)
    with threads(jobs) as crew:
        for done, (column, cells) in enumerate(solve_columns(sweep, range(total), crew), start=1):
            i, k = sweep.place(column)
            for name, part in column_values(sweep, column, cells, vehicle.sprocket_radius, weight).items():
                values[name][i, :, k] = part
            status[i, :, k] = cells["status"]
            progress(done, total)
    return Table(sweep.axes, values, status, vehicle, terrain, gravity)


def keep(name: str, table: Table) -> None:
    """Write a table to the cache, or warn that it cannot be kept."""
    try:
        file = cache_root() / "tables" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(file, force=True) as path:
            write_lut(path, table)
    except (OSError, OutputError) as error:
        reason = getattr(error, "strerror", None) or error
        text = f"the table cannot be kept ({reason}), so that each plan solves it anew"
        warnings.warn(text, TrackctlWarning, stacklevel=2)


def users_table(
    lut: Path, vehicle: VehicleProfile, terrain: TerrainProfile, gravity: float, slopes: tuple[float, float]
) -> Table:
    """A table named by the user, for ground between two slopes. [rad]

    Raises
    ------
    LutFormatError, LutMismatchError
        If it is none, or made for something else.
    UsageError
        If it does not hold the slopes.
    """
    table = read_lut(lut)
    check_matches(table, vehicle, terrain, gravity, lut)
    low, high = float(table.axes.slope[0]), float(table.axes.slope[-1])
    if slopes[0] < low - 1e-6 or slopes[1] > high + 1e-6:
        held, asked = (f"{math.degrees(a):.4g} to {math.degrees(b):.4g} deg" for a, b in ((low, high), slopes))
        raise UsageError("--lut", lut, f"a table that holds the ground's slopes, {asked}; this one holds {held}")
    if not table.axes.heading_is_periodic:
        raise UsageError("--lut", lut, "a table of the full circle of headings")
    return table
