import math

import numpy as np
import pytest

from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.lut.axes import FULL_CIRCLE, Axes
from trackctl.lut.certificate import (
    CERTIFIED_SHARE,
    certify,
    check_by_swarm,
    random_along,
    random_arcs,
    random_near_straight,
)
from trackctl.lut.interpolation import interpolant_of
from trackctl.lut.point import solve_points
from trackctl.lut.table import Status
from trackctl.mechanics.parameters import track_model

VEHICLE = load_vehicle("utv-61cm")
MODEL = track_model(VEHICLE, load_terrain("asphalt"))
RADII = np.linspace(1.0, 5.0, 9)
BOTH_SIDES = Axes(
    slope=np.radians([5.0, 10.0]),
    velocity=np.linspace(0.5, 1.5, 5),
    curvature=np.concatenate((-1.0 / RADII, [0.0], 1.0 / RADII[::-1])),
    heading=np.arange(12) * FULL_CIRCLE / 12,
    heading_is_periodic=True,
)
LEFT_ONLY = Axes(
    np.radians([10.0]), BOTH_SIDES.velocity, np.concatenate(([0.0], 1.0 / RADII[::-1])), BOTH_SIDES.heading, True
)


def solved(axes):
    nodes = np.stack(np.meshgrid(axes.slope, axes.velocity, axes.curvature, axes.heading, indexing="ij"), -1)
    cells = solve_points(MODEL, nodes.reshape(-1, 4)).reshape(axes.shape)
    return cells["unknowns"].copy(), cells["status"].copy()


@pytest.fixture(scope="module")
def table():
    return solved(LEFT_ONLY)


def ready(unknowns, status):
    return interpolant_of(LEFT_ONLY, unknowns.copy(), status, VEHICLE, math.inf)


def test_arcs_are_uniform_in_radius_heading_and_speed_on_both_sides():
    points = random_arcs(BOTH_SIDES, 4000, np.random.default_rng(1))
    radius = 1.0 / points[:, 2]
    shares = {
        "speed": (points[:, 1] - 0.5) / 1.0,
        "radius": (np.abs(radius) - 1.0) / 4.0,
        "heading": points[:, 3] / FULL_CIRCLE,
    }
    for share in shares.values():
        assert share.min() >= 0.0
        assert share.max() < 1.0 + 1e-12
        # Means of 4000 uniform draws scatter by 0.0046.
        assert share.mean() == pytest.approx(0.5, abs=0.02)
    assert (radius > 0.0).mean() == pytest.approx(0.5, abs=0.04)
    assert (random_arcs(LEFT_ONLY, 100, np.random.default_rng(1))[:, 2] > 0.0).all()


def test_headings_of_a_sector_stay_within_its_nodes():
    sector = Axes(LEFT_ONLY.slope, LEFT_ONLY.velocity, LEFT_ONLY.curvature, np.radians([30.0, 60.0]), False)
    heading = np.degrees(random_arcs(sector, 500, np.random.default_rng(0))[:, 3])
    assert heading.min() >= 30.0
    assert heading.max() <= 60.0


def test_near_straight_points_lie_beyond_the_largest_radius():
    curvature = random_near_straight(BOTH_SIDES, 500, np.random.default_rng(0))[:, 2]
    assert np.abs(curvature).max() < 1.0 / RADII[-1]
    assert {-1.0, 1.0} <= set(np.sign(curvature))


@pytest.mark.parametrize("axis", ["slope", "velocity", "radius", "heading"])
def test_points_along_an_axis_are_on_the_nodes_of_the_others(axis):
    points = random_along(BOTH_SIDES, axis, 50, np.random.default_rng(0))
    nodes = (BOTH_SIDES.slope, BOTH_SIDES.velocity, BOTH_SIDES.curvature, BOTH_SIDES.heading)
    names = ("slope", "velocity", "radius", "heading")
    on_nodes = {
        name for name, values, column in zip(names, nodes, points.T, strict=True) if np.isin(column, values).all()
    }
    assert on_nodes == set(names) - {axis}


def test_the_table_is_exact_on_its_nodes(table):
    points = random_along(LEFT_ONLY, "velocity", 50, np.random.default_rng(0))
    points[:, 1] = np.random.default_rng(0).choice(LEFT_ONLY.velocity, 50)
    # Two solutions of one root agree to 1e-9.
    assert certify(ready(*table), MODEL, points, 0, 1).max_error < 1e-8


def test_errors_are_those_of_the_points(table):
    points = random_arcs(LEFT_ONLY, 200, np.random.default_rng(0))
    found = certify(ready(*table), MODEL, points, 0, 1)
    assert 0.0 < found.rms_error < found.certified_error < found.max_error < 0.01
    assert found.points + found.unanswered <= 200
    assert 0.9 < CERTIFIED_SHARE < 1.0


def test_a_wrong_table_shows_its_error(table):
    unknowns, status = table
    points = random_arcs(LEFT_ONLY, 50, np.random.default_rng(0))
    assert certify(ready(unknowns + 0.1, status), MODEL, points, 0, 1).rms_error == pytest.approx(0.1, rel=0.05)


def test_points_without_a_table_are_unanswered_and_the_error_unknown(table):
    unknowns, status = table
    empty = np.full_like(status, Status.INFEASIBLE_GRIP)
    found = certify(ready(unknowns, empty), MODEL, random_arcs(LEFT_ONLY, 20, np.random.default_rng(0)), 0, 1)
    assert math.isnan(found.max_error)
    assert (found.points, found.unanswered, found.unfounded) == (0, 20, 0)


def test_answers_where_the_model_has_none_are_unfounded(table):
    unknowns, status = table
    points = random_arcs(LEFT_ONLY, 20, np.random.default_rng(0))
    slippery = track_model(VEHICLE, load_terrain("snow"), gravity=1e-3)
    assert certify(ready(unknowns, status), slippery, points, 0, 1).unfounded == 20


def test_swarms_agree_with_the_table(table):
    found = check_by_swarm(MODEL, LEFT_ONLY, *table, count=60, seed=0, jobs=1)
    assert (found.cells, found.disagreements) == (60, 0)


def test_swarms_find_wrong_roots_and_wrong_feasibility(table):
    unknowns, status = (array.copy() for array in table)
    unknowns[:, 0] += 1e-4
    status[:, 1] = Status.INFEASIBLE_GRIP
    found = check_by_swarm(MODEL, LEFT_ONLY, unknowns, status, count=LEFT_ONLY.size, seed=0, jobs=1)
    a_row = LEFT_ONLY.size // LEFT_ONLY.velocity.size
    assert found.cells == LEFT_ONLY.size
    assert 0.9 * a_row <= found.different_root <= a_row
    assert 0.9 * a_row <= found.different_feasibility <= 1.1 * a_row


def test_the_largest_seed_is_taken(table):
    assert check_by_swarm(MODEL, LEFT_ONLY, *table, count=4, seed=2**63 - 1, jobs=1).cells == 4
