"""The steps of a table that nobody has named: under a budget of cells, or to a tolerance."""

from __future__ import annotations

from collections.abc import Callable

from trackctl.workflows.refinement import refine
from trackctl.workflows.step_budgets import DEFAULT_BUDGET
from trackctl.workflows.table_request import TableRequest
from trackctl.workflows.table_steps import ChosenSteps, cells_per_slope, sensitivity_of, steps_from_sensitivity


def steps_within(blank: TableRequest, budget: int, jobs: int) -> ChosenSteps:
    """Steps that the sensitivity indices give under a budget of cells.

    Raises
    ------
    UsageError
        If the budget suits no table.
    NoAnswerError
        If too few operating points are feasible.
    """
    each = cells_per_slope(blank.vehicle, blank.ranges, budget, blank.slope.size)
    return steps_from_sensitivity(blank.vehicle, blank.ranges, each, sensitivity_of(blank, jobs))


def steps_to_tolerance(
    blank: TableRequest, tolerance: float, most: int, jobs: int, say: Callable[[str], None]
) -> ChosenSteps:
    """Steps refined until interpolation errs by less than a share of the speed; see `refine`."""
    return refine(blank, steps_within(blank, min(most, DEFAULT_BUDGET), jobs), tolerance, most, jobs, say)
