"""How finely a table is divided: by explicit steps, by sensitivity under a cell budget, or until its error is small."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from trackctl.errors import NoAnswerError, UsageError
from trackctl.lut.grid import (
    MOST_CELLS,
    Divisions,
    Ranges,
    cell_count,
    curvature_count,
    divisions_of,
    heading_count,
    nodes,
)
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.sensitivity.steps import axis_indices, divisions_from_indices
from trackctl.workflows.sensitivity import SensitivityRequest, SensitivityResult, slope_steering_sensitivity
from trackctl.workflows.table_request import TableRequest

AXES = ("velocity", "radius", "heading")
#: Enough to rank the axes; `trackctl sensitivity` takes more for its intervals.
SAMPLES, RESAMPLES = 2048, 200
#: Least divisions, whatever the indices say: influence is not interpolation error.
LEAST = Divisions(velocity=4, radius=12, heading=24)


@dataclass(frozen=True, slots=True, eq=False)
class ChosenSteps:
    """The divisions of a table and why they are so.

    Attributes
    ----------
    divisions
        Along each axis.
    ranges
        That they divide.
    reason
        One sentence.
    sensitivity
        The analysis that they were drawn from, if any.
    """

    divisions: Divisions
    ranges: Ranges
    reason: str
    sensitivity: SensitivityResult | None = None

    def step(self, axis: str) -> float:
        """Length of a step, 0 for an axis of one node. [m/s], [m] or [rad]"""
        low, high = getattr(self.ranges, axis)
        count = getattr(self.divisions, axis)
        return (high - low) / count if count else 0.0

    def attributes(self) -> dict[str, object]:
        """Steps in SI units and why, for the file."""
        return {**{f"step_{axis}": self.step(axis) for axis in AXES}, "step_reason": self.reason}


def explicit_steps(ranges: Ranges, velocity: float, radius: float, heading: float) -> ChosenSteps:
    """Steps as asked for, shrunk where they do not divide their range. [m/s], [m], [rad]"""
    given = {"velocity": velocity, "radius": radius, "heading": heading}
    counts = {}
    for axis, step in given.items():
        low, high = getattr(ranges, axis)
        counts[axis] = divisions_of(high - low, step, f"--steps {axis}")
    return ChosenSteps(Divisions(**counts), ranges, "explicit steps")


def least_divisions(ranges: Ranges) -> tuple[int, ...]:
    """Least divisions of each axis; none where a range is a single value."""
    return tuple(getattr(LEAST, axis) if getattr(ranges, axis)[1] > getattr(ranges, axis)[0] else 0 for axis in AXES)


def sensitivity_of(request: TableRequest, jobs: int) -> SensitivityResult:
    """Analysis at the steepest slope of a table where enough operating points are feasible.

    Raises
    ------
    NoAnswerError
        If there is none.
    """
    for slope in request.slope[::-1]:
        asked = SensitivityRequest(
            request.vehicle,
            request.terrain,
            request.gravity,
            float(slope),
            request.ranges,
            samples=SAMPLES,
            resamples=RESAMPLES,
            seed=request.seed,
            jobs=jobs,
        )
        try:
            return slope_steering_sensitivity(asked)
        except (NoAnswerError, UsageError) as error:
            reason = error
    raise NoAnswerError(f"too few operating points are feasible to draw the steps from ({reason}); name --steps")


def cells_per_slope(vehicle: VehicleProfile, ranges: Ranges, budget: int, slopes: int) -> int:
    """A budget of cells shared among slopes.

    Raises
    ------
    UsageError
        If the budget is too large for any table, or too small for the least one.
    """
    if budget > MOST_CELLS:
        raise UsageError("--budget", budget, f"at most {MOST_CELLS}")
    least = cell_count(vehicle, ranges, Divisions(*least_divisions(ranges)))
    if budget < least * slopes:
        shared = f": {least} for each of {slopes} slopes" if slopes > 1 else ""
        raise UsageError("--budget", budget, f"at least {least * slopes} cells{shared}")
    return budget // slopes


def steps_from_sensitivity(
    vehicle: VehicleProfile, ranges: Ranges, budget: int, found: SensitivityResult
) -> ChosenSteps:
    """Divisions in proportion to the PAWN indices, as many as a budget of cells per slope allows."""
    indices = axis_indices(found.result.indices, AXES)
    counts: list[Callable[[int], int]] = [
        lambda d: nodes(ranges.velocity, d),
        lambda d: curvature_count(vehicle, ranges, d),
        lambda d: heading_count(ranges, d),
    ]
    least = least_divisions(ranges)
    varied = [index if minimum else 0.0 for index, minimum in zip(indices, least, strict=True)]
    divisions = Divisions(*divisions_from_indices(varied, budget, least, counts))
    shown = ", ".join(f"{axis} {index:.2f}" for axis, index in zip(AXES, indices, strict=True))
    reason = f"divisions follow the PAWN indices ({shown}) under a budget of {budget} cells a slope"
    return ChosenSteps(divisions, ranges, reason, found)


def refined(steps: ChosenSteps, axis: str, factor: float, reason: str) -> ChosenSteps:
    """The same with more divisions along one axis."""
    count = int(np.ceil(getattr(steps.divisions, axis) * factor))
    return replace(steps, divisions=replace(steps.divisions, **{axis: count}), reason=reason)
