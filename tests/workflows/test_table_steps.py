import math
from dataclasses import replace

import numpy as np
import pytest

from trackctl.errors import NoAnswerError, UsageError
from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.lut.grid import Divisions, cell_count, default_ranges
from trackctl.workflows.table_request import new_request
from trackctl.workflows.table_steps import (
    LEAST,
    cells_per_slope,
    explicit_steps,
    refined,
    sensitivity_of,
    steps_from_sensitivity,
)

VEHICLE, ASPHALT = load_vehicle("utv-61cm"), load_terrain("asphalt")
RANGES = default_ranges(VEHICLE)


def request(terrain=ASPHALT, slopes_deg=(12.0,), ranges=RANGES):
    return new_request(VEHICLE, terrain, 9.81, np.radians(slopes_deg), ranges, "continuation", 0)


@pytest.fixture(scope="module")
def found():
    return sensitivity_of(request(), 1)


def test_explicit_steps_are_shrunk_to_divide_their_range():
    ranges = replace(RANGES, velocity=(0.5, 2.0), radius=(1.0, 2.0), heading=(0.5, 0.5))
    steps = explicit_steps(ranges, 0.4, 7.0, 0.1)
    assert steps.divisions == Divisions(4, 1, 0)
    assert (steps.step("velocity"), steps.step("radius"), steps.step("heading")) == (0.375, 1.0, 0.0)


def test_steps_follow_the_indices_within_the_budget(found):
    steps = steps_from_sensitivity(VEHICLE, RANGES, 50_000, found)
    divisions = steps.divisions
    assert 0.9 * 50_000 < cell_count(VEHICLE, RANGES, divisions) <= 50_000
    assert divisions.velocity > 2 * max(divisions.radius, divisions.heading)
    assert "PAWN" in steps.reason
    assert steps.sensitivity is found
    assert steps.attributes()["step_heading"] == pytest.approx(math.tau / divisions.heading)


def test_a_range_of_one_value_is_not_divided(found):
    ranges = replace(RANGES, velocity=(1.0, 1.0))
    assert steps_from_sensitivity(VEHICLE, ranges, 5000, found).divisions.velocity == 0


def test_the_budget_is_shared_among_slopes():
    assert cells_per_slope(VEHICLE, RANGES, 10_000, 3) == 3333


@pytest.mark.parametrize(("budget", "slopes"), [(1, 1), (10_000, 100), (10**12, 1)])
def test_budgets_that_hold_no_table_are_refused(budget, slopes):
    with pytest.raises(UsageError, match=f"--budget: {budget} is not allowed"):
        cells_per_slope(VEHICLE, RANGES, budget, slopes)


def test_the_steepest_feasible_slope_is_analysed(found):
    steep = sensitivity_of(request(load_terrain("snow"), (2.0, 40.0)), 1)
    assert np.isfinite(steep.outputs).all(axis=1).sum() >= 100
    with pytest.raises(NoAnswerError, match="name --steps"):
        sensitivity_of(request(load_terrain("snow"), (40.0,)), 1)


def test_refining_multiplies_one_axis(found):
    steps = steps_from_sensitivity(VEHICLE, RANGES, 5000, found)
    finer = refined(steps, "heading", 1.5, "why")
    assert finer.divisions == replace(steps.divisions, heading=math.ceil(1.5 * steps.divisions.heading))
    assert finer.reason == "why"
    assert steps.divisions.heading >= LEAST.heading
