import math
from dataclasses import replace

import numpy as np
import pytest

from trackctl.errors import NoAnswerError, UsageError
from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.lut.point import solve_points
from trackctl.lut.table import Status
from trackctl.mechanics.parameters import STANDARD_GRAVITY, track_model
from trackctl.workflows.sweep import (
    SweepRequest,
    reasons,
    rmse,
    rows_of,
    status_counts,
    summary_columns,
    sweep,
    tidy_columns,
)

VEHICLE, TERRAIN = load_vehicle("utv-61cm"), load_terrain("asphalt")
HEADING = np.radians(np.arange(0.0, 360.0, 3.0))
EASY, HARD = np.sin(HEADING) > 1e-9, np.sin(HEADING) < -1e-9


def request(slopes=(3, 5, 8, 10, 12), velocities=(2,), radius=20.0, heading=HEADING, vehicle=VEHICLE, **others):
    return SweepRequest(
        vehicle,
        TERRAIN,
        STANDARD_GRAVITY,
        np.radians(slopes),
        np.array(velocities, float),
        radius,
        np.asarray(heading),
        **others,
    )


@pytest.fixture(scope="module")
def over_slopes():
    """The paper's figures 7 to 10."""
    return sweep(request())


@pytest.fixture(scope="module")
def over_velocities():
    """The paper's figures 11 to 14."""
    return sweep(request(slopes=(5,), velocities=(2, 4, 6, 8)))


@pytest.fixture(scope="module")
def at_the_limit():
    """A turn so quick that half of its headings have no grip."""
    return sweep(request(slopes=(0, 5, 12), velocities=(6,), radius=5.0))


def test_the_outer_track_slips_and_the_inner_track_skids(over_slopes, over_velocities):
    for result in (over_slopes, over_velocities):
        assert np.all(result.slip_outer.mean(axis=-1) > 0.0)
        assert np.all(result.slip_inner.mean(axis=-1) < 0.0)
    level = sweep(request(slopes=(0,), velocities=(0.5, 1, 2, 4, 8)))
    assert np.all(level.slip_outer > 0.0)
    assert np.all(level.slip_inner < 0.0)


def test_errors_grow_with_slope(over_slopes):
    for side in ("inner", "outer"):
        assert np.all(np.diff(summary_columns(over_slopes)[f"rmse_{side}_mps"]) > 0.0)


def test_errors_grow_with_speed(over_velocities):
    for side in ("inner", "outer"):
        assert np.all(np.diff(summary_columns(over_velocities)[f"rmse_{side}_mps"]) > 0.0)


def test_without_slip_the_tracks_would_turn_tighter(over_slopes):
    assert np.all(over_slopes.theoretical_radius < 20.0)
    assert np.all(np.diff(summary_columns(over_slopes)["min_radius_m"]) < 0.0)


def test_gravity_towards_the_turning_centre_is_the_easy_half(over_slopes, at_the_limit):
    for track, body in (("track_speed_inner", "body_speed_inner"), ("track_speed_outer", "body_speed_outer")):
        error = np.abs(getattr(over_slopes, track) - getattr(over_slopes, body))
        assert np.all(error[..., HARD].mean(axis=-1) > error[..., EASY].mean(axis=-1))
    summary = summary_columns(over_slopes)
    assert np.all(np.sin(summary["max_radius_heading_rad"]) > 0.0)
    assert np.all(np.sin(summary["min_radius_heading_rad"]) < 0.0)
    lost = at_the_limit.status[1:] == Status.INFEASIBLE_GRIP
    assert np.all(lost[..., HARD].sum(axis=-1) > 4 * lost[..., EASY].sum(axis=-1))


def test_the_mirror_of_a_turn(over_slopes):
    right = sweep(request(radius=-20.0, heading=np.sort(-HEADING % (2.0 * np.pi))))
    mirrored = np.argsort(-HEADING % (2.0 * np.pi))
    for name in ("track_speed_inner", "body_speed_outer", "slip_inner", "slip_outer"):
        np.testing.assert_allclose(getattr(right, name), getattr(over_slopes, name)[..., mirrored], atol=1e-9)
    for name in ("sideslip", "theoretical_radius"):
        np.testing.assert_allclose(
            getattr(right, name), -getattr(over_slopes, name)[..., mirrored], rtol=1e-8, atol=1e-9
        )


def test_on_level_ground_the_heading_does_not_matter():
    level = sweep(request(slopes=(0,), velocities=(1, 4)))
    for speeds in (level.track_speed_inner, level.track_speed_outer, level.theoretical_radius):
        np.testing.assert_allclose(speeds, np.broadcast_to(speeds[..., :1], speeds.shape), rtol=1e-9)


def test_a_mass_centre_off_the_centreline_keeps_the_driving_speeds_of_the_tracks():
    """At the tracks the hull moves at v cos(beta) -+ v kappa (B/2 +- c_l): a rigid body's speeds."""
    vehicle = replace(VEHICLE, cog_left=0.05)
    for radius in (20.0, -20.0):
        found = sweep(request(slopes=(8,), radius=radius, vehicle=vehicle))
        difference = found.body_speed_outer - found.body_speed_inner
        np.testing.assert_allclose(difference, 2.0 * vehicle.track_gauge / abs(radius), rtol=1e-12)
        centre = 0.5 * (found.body_speed_outer + found.body_speed_inner)
        np.testing.assert_allclose(centre, 2.0 * (np.cos(found.sideslip) + 0.05 / radius), rtol=1e-12)


