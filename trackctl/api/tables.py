"""Steady turns on a slope, from the model and from look-up tables."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from trackctl.api.arguments import check, check_all, operating_points, unheard
from trackctl.errors import UsageError
from trackctl.files.atomic import check_output
from trackctl.files.lut_reader import read_lut
from trackctl.lut.crew import Crew
from trackctl.lut.grid import STEEPEST_SLOPE
from trackctl.lut.interpolation import Interpolant, LookupResult, LookupStatus, interpolant, look_up
from trackctl.lut.shape_functions import Method
from trackctl.lut.sweep import Seeding
from trackctl.lut.table import Table
from trackctl.mechanics.parameters import STANDARD_GRAVITY
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.workflows import compute_lut
from trackctl.workflows import export as export_workflow
from trackctl.workflows.export import ExportRequest, ExportResult
from trackctl.workflows.export_options import CMethod, ExportFormat, Precision
from trackctl.workflows.lookup import exact_answers, solved_answers
from trackctl.workflows.lookup_method import LookupMethod
from trackctl.workflows.provenance import made_by
from trackctl.workflows.sensitivity import ranges_within
from trackctl.workflows.step_budgets import DEFAULT_BUDGET, LARGEST_REFINED
from trackctl.workflows.step_choice import steps_to_tolerance, steps_within
from trackctl.workflows.table_request import TableRequest, new_request
from trackctl.workflows.table_steps import AXES, ChosenSteps, explicit_steps

__all__ = [
    "CMethod",
    "ExportFormat",
    "ExportResult",
    "LookupMethod",
    "LookupResult",
    "LookupStatus",
    "LookupTable",
    "Precision",
    "Seeding",
    "compile_table",
    "export_table",
    "open_table",
    "solve_point",
]

Range = tuple[float, float]
Progress = Callable[[int, int], None]


def solve_point(
    vehicle: VehicleProfile,
    terrain: TerrainProfile,
    velocity: ArrayLike,
    curvature: ArrayLike,
    heading: ArrayLike,
    slope: ArrayLike = 0.0,
    *,
    gravity: float = STANDARD_GRAVITY,
    jobs: int = 1,
) -> LookupResult:
    """Sprocket speeds that make a vehicle really drive a steady turn on a slope, solved by the model itself.

    Parameters
    ----------
    vehicle, terrain
        Profiles.
    velocity
        Of the mass centre, above 0. [m/s]
    curvature
        1 / radius, positive to the left, 0 straight ahead. [1/m]
    heading
        From up-slope to the body's x axis, counter-clockwise. [rad]
    slope
        From 0 to below pi/4. [rad]
    gravity
        [m/s2]
    jobs
        Threads.

    Returns
    -------
    LookupResult
        Arrays of the shape that the arguments broadcast to, NaN where there is no answer; `status` holds codes of
        `LookupStatus`.

    Raises
    ------
    UsageError
        If an argument is out of its range.

    Examples
    --------
    >>> import math
    >>> import trackctl
    >>> vehicle, terrain = trackctl.load_vehicle("utv-61cm"), trackctl.load_terrain("asphalt")
    >>> found = trackctl.solve_point(vehicle, terrain, velocity=1.0, curvature=0.2, heading=0.0, slope=math.radians(12))
    >>> trackctl.LookupStatus(int(found.status)).label
    'converged'
    >>> print(f"{found.track_speed_left:.3f} {found.track_speed_right:.3f} m/s")
    0.937 1.110 m/s

    Arguments may be arrays; up the slope a turn of 1 m at 2 m/s is more than the sprockets can do:

    >>> turn = trackctl.solve_point(vehicle, terrain, 2.0, 1 / 1.0, [0.0, math.pi / 2], math.radians(12))
    >>> [trackctl.LookupStatus(code).label for code in turn.status.tolist()]
    ['actuator_limit', 'converged']
    """
    given = {"slope": slope, "velocity": velocity, "curvature": curvature, "heading": heading}
    points, shape = operating_points(given)
    check_all("slope", points[0], (points[0] >= 0.0) & (points[0] < STEEPEST_SLOPE), "from 0 to below pi/4")
    check_all("velocity", points[1], (points[1] > 0.0) & np.isfinite(points[1]), "above 0, finite")
    for name, values in zip(("curvature", "heading"), points[2:], strict=True):
        check_all(name, values, np.isfinite(values), "finite")
    check("gravity", gravity, 0.0 < gravity < math.inf, "above 0")
    inside = np.ones(points.shape[1], np.bool_)
    return shaped(solved_answers(vehicle, terrain, gravity, points, inside, jobs), shape)


@dataclass(frozen=True, slots=True, eq=False)
class LookupTable:
    """A look-up table, open for queries.

    Attributes
    ----------
    table
        Axes, values, status, profiles and attributes, as in the file.
    packed
        The same, made ready for interpolation.

    Examples
    --------
    >>> import trackctl
    >>> opened = trackctl.open_table("lut.h5")
    >>> opened.table.vehicle.name, opened.table.axes.shape
    ('utv-61cm', (1, 5, 13, 24))
    """

    table: Table
    packed: Interpolant

    def lookup(
        self,
        velocity: ArrayLike,
        curvature: ArrayLike,
        heading: ArrayLike,
        slope: ArrayLike | None = None,
        *,
        method: LookupMethod = LookupMethod.MLS,
        jobs: int = 1,
    ) -> LookupResult:
        """Sprocket speeds at operating points; nothing is extrapolated.

        Parameters
        ----------
        velocity, curvature, heading, slope
            As of `solve_point`; the slope may be left out if the table has only one.
        method
            How to interpolate, or to solve the model at the points.
        jobs
            Threads.

        Returns
        -------
        LookupResult
            As of `solve_point`.

        Raises
        ------
        UsageError
            If the table has several slopes and none is given.

        Examples
        --------
        >>> import numpy as np
        >>> import trackctl
        >>> opened = trackctl.open_table("lut.h5")
        >>> found = opened.lookup(velocity=[0.5, 1.0, 9.0], curvature=0.2, heading=np.pi / 2)
        >>> [trackctl.LookupStatus(code).label for code in found.status.tolist()]
        ['converged', 'converged', 'outside_table']
        >>> np.isnan(found.sprocket_rate_left).tolist()
        [False, False, True]
        """
        nodes = self.table.axes.slope
        if slope is None and nodes.size > 1:
            raise UsageError("slope", None, f"a slope, as the table has {nodes.size}")
        given = {"slope": nodes[0] if slope is None else slope, "velocity": velocity}
        points, shape = operating_points({**given, "curvature": curvature, "heading": heading})
        if method is LookupMethod.EXACT:
            return shaped(exact_answers(self.table, points, jobs), shape)
        rise, speed, bend, direction = points
        return shaped(look_up(self.packed, rise, speed, bend, direction, Method(method.value), jobs), shape)


def open_table(path: str | Path) -> LookupTable:
    """Open a table file.

    Raises
    ------
    LutFormatError
        If the file is missing, damaged, or no table.

    Examples
    --------
    >>> import trackctl
    >>> opened = trackctl.open_table("lut.h5")
    >>> straight = opened.lookup(velocity=1.0, curvature=0.0, heading=0.0)
    >>> print(f"{straight.sprocket_rate_left:.3f} {straight.sprocket_rate_right:.3f} rad/s")
    10.089 10.089 rad/s
    """
    table = read_lut(Path(path))
    return LookupTable(table, interpolant(table))


def compile_table(
    vehicle: VehicleProfile,
    terrain: TerrainProfile,
    output: str | Path,
    *,
    slope: float | Sequence[float],
    velocity: Range | None = None,
    radius: Range | None = None,
    heading: Range | None = None,
    steps: Mapping[str, float] | None = None,
    budget: int | None = None,
    tolerance: float | None = None,
    gravity: float = STANDARD_GRAVITY,
    seeding: Seeding = Seeding.CONTINUATION,
    seed: int = 0,
    jobs: int = 1,
    executor: Executor | None = None,
    workers: int = 1,
    resume: bool = False,
    force: bool = False,
    progress: Progress = unheard,
    say: Callable[[str], None] = unheard,
) -> LookupTable:
    """Compile a look-up table into a file, and open it; `compute-lut`.

    Parameters
    ----------
    vehicle, terrain
        Profiles.
    output
        The file, which appears whole or not at all.
    slope
        One slope, or several, ascending. [rad]
    velocity, radius, heading
        Ends of the ranges, None for the vehicle's own. [m/s], [m], [rad]
    steps
        Of velocity, radius and heading; left out, they follow a sensitivity analysis. [m/s], [m], [rad]
    budget
        Most cells, without `steps`; 200,000, or 5 million with a tolerance.
    tolerance
        Refine until interpolated track speeds err by less, as a share of the speed, at 99 of 100 points.
    gravity
        [m/s2]
    seeding, seed
        Of the solver.
    jobs
        Threads.
    executor, workers
        Where the columns are solved instead: any executor, that of processes, MPI or Dask for one, and how many
        columns it solves at a time.
    resume, force
        Continue the checkpoint beside the output; replace an existing output.
    progress
        Told the number of columns done, and of all.
    say
        Told, in words, of each refinement.

    Raises
    ------
    UsageError
        If a range, step or budget is not allowed.
    OutputError, InputFileError
        If the file or its checkpoint cannot be written or read.
    WorkerError
        If the executor fails; what is done stays in the checkpoint.
    NoAnswerError
        If no cell is feasible.

    Examples
    --------
    >>> import math
    >>> import trackctl
    >>> opened = trackctl.compile_table(
    ...     trackctl.load_vehicle("utv-61cm"),
    ...     trackctl.load_terrain("asphalt"),
    ...     "lut.h5",
    ...     slope=math.radians(12.0),
    ...     velocity=(0.4, 2.0),
    ...     radius=(2.0, 24.0),
    ...     steps={"velocity": 0.4, "radius": 2.0, "heading": math.radians(15.0)},
    ... )
    >>> opened.table.attributes["certificate_max_error"] < 0.01
    True
    """
    output = Path(output)
    slopes = np.atleast_1d(np.asarray(slope, np.float64))
    check("slope", slope, slopes.size > 0 and bool((np.diff(slopes) > 0.0).all()), "one or more, ascending")
    check("gravity", gravity, 0.0 < gravity < math.inf, "above 0")
    ranges = ranges_within(vehicle, velocity, radius, heading)
    blank = new_request(vehicle, terrain, gravity, slopes, ranges, seeding.value, seed)
    compute_lut.refuse_streams(output)
    check_output(output, force)
    chosen = chosen_steps(blank, steps, budget, tolerance, jobs, say)
    compute_lut.compute_lut(
        blank.divided(chosen.divisions),
        chosen,
        output,
        made_by("trackctl.compile_table"),
        jobs=jobs,
        resume=resume,
        force=force,
        progress=progress,
        crew=None if executor is None else Crew(executor, lambda: workers),
    )
    return open_table(output)


def chosen_steps(
    blank: TableRequest,
    steps: Mapping[str, float] | None,
    budget: int | None,
    tolerance: float | None,
    jobs: int,
    say: Callable[[str], None],
) -> ChosenSteps:
    """Explicit steps, or those under a budget, refined to a tolerance."""
    if steps is not None:
        check("steps", sorted(steps), set(steps) == set(AXES), ", ".join(AXES))
        check("steps", "beside a budget or tolerance", budget is None and tolerance is None, "one or the other")
        return explicit_steps(blank.ranges, **steps)
    check("budget", budget, budget is None or budget > 0, "above 0")
    if tolerance is None:
        return steps_within(blank, DEFAULT_BUDGET if budget is None else budget, jobs)
    check("tolerance", tolerance, 0.0 < tolerance < 1.0, "a share above 0, below 1")
    return steps_to_tolerance(blank, tolerance, LARGEST_REFINED if budget is None else budget, jobs, say)


def export_table(
    path: str | Path,
    output: str | Path,
    *,
    precision: Precision = Precision.DOUBLE,
    method: CMethod = CMethod.LINEAR,
    prefix: str | None = None,
    force: bool = False,
) -> ExportResult:
    """Write a table for controllers, MATLAB or NumPy, by the suffix of the output: .c (and .h), .mat or .npz.

    Parameters
    ----------
    path
        The table's file.
    output
        File to write.
    precision, method, prefix
        Of C; the prefix of its names is that of the file by default.
    force
        Replace existing files.

    Raises
    ------
    UsageError, OutputError, LutFormatError, NoAnswerError
        If there is nothing to export, or nowhere to.

    Examples
    --------
    >>> import trackctl
    >>> written = trackctl.export_table("lut.h5", "robot.c", precision=trackctl.Precision.FLOAT)
    >>> [file.name for file in written.files], written.size
    (['robot.h', 'robot.c'], 20456)
    """
    return export_workflow.export_table(ExportRequest(Path(path), Path(output), None, precision, method, prefix, force))


def shaped(found: LookupResult, shape: tuple[int, ...]) -> LookupResult:
    """The same answers in another shape."""
    return LookupResult(*(getattr(found, field.name).reshape(shape) for field in fields(LookupResult)))
