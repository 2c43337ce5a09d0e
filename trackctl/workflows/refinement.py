"""Refining the steps of a table until interpolation errs less than a tolerance."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from trackctl.errors import NoAnswerError
from trackctl.lut.axes import Axes
from trackctl.lut.certificate import certify, random_arcs
from trackctl.lut.grid import cell_count
from trackctl.lut.interpolation import interpolant_of
from trackctl.lut.point import solve_points
from trackctl.workflows.compute_lut import TableRequest
from trackctl.workflows.table_steps import AXES, ChosenSteps, refined

#: Lines of cells along an axis, and points between their nodes, that its error is measured on.
LINES = 24
POINTS_PER_LINE = 40
#: The error of moving least squares falls with this power of the step.
ORDER = 3.0
LEAST_FACTOR, LARGEST_FACTOR = 1.15, 2.0


def line_through(axes: Axes, axis: str, random: np.random.Generator) -> Axes:
    """One axis whole, the others at one random node (a turn, not straight driving)."""
    slope, velocity = random.choice(axes.slope, 1), random.choice(axes.velocity, 1)
    curvature, heading = random.choice(axes.curvature[axes.curvature > 0.0], 1), random.choice(axes.heading, 1)
    if axis == "velocity":
        return Axes(slope, axes.velocity, curvature, heading, heading_is_periodic=False)
    if axis == "radius":
        return Axes(slope, velocity, axes.curvature, heading, heading_is_periodic=False)
    return Axes(slope, velocity, curvature, axes.heading, axes.heading_is_periodic)


def axis_error(request: TableRequest, axis: str, jobs: int) -> float:
    """Largest error of interpolating along one axis alone, as a share of the vehicle's speed; NaN if none is known."""
    random = np.random.default_rng((request.seed, AXES.index(axis)))
    model, axes = request.model, request.axes
    largest = math.nan
    for _ in range(LINES):
        line = line_through(axes, axis, random)
        nodes = np.stack(
            np.meshgrid(line.slope, line.velocity, line.curvature, line.heading, indexing="ij"), -1
        )
        cells = solve_points(model, nodes.reshape(-1, 4), seed=request.seed, jobs=jobs).reshape(line.shape)
        table = interpolant_of(line, cells["unknowns"].copy(), cells["status"], request.vehicle, math.inf)
        points = random_arcs(line, POINTS_PER_LINE, random)
        if line.curvature.size == 1:
            points[:, 2] = line.curvature[0]
        largest = float(np.fmax(largest, certify(table, model, points, request.seed, jobs).max_error))
    return largest


def refine(
    request: TableRequest,
    steps: ChosenSteps,
    tolerance: float,
    most_cells: int,
    jobs: int,
    say: Callable[[str], None],
) -> ChosenSteps:
    """More divisions along the axes that measured error blames, until their errors add up to the tolerance.

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
        If the table would exceed `most_cells`.
    """
    errors = {axis: axis_error(request, axis, jobs) for axis in varied_axes(steps)}
    while math.fsum(error for error in errors.values() if error == error) > tolerance:
        worst = max(errors, key=lambda axis: np.nan_to_num(errors[axis]))
        share = errors[worst] * len(errors) / tolerance
        factor = min(max(share ** (1.0 / ORDER), LEAST_FACTOR), LARGEST_FACTOR)
        steps = finer(request, steps, worst, factor, tolerance, errors[worst], most_cells)
        say(
            f"refining {worst} to {getattr(steps.divisions, worst)} steps: error {100.0 * errors[worst]:.3g} %"
        )
        request = replace(request, divisions=steps.divisions)
        errors[worst] = axis_error(request, worst, jobs)
    return steps


def refined_further(
    request: TableRequest, steps: ChosenSteps, tolerance: float, error: float, most_cells: int, jobs: int
) -> ChosenSteps:
    """Steps for another try, after the held-out sample erred by more than the tolerance."""
    errors = {axis: np.nan_to_num(axis_error(request, axis, jobs)) for axis in varied_axes(steps)}
    worst = max(errors, key=errors.__getitem__)
    factor = min(max((error / tolerance) ** (1.0 / ORDER), LEAST_FACTOR), LARGEST_FACTOR)
    return finer(request, steps, worst, factor, tolerance, error, most_cells)


def varied_axes(steps: ChosenSteps) -> list[str]:
    """Axes of more than one node."""
    return [axis for axis in AXES if getattr(steps.divisions, axis) > 0]


def finer(
    request: TableRequest,
    steps: ChosenSteps,
    axis: str,
    factor: float,
    tolerance: float,
    error: float,
    most_cells: int,
) -> ChosenSteps:
    """The steps with one axis refined, or a `NoAnswerError` where that makes the table too large."""
    reason = (
        f"refined from the sensitivity's steps until interpolation errs by less than {100.0 * tolerance:g} %"
    )
    steps = refined(steps, axis, factor, reason)
    cells = request.slope.size * cell_count(request.vehicle, request.ranges, steps.divisions)
    if cells > most_cells:
        raise NoAnswerError(
            f"--tolerance {100.0 * tolerance:g} is not met within --budget {most_cells} cells: "
            f"{axis} still errs by {100.0 * error:.3g} %"
        )
    return steps