def test_each_point_is_solved_as_on_its_own(at_the_limit):
    points = np.array([(slope, 6.0, 0.2, heading) for slope in at_the_limit.request.slope for heading in HEADING])
    cells = solve_points(track_model(VEHICLE, TERRAIN), points)
    np.testing.assert_array_equal(at_the_limit.status.ravel(), cells["status"])
    speeds = np.where(cells["status"] == Status.CONVERGED, 6.0 * cells["unknowns"].T, np.nan)
    np.testing.assert_allclose(at_the_limit.track_speed_inner.ravel(), speeds[0], rtol=1e-7)
    np.testing.assert_allclose(at_the_limit.track_speed_outer.ravel(), speeds[1], rtol=1e-7)


def test_root_mean_square_error():
    assert rmse(np.array([[1.0, 2.0, np.nan]]), np.array([[4.0, 6.0, 1.0]])) == pytest.approx(math.sqrt(12.5))
    assert np.isnan(rmse(np.array([np.nan]), np.array([1.0])))


def test_summary_is_of_the_rows(at_the_limit):
    summary, tidy = summary_columns(at_the_limit), tidy_columns(at_the_limit)
    for row in range(3):
        part = slice(row * HEADING.size, (row + 1) * HEADING.size)
        speed, body = tidy["track_speed_outer_mps"][part], tidy["body_speed_outer_mps"][part]
        found = np.isfinite(speed)
        assert summary["rmse_outer_mps"][row] == pytest.approx(np.sqrt(np.mean((speed - body)[found] ** 2)))
        radius, heading = tidy["theoretical_radius_m"][part], tidy["heading_rad"][part]
        for name, place in (("max", np.nanargmax(radius)), ("min", np.nanargmin(radius))):
            assert summary[f"{name}_radius_m"][row] == radius[place]
            assert summary[f"{name}_radius_heading_rad"][row] == heading[place]
        assert (
            summary["infeasible_count"][row] == (~found).sum() == np.sum(np.array(tidy["status"][part]) != "converged")
        )


def test_theoretical_radius_is_that_of_the_track_speeds(over_slopes):
    inner, outer = over_slopes.track_speed_inner, over_slopes.track_speed_outer
    expected = 0.5 * VEHICLE.track_gauge * (outer + inner) / (outer - inner)
    np.testing.assert_allclose(over_slopes.theoretical_radius, expected, rtol=1e-12)


def test_the_straightest_turn_may_bend_the_other_way():
    """Nearly straight across a slope, tracks that run equally fast, or the other way round, lie within the headings."""
    found = sweep(request(slopes=(25,), velocities=(1,), radius=200.0))
    curvature = 1.0 / found.theoretical_radius
    summary = summary_columns(found)
    assert curvature.min() < 0.0 < curvature.max()
    assert summary["max_radius_m"] == 1.0 / curvature.min()
    assert summary["min_radius_m"] == 1.0 / curvature.max()


def test_a_row_without_any_answer_is_empty():
    found = sweep(request(slopes=(3,), velocities=(2, 12), radius=5.0))
    slow, fast = rows_of(summary_columns(found))
    assert None not in slow.values()
    assert (fast["infeasible_count"], fast["rmse_inner_mps"], fast["max_radius_m"]) == (HEADING.size, None, None)
    assert fast["min_radius_heading_rad"] is None
    assert status_counts(found)["infeasible_grip"] == HEADING.size
    assert reasons(found) == f"{HEADING.size} infeasible_grip"


def test_no_answer_at_all():
    with pytest.raises(NoAnswerError, match="none of the 120 operating points has an answer: 120 infeasible_grip"):
        sweep(request(slopes=(3,), velocities=(12,), radius=5.0))


def test_jobs_do_not_matter_and_progress_is_told(over_slopes):
    told = []
    again = sweep(request(jobs=2), lambda *done: told.append(done))
    np.testing.assert_array_equal(again.track_speed_inner, over_slopes.track_speed_inner)
    assert told == [(done, 5) for done in range(1, 6)]


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"slopes": (45,)}, r"--slope-deg: 45 is not allowed; allowed: 0 or more, below 45"),
        ({"slopes": (-1,)}, "--slope-deg: -1"),
        ({"velocities": (0, 1)}, "--velocity-mps: 0 is not allowed; allowed: above 0"),
        ({"radius": 0.3}, r"--radius-m: 0.3 is not allowed; allowed: finite, above 0.305"),
        ({"radius": math.inf}, "--radius-m: inf"),
        ({"radius": math.nan}, "--radius-m: nan"),
        ({"heading": np.array([0.0, 6.3])}, "--heading-deg: 360.963"),
        ({"heading": np.array([-0.1])}, "--heading-deg: -5.7"),
        ({"slopes": np.linspace(0, 40, 1000), "velocities": np.arange(1, 1000)}, r"a sweep of 1.2e\+08 rows"),
    ],
)
def test_what_is_not_allowed(change, problem):
    with pytest.raises(UsageError, match=problem):
        sweep(request(**change))
