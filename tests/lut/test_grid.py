import math
from dataclasses import replace

import numpy as np
import pytest

from trackctl.errors import UsageError
from trackctl.files.profile_yaml import load_vehicle
from trackctl.lut.axes import FULL_CIRCLE
from trackctl.lut.grid import Divisions, Ranges, cell_count, check_ranges, default_ranges, divisions_of, make_axes

VEHICLE = load_vehicle("utv-61cm")
SLOPE = np.radians([12.0])
DIVISIONS = Divisions(2, 4, 12)
RANGES = Ranges(velocity=(0.5, 1.0), radius=(1.0, 5.0), heading=(0.0, FULL_CIRCLE))


def axes_of(vehicle=VEHICLE, divisions=DIVISIONS, **ranges):
    return make_axes(vehicle, SLOPE, replace(RANGES, **ranges), divisions)


def test_default_ranges_are_allowed_and_reach_from_the_tightest_turn_to_the_top_speed():
    ranges = default_ranges(VEHICLE)
    check_ranges(VEHICLE, SLOPE, ranges)
    assert ranges.velocity[1] == VEHICLE.max_speed
    assert ranges.radius == (1.2 * 0.5 * VEHICLE.track_gauge, 60.0 * VEHICLE.track_gauge)
    assert default_ranges(replace(VEHICLE, min_turn_radius=3.0)).radius[0] == 3.0


def test_nodes_are_uniform_in_velocity_radius_and_heading_and_hold_straight_driving():
    axes = axes_of()
    assert axes.velocity == pytest.approx([0.5, 0.75, 1.0])
    assert axes.radius[::-1] == pytest.approx([1.0, 2.0, 3.0, 4.0, 5.0, math.inf])
    assert axes.heading == pytest.approx(np.arange(12) * FULL_CIRCLE / 12)
    assert axes.heading_is_periodic


def test_a_vehicle_with_its_mass_centre_off_the_centreline_gets_turns_to_both_sides():
    axes = axes_of(replace(VEHICLE, cog_left=0.02))
    assert axes.curvature == pytest.approx(-axes.curvature[::-1])
    assert np.count_nonzero(axes.curvature == 0.0) == 1


@pytest.mark.parametrize(
    ("ends_deg", "divisions", "nodes_deg", "periodic"),
    [
        ((0, 180), 2, [0, 90, 180], False),
        ((270, 360), 3, [270, 300, 330], False),
        ((90, 90), 0, [90], False),
        ((0, 360), 1, [0], False),
        ((0, 360), 2, [0, 180], True),
    ],
)
def test_headings_hold_both_ends_but_360(ends_deg, divisions, nodes_deg, periodic):
    axes = axes_of(divisions=Divisions(2, 4, divisions), heading=tuple(map(math.radians, ends_deg)))
    assert np.degrees(axes.heading) == pytest.approx(nodes_deg)
    assert axes.heading_is_periodic is periodic


@pytest.mark.parametrize("cog_left", [0.0, -0.02])
@pytest.mark.parametrize("ends_deg", [(0, 360), (270, 360), (0, 180)])
def test_cells_are_counted_without_making_axes(cog_left, ends_deg):
    vehicle, divisions = replace(VEHICLE, cog_left=cog_left), Divisions(3, 5, 7)
    ranges = replace(RANGES, heading=tuple(map(math.radians, ends_deg)))
    assert cell_count(vehicle, ranges, divisions) == make_axes(vehicle, SLOPE, ranges, divisions).size


@pytest.mark.parametrize(
    ("width", "step", "divisions"), [(1.0, 0.25, 4), (1.0, 0.3, 4), (1.0, 7.0, 1), (0.0, 0.1, 0), (0.3, 0.1, 3)]
)
def test_a_step_is_shrunk_until_it_divides_its_range(width, step, divisions):
    assert divisions_of(width, step, "--steps velocity") == divisions


@pytest.mark.parametrize("step", [0.0, -1.0, math.nan, math.inf, 1e-300])
def test_steps_that_make_no_grid_are_refused(step):
    with pytest.raises(UsageError, match=r"--steps velocity: .* is not allowed"):
        divisions_of(1.0, step, "--steps velocity")


@pytest.mark.parametrize(
    ("option", "slope_deg", "ranges"),
    [
        ("--slope-deg", 45.0, {}),
        ("--slope-deg", -1.0, {}),
        ("--slope-deg", math.nan, {}),
        ("--velocity-mps", 12.0, {"velocity": (0.0, 1.0)}),
        ("--velocity-mps", 12.0, {"velocity": (2.0, 1.0)}),
        ("--radius-m", 12.0, {"radius": (0.3, 1.0)}),
        ("--radius-m", 12.0, {"radius": (1.0, math.inf)}),
        ("--heading-deg", 12.0, {"heading": (-0.1, 1.0)}),
        ("--heading-deg", 12.0, {"heading": (0.0, 6.4)}),
        ("--heading-deg", 12.0, {"heading": (FULL_CIRCLE, FULL_CIRCLE)}),
    ],
)
def test_ranges_that_no_table_can_hold_are_refused(option, slope_deg, ranges):
    with pytest.raises(UsageError) as refused:
        check_ranges(VEHICLE, np.radians([slope_deg]), replace(RANGES, **ranges))
    assert refused.value.option == option


def test_a_table_of_a_million_million_cells_is_refused_before_memory_is_taken():
    with pytest.raises(UsageError, match=r"--steps: a table of 1e\+12 cells"):
        axes_of(divisions=Divisions(10**4, 10**4, 10**4))
