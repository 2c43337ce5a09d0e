"""Refining the steps of a table until interpolation errs less than a tolerance."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from trackctl.errors import NoAnswerError
from trackctl.lut.certificate import certify, random_along
from trackctl.lut.crew import solve_columns, threads
from trackctl.lut.grid import cell_count
from trackctl.lut.interpolation import Interpolant
from trackctl.workflows.table_request import TableRequest
from trackctl.workflows.table_steps import AXES, ChosenSteps, refined
from trackctl.workflows.table_summary import certificate_of, count_status, ready_for_lookup

#: Points that the error of one axis is measured at.
POINTS_PER_AXIS = 1000
#: The error of moving least squares falls with this power of the step.
ORDER = 3.0
LEAST_FACTOR, LARGEST_FACTOR = 1.25, 2.0
#: The axis that is not refined: its nodes are named by the user.
SLOPE = "slope"


def solved_table(request: TableRequest, jobs: int) -> Interpolant:
    """The table in memory.

    Raises
    ------
    NoAnswerError
        If no cell has converged.
    """
    sweep = request.sweep
    unknowns, status = np.empty((*sweep.axes.shape, 3)), np.empty(sweep.axes.shape, np.uint8)
    with threads(jobs) as crew:
        for column, cells in solve_columns(sweep, range(sweep.column_count), crew):
            i, k = sweep.place(column)
            unknowns[i, :, k], status[i, :, k] = cells["unknowns"], cells["status"]
    count_status(status)
    return ready_for_lookup(request, unknowns, status)


def axis_error(table: Interpolant, request: TableRequest, axis: str, jobs: int) -> float:
    """Error of interpolating along one axis alone, as a share of the vehicle's speed; infinite if none is known.

    Between the nodes of this axis and on those of the others, which interpolate exactly at their nodes.
    """
    random = np.random.default_rng((request.seed, (SLOPE, *AXES).index(axis)))
    points = random_along(request.axes, axis, POINTS_PER_AXIS, random)
    error = certify(table, request.model, points, request.seed, jobs).certified_error
    return math.inf if math.isnan(error) else error


def refine(
    request: TableRequest,
    steps: ChosenSteps,
    tolerance: float,
    most_cells: int,
    jobs: int,
    say: Callable[[str], None],
) -> ChosenSteps:
    """More divisions along the axes that measured error blames, until the held-out sample meets the tolerance.

    It meets it when all but a share of 1 - `CERTIFIED_SHARE` of its points err less. The largest error is stated
    beside, not bounded: sideslip and speeds change like a square root next to the fold where grip ends, so that there
    it hardly falls with the step.

    Parameters
    ----------
    request
        The table; its divisions are those of `steps`.
    steps
        Where to start.
    tolerance
        As a share of the vehicle's speed.
    most_cells
        Largest table.
    jobs
        Threads.
    say
        Told what is refined, and why.

    Raises
    ------
    NoAnswerError
        If the table would exceed `most_cells`, or no cell is feasible.
    """
    while True:
        request = request.divided(steps.divisions)
        table = solved_table(request, jobs)
        error = certificate_of(table, request, jobs).certified_error
        if error <= tolerance:
            return steps
        errors = {axis: axis_error(table, request, axis, jobs) for axis in varied_axes(request)}
        steps = finer(request, steps, errors, tolerance, most_cells)
        cells = request.divided(steps.divisions).axes.size
        shown = ", ".join(f"{axis} {percent(errors[axis])}" for axis in errors)
        say(f"held-out points err by {percent(error)} ({shown}): refining to {cells} cells")


def varied_axes(request: TableRequest) -> list[str]:
    """Axes of more than one node."""
    slope = [SLOPE] if request.slope.size > 1 else []
    return slope + [axis for axis in AXES if getattr(request.divisions, axis) > 0]


def percent(error: float) -> str:
    """A share in percent, or a word where it is not known."""
    return f"{100.0 * error:.2g} %" if math.isfinite(error) else "unknown"


def factor(error: float, tolerance: float) -> float:
    """By how much to divide a step more finely, for its error to fall to the tolerance."""
    return min(max(math.pow(error / tolerance, 1.0 / ORDER), LEAST_FACTOR), LARGEST_FACTOR)


def finer(
    request: TableRequest, steps: ChosenSteps, errors: dict[str, float], tolerance: float, most_cells: int
) -> ChosenSteps:
    """The steps refined along the worst axis and all that err by more than their part of the tolerance.

    Raises
    ------
    NoAnswerError
        If that makes the table too large.
    """
    if not errors:
        raise NoAnswerError(f"--tolerance {100.0 * tolerance:g} is not met, and no axis can be refined")
    part = tolerance / len(errors)
    worst = max(errors, key=errors.__getitem__)
    shown = f"{worst} errs most, by {percent(errors[worst])}"
    missed = f"--tolerance {100.0 * tolerance:g} is not met by {request.axes.size} cells: {shown}"
    if worst == SLOPE:
        raise NoAnswerError(f"{missed}: name more slopes in --slope-deg")
    reason = f"refined from the sensitivity's steps until interpolation errs by less than {100.0 * tolerance:g} %"
    for axis, error in errors.items():
        if axis != SLOPE and (axis == worst or error > part):
            steps = refined(steps, axis, factor(error, part), reason)
    if request.slope.size * cell_count(request.vehicle, request.ranges, steps.divisions) > most_cells:
        raise NoAnswerError(f"{missed}: finer steps exceed --budget {most_cells}")
    return steps
