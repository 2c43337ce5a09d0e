from dataclasses import replace

import numpy as np
import pytest

from trackctl.errors import NoAnswerError
from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.lut.grid import Divisions, default_ranges
from trackctl.workflows.refinement import axis_error, refine, solved_table
from trackctl.workflows.table_request import new_request
from trackctl.workflows.table_steps import ChosenSteps
from trackctl.workflows.table_summary import certificate_of

VEHICLE = load_vehicle("utv-61cm")
RANGES = replace(default_ranges(VEHICLE), velocity=(0.5, 1.5), radius=(1.0, 10.0))
COARSE = Divisions(4, 12, 8)


# Too slow for a turn to hold a vehicle on a slope that it cannot stand on.
SLOW = replace(RANGES, velocity=(0.1, 0.5))


def request(slopes_deg=(12.0,), divisions=COARSE, terrain="asphalt", ranges=RANGES):
    slope = np.radians(slopes_deg)
    return new_request(VEHICLE, load_terrain(terrain), 9.81, slope, ranges, "continuation", 0).divided(divisions)


def refined(tolerance, most_cells=100_000, **settings):
    said = []
    steps = refine(request(**settings), ChosenSteps(COARSE, RANGES, "coarse"), tolerance, most_cells, 1, said.append)
    return steps, said


def test_the_axis_that_errs_is_refined_until_the_held_out_sample_meets_the_tolerance():
    steps, said = refined(2e-4)
    assert certificate_of(solved_table(request(), 1), request(), 1).certified_error > 2e-4
    finer = request(divisions=steps.divisions)
    assert certificate_of(solved_table(finer, 1), finer, 1).certified_error <= 2e-4
    assert steps.divisions.heading > 2 * COARSE.heading
    assert steps.divisions.velocity < 2 * COARSE.velocity
    assert "refined" in steps.reason
    assert all("heading" in line for line in said)


def test_a_tolerance_that_is_met_changes_nothing():
    steps, said = refined(0.5)
    assert (steps.divisions, said) == (COARSE, [])


def test_more_headings_err_less_along_headings():
    errors = [
        axis_error(solved_table(asked, 1), asked, "heading", 1)
        for asked in (request(), request(divisions=replace(COARSE, heading=16)))
    ]
    assert errors[1] < 0.5 * errors[0]


def test_a_tolerance_beyond_the_budget_names_axis_and_error():
    with pytest.raises(NoAnswerError, match=r"heading errs most, by [0-9.e-]+ %: finer steps exceed --budget 2000"):
        refined(1e-9, 2000)


def test_slopes_are_for_the_user_to_name():
    with pytest.raises(NoAnswerError, match=r"slope errs most, .* name more slopes in --slope-deg"):
        refined(1e-3, slopes_deg=(0.0, 20.0), most_cells=10_000)


def test_a_table_without_a_feasible_cell_has_no_answer():
    with pytest.raises(NoAnswerError, match="no cell of the table is feasible"):
        refined(1e-3, slopes_deg=(40.0,), terrain="snow", ranges=SLOW)
