import math
from dataclasses import replace

import numpy as np
import pytest

from trackctl.errors import NoAnswerError, UsageError
from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.lut.point import solve_points
from trackctl.mechanics.parameters import STANDARD_GRAVITY, track_model
from trackctl.sensitivity.pawn import Statistic
from trackctl.workflows import sensitivity as sensitivity_module
from trackctl.workflows.sensitivity import (
    INPUTS,
    OUTPUTS,
    SensitivityRequest,
    ranges_within,
    slope_steering_sensitivity,
)

VEHICLE, TERRAIN = load_vehicle("utv-61cm"), load_terrain("asphalt")
SLOPE = math.radians(12.13)
REQUEST = SensitivityRequest(
    VEHICLE, TERRAIN, STANDARD_GRAVITY, SLOPE, ranges_within(VEHICLE), samples=512, resamples=50
)


@pytest.fixture(scope="module")
def found():
    return slope_steering_sensitivity(REQUEST)


def test_ranges_left_out_are_the_vehicles():
    ranges = ranges_within(VEHICLE, radius=(2.0, 3.0))
    assert ranges.radius == (2.0, 3.0)
    assert ranges.velocity[1] == VEHICLE.max_speed
    assert ranges_within(VEHICLE, (0.5, 1.0), heading=(0.0, 1.0)).velocity == (0.5, 1.0)


def test_speed_matters_most(found):
    index = {(i.output, i.input): i.index for i in found.result.indices if i.statistic is Statistic.MEDIAN}
    for output in OUTPUTS:
        # The paper: less than half of it.
        assert max(index[output, "radius"], index[output, "heading"]) < 0.5 * index[output, "velocity"]


def test_there_is_an_index_for_every_combination(found):
    assert {(i.output, i.input) for i in found.result.indices} == {(o, i) for o in OUTPUTS for i in INPUTS}
    assert found.names == (*INPUTS, *OUTPUTS)


def test_the_sample_fills_the_ranges(found):
    for inputs, name in zip(found.inputs.T, INPUTS, strict=True):
        low, high = getattr(REQUEST.ranges, name)
        assert low <= inputs.min() <= inputs.max() <= high
        # A Latin hypercube has a point in each 512th of a range.
        assert np.ptp(inputs) >= 510 / 512 * (high - low)


def test_the_outputs_are_those_of_the_model(found):
    velocity, radius, heading = found.inputs.T
    points = np.column_stack((np.full(radius.size, SLOPE), velocity, 1.0 / radius, heading))
    cells = solve_points(track_model(VEHICLE, TERRAIN), points)
    speeds = cells["unknowns"][:, :2] * velocity[:, None]
    np.testing.assert_allclose(found.outputs * VEHICLE.sprocket_radius, speeds, rtol=1e-12)
    assert found.result.rows == np.isfinite(speeds[:, 0]).sum()


def test_jobs_and_batches_do_not_matter_but_the_seed(found):
    jobs = slope_steering_sensitivity(replace(REQUEST, jobs=2))
    assert jobs.result == found.result
    np.testing.assert_array_equal(jobs.outputs, found.outputs)
    assert slope_steering_sensitivity(replace(REQUEST, seed=1)).result != found.result


def test_progress_is_told(monkeypatch):
    monkeypatch.setattr(sensitivity_module, "BATCH", 200)
    told = []
    slope_steering_sensitivity(REQUEST, lambda *done: told.append(done))
    assert told == [(200, 512), (400, 512), (512, 512)]


def test_an_input_held_fixed_has_no_influence():
    fixed = replace(REQUEST, ranges=ranges_within(VEHICLE, heading=(1.0, 1.0)))
    indices = slope_steering_sensitivity(fixed).result.indices
    assert [index.index for index in indices if index.input == "heading"] == [0.0] * 4


def test_no_answer_at_all():
    slow = ranges_within(VEHICLE, velocity=(0.1, 0.5))
    slippery = replace(TERRAIN, friction_coefficient=0.1)
    with pytest.raises(NoAnswerError, match="no sampled operating point has an answer: 512 infeasible_grip"):
        slope_steering_sensitivity(replace(REQUEST, terrain=slippery, slope=math.radians(40.0), ranges=slow))


@pytest.mark.parametrize(
    ("change", "option"),
    [
        ({"samples": 50}, "--samples"),
        ({"slices": 1}, "--slices"),
        ({"resamples": 0}, "--resamples"),
        ({"confidence": 1.0}, "--confidence"),
        ({"slope": math.radians(45.0)}, "--slope-deg"),
        ({"ranges": ranges_within(VEHICLE, velocity=(0.0, 1.0))}, "--velocity-mps"),
        ({"ranges": ranges_within(VEHICLE, radius=(0.1, 1.0))}, "--radius-m"),
        ({"ranges": ranges_within(VEHICLE, heading=(0.0, 7.0))}, "--heading-deg"),
    ],
)
def test_what_is_not_allowed(change, option):
    with pytest.raises(UsageError, match=option):
        slope_steering_sensitivity(replace(REQUEST, **change))
