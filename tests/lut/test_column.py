"""Columns of a table against the oracle, against single points, and against themselves solved another way."""

from __future__ import annotations

import functools
import math
from dataclasses import replace

import numpy as np
import pytest
from model_cases import DOCUMENTED, SMALL, Array, evaluate, model_of, random_points
from oracle import OraclePoint, Triple, balance, default_starts, det_sign, roots

from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.lut.cells import Cells, pending_cells
from trackctl.lut.column import Column, solve_column
from trackctl.lut.point import solve_points
from trackctl.lut.solver import solver
from trackctl.lut.table import Status

CONVERGED, NOT_CONVERGED = Status.CONVERGED, Status.NOT_CONVERGED
CIRCLE = np.arange(24) * 2.0 * math.pi / 24
# The package's quadrature moves a root by 1e-3 at most, and distinct roots lie much further apart.
SAME_ROOT = 2e-3
# Two ways to the same root leave a residual of 1e-10 each, and a condition of up to 100.
SAME_ANSWER = 1e-8


def profiles(vehicle: str, terrain: str, slope_deg: float, curvature: float) -> OraclePoint:
    """A shipped vehicle on a shipped terrain; velocity and heading are the column's."""
    body, ground = load_vehicle(vehicle), load_terrain(terrain)
    return OraclePoint(
        mass=body.mass,
        gauge=body.track_gauge,
        width=body.track_width,
        length=body.contact_length,
        cog_height=body.cog_height,
        cog_forward=body.cog_forward,
        cog_left=body.cog_left,
        friction=ground.friction_coefficient,
        shear_modulus=ground.shear_deformation_modulus,
        cohesion=ground.cohesion,
        resistance=ground.motion_resistance_coefficient,
        gravity=9.80665,
        slope=math.radians(slope_deg),
        velocity=0.0,
        curvature=curvature,
        heading=0.0,
    )


def solve(point: OraclePoint, velocity: Array, heading: Array = CIRCLE, *, seed: int = 0) -> Cells:
    """Cells of the point's vehicle, slope and curvature, shape (n_velocity, n_heading)."""
    cells = pending_cells((velocity.size, heading.size))
    periodic = heading.size > 1 and bool(np.isclose(heading[-1] + heading[1] - 2 * heading[0], 2 * math.pi))
    # A strided array would be compiled for anew.
    column = Column(
        point.slope, point.curvature, np.ascontiguousarray(velocity), np.ascontiguousarray(heading), periodic, seed
    )
    solve_column(solver(model_of(point)), column, cells)
    return cells


def solve_points_of(point: OraclePoint, velocity: Array, heading: Array = CIRCLE, seed: int = 0) -> Cells:
    """The same cells, each on its own, by swarms."""
    rows = [[point.slope, v, point.curvature, phi] for v in velocity.tolist() for phi in heading.tolist()]
    cells = solve_points(model_of(point), np.array(rows), seed=seed, swarm_always=True)
    return cells.reshape(velocity.size, heading.size)


def answer(point: OraclePoint, found: Array) -> Triple | None:
    """The root that the model's description asks for: of smallest sideslip among those of positive determinant.

    The oracle also starts at what the package has found: 48 starts of its own may miss a root.
    """
    starts = default_starts(point, 48)
    if np.isfinite(found).all():
        starts = np.vstack((starts, found))
    return next((root for root in roots(point, starts) if det_sign(point, root) > 0), None)


def frontier(status: Array) -> Array:
    """Cells beside which the status changes, in velocity or round the circle."""
    changes = np.zeros(status.shape, dtype=bool)
    for axis in (0, 1):
        for step in (1, -1):
            beside = np.roll(status, step, axis)
            if axis == 0:
                beside[0 if step == 1 else -1] = status[0 if step == 1 else -1]
            changes |= beside != status
    return changes


def assert_cells_are_right(cells: Cells, point: OraclePoint, velocity: Array, chosen: Array) -> None:
    """The chosen cells hold the oracle's answers, or a reason why there is none."""
    for row, k in np.argwhere(chosen).tolist():
        cell, there = cells[row, k], replace(point, velocity=float(velocity[row]), heading=float(CIRCLE[k]))
        expected = answer(there, cell["unknowns"])
        assert (cell["status"] == CONVERGED) == (expected is not None), (Status(cell["status"]), expected, there)
        if expected is not None:
            wanted = np.array(expected) / [there.velocity, there.velocity, 1.0]
            np.testing.assert_allclose(cell["unknowns"], wanted, rtol=0, atol=SAME_ROOT, err_msg=str(there))


M113 = profiles("m113", "hard-soil", 12.13, 1 / 12.0)
UTV = profiles("utv-61cm", "asphalt", 12.13, 1 / 0.948)
TABLES = {
    "m113 on hard soil": (M113, np.linspace(1.0, 9.0, 9)),
    "utv-61cm on asphalt": (UTV, np.linspace(0.25, 3.0, 12)),
    "near the fold": (DOCUMENTED, np.array([2.0, 3.0, 3.5, 4.0, 4.15, 4.2, 4.5, 5.0])),
}


@functools.cache
def table(name: str) -> Cells:
    return solve(*TABLES[name])


# Columns that continuation or swarms once decided wrongly: where a row has few easy cells, or none at low speed.
HARD = {
    "slippery, braking and driving at the limit": (
        replace(
            DOCUMENTED, mass=539.5, gauge=0.8331, width=0.125, length=1.422, cog_height=0.09171, cog_forward=0,
            cog_left=0, friction=0.2515, shear_modulus=0.007382, cohesion=0, resistance=0.1136, slope=0.2367,
            curvature=0.4335,
        ),
        2.745,
    ),
    "inner track at rest on most headings": (
        replace(
            DOCUMENTED, mass=14680, gauge=2.549, width=0.3823, length=4.407, cog_height=1.609, cog_forward=0,
            cog_left=0.03818, friction=0.8413, shear_modulus=0.01655, cohesion=4000, resistance=0.04937,
            slope=0.05661, curvature=-0.2173,
        ),
        6.23,
    ),
    "too steep to stand on": (
        replace(
            DOCUMENTED, mass=2066, gauge=2.642, width=0.3962, length=3.032, cog_height=0.274, cog_forward=-0.1953,
            cog_left=-0.1611, friction=0.4871, shear_modulus=0.02957, cohesion=0, resistance=0.08758, slope=0.5532,
            curvature=0.251,
        ),
        6.089,
    ),
    "wide turn": (
        replace(
            DOCUMENTED, mass=3720, gauge=1.613, width=0.2419, length=2.339, cog_height=0.2647, cog_forward=0,
            cog_left=0, friction=0.5524, shear_modulus=0.01043, cohesion=0, resistance=0.02685, slope=0.3733,
            curvature=0.059,
        ),
        17.95,
    ),
    "too steep to stand on, to the right": (
        replace(
            DOCUMENTED, mass=10920, gauge=2.23, width=0.3345, length=2.048, cog_height=0.8746, cog_forward=0.05396,
            cog_left=-0.1695, friction=0.2754, shear_modulus=0.004251, cohesion=0, resistance=0.05013, slope=0.3346,
            curvature=-0.2012,
        ),
        3.757,
    ),
}  # fmt: skip


@pytest.mark.parametrize(
    ("velocity", "expected"), [(4.0, (3.219, 6.744, -0.146)), (4.15, (3.485, 7.202, -0.189)), (4.2, None)]
)
def test_documented_points_have_their_answers(velocity: float, expected: Triple | None) -> None:
    _, velocities = TABLES["near the fold"]
    cell = table("near the fold")[np.flatnonzero(velocities == velocity)[0], 2]
    if expected is None:
        assert cell["status"] == Status.INFEASIBLE_GRIP
        return
    left, right, sideslip = cell["unknowns"].tolist()
    assert cell["status"] == CONVERGED
    # Three decimals are given.
    assert (velocity * left, velocity * right, sideslip) == pytest.approx(expected, abs=5.1e-4)


@pytest.mark.parametrize("name", TABLES)
def test_sampled_cells_are_the_oracles(name: str) -> None:
    point, velocity = TABLES[name]
    cells = table(name)
    chosen = np.zeros(cells.shape, dtype=bool)
    chosen[::3, ::6] = True
    # And, where the table has an edge, some cells on either side of it.
    edge = np.argwhere(frontier(cells["status"]))[::5]
    chosen[edge[:, 0], edge[:, 1]] = True
    assert_cells_are_right(cells, point, velocity, chosen)


@pytest.mark.parametrize("name", TABLES)
def test_every_cell_is_decided(name: str) -> None:
    cells = table(name)
    assert set(np.unique(cells["status"])) <= set(Status) - {NOT_CONVERGED}
    solved = cells["status"] == CONVERGED
    assert solved.sum() > cells.size / 4
    assert np.isfinite(cells["residual"]).all()
    assert (cells["residual"][solved] <= 1e-10).all()


@pytest.mark.parametrize(("point", "top"), HARD.values(), ids=HARD.keys())
def test_hard_columns_are_decided_as_the_oracle_decides(point: OraclePoint, top: float) -> None:
    velocity = np.linspace(0.1, 1.0, 8) * top
    cells = solve(point, velocity)
    assert (cells["status"] != NOT_CONVERGED).all()
    chosen = frontier(cells["status"])
    chosen[:, ::2] = False
    assert_cells_are_right(cells, point, velocity, chosen)


@functools.cache
def random_columns() -> list[tuple[OraclePoint, Array, Cells]]:
    columns = []
    for point in random_points(40, 41):
        velocity = np.linspace(0.1, 1.2, 7) * point.velocity
        columns.append((point, velocity, solve(point, velocity)))
    return columns


def test_no_swarm_finds_what_a_column_misses() -> None:
    for point, velocity, cells in random_columns():
        others = solve_points_of(point, velocity)
        found = others["status"] == CONVERGED
        wrong = np.argwhere(found & (cells["status"] != CONVERGED))
        assert wrong.size == 0, (point, velocity, wrong)
        # Where a swarm has been taken in by a second root, it is one of larger sideslip.
        sideslip, other = (c["unknowns"][found][:, 2] for c in (cells, others))
        assert (np.abs(sideslip) <= np.abs(other) + SAME_ANSWER).all(), point


def test_random_columns_are_decided() -> None:
    for point, _, cells in random_columns():
        assert (cells["status"] != NOT_CONVERGED).all(), point


def test_answers_of_random_columns_balance_by_the_oracles_quadrature() -> None:
    residuals = []
    for point, velocity, cells in random_columns():
        for row, k in np.argwhere(cells["status"] == CONVERGED)[::7].tolist():
            there = replace(point, velocity=float(velocity[row]), heading=float(CIRCLE[k]))
            left, right, sideslip = cells[row, k]["unknowns"].tolist()
            speeds = left * there.velocity, right * there.velocity
            residuals.append(np.abs(balance(there, *speeds, sideslip)).max())
    assert len(residuals) > 300
    # 1e-7 is what the rules are chosen for. A kink that the split leaves, where a shoe comes back over its point of
    # entry, costs more in one cell of fifty.
    assert np.quantile(residuals, 0.9) < 1e-6
    assert max(residuals) < 5e-4


def test_answers_are_on_the_branch_of_positive_determinant() -> None:
    for point, velocity, cells in random_columns():
        for row, k in np.argwhere(cells["status"] == CONVERGED)[::9].tolist():
            there = replace(point, velocity=float(velocity[row]), heading=float(CIRCLE[k]))
            assert np.linalg.det(evaluate(there, cells[row, k]["unknowns"])[1]) > 0.0


@pytest.mark.parametrize("name", TABLES)
def test_swarms_in_every_cell_give_the_same_table(name: str) -> None:
    cells, others = table(name), solve_points_of(*TABLES[name])
    np.testing.assert_array_equal(others["status"], cells["status"])
    np.testing.assert_allclose(others["unknowns"], cells["unknowns"], rtol=0, atol=SAME_ANSWER)
    np.testing.assert_allclose(others["traction"], cells["traction"], rtol=0, atol=SAME_ANSWER)


@pytest.mark.parametrize("name", TABLES)
def test_part_of_the_circle_gives_the_same_cells(name: str) -> None:
    point, velocity = TABLES[name]
    for part in (slice(2, 9), slice(10, 11), slice(15, 24)):
        cells, whole = solve(point, velocity, CIRCLE[part]), table(name)[:, part]
        np.testing.assert_array_equal(cells["status"], whole["status"])
        np.testing.assert_allclose(cells["unknowns"], whole["unknowns"], rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", TABLES)
def test_other_velocities_in_the_column_change_nothing(name: str) -> None:
    point, velocity = TABLES[name]
    for part in (slice(0, None, 2), slice(1, None, 3), slice(-1, None), slice(3, 5)):
        cells, whole = solve(point, velocity[part]), table(name)[part]
        np.testing.assert_array_equal(cells["status"], whole["status"])
        np.testing.assert_allclose(cells["unknowns"], whole["unknowns"], rtol=0, atol=SAME_ANSWER)


@pytest.mark.parametrize("name", TABLES)
def test_seed_changes_nothing(name: str) -> None:
    point, velocity = TABLES[name]
    cells = solve(point, velocity, seed=12345)
    np.testing.assert_array_equal(cells["status"], table(name)["status"])
    np.testing.assert_allclose(cells["unknowns"], table(name)["unknowns"], rtol=0, atol=SAME_ANSWER)


@pytest.mark.parametrize("name", ["m113 on hard soil", "utv-61cm on asphalt"])
def test_right_turns_mirror_left_turns(name: str) -> None:
    point, velocity = TABLES[name]
    left, right = table(name), solve(replace(point, curvature=-point.curvature), velocity)
    # phi -> -phi on the grid of headings.
    mirrored = right[:, -np.arange(CIRCLE.size) % CIRCLE.size]
    np.testing.assert_array_equal(mirrored["status"], left["status"])
    unknowns = mirrored["unknowns"][..., [1, 0, 2]] * [1.0, 1.0, -1.0]
    np.testing.assert_allclose(unknowns, left["unknowns"], rtol=0, atol=SAME_ANSWER)


def test_velocity_does_not_matter_on_a_straight_line() -> None:
    cells = solve(replace(M113, curvature=0.0), np.array([0.5, 5.0, 17.0]))
    assert (cells["status"] == CONVERGED).all()
    np.testing.assert_array_equal(cells["unknowns"][1:], np.broadcast_to(cells["unknowns"][:1], (2, 24, 3)))
    # Symmetric about up-slope.
    np.testing.assert_allclose(
        cells["unknowns"][0, 1:][::-1], cells["unknowns"][0, 1:][:, [1, 0, 2]] * [1, 1, -1], rtol=0, atol=SAME_ANSWER
    )


def test_heading_does_not_matter_on_level_ground() -> None:
    cells = solve(replace(M113, slope=0.0), np.array([1.0, 5.0]))
    expected = np.broadcast_to(cells["unknowns"][:, :1], cells["unknowns"].shape)
    np.testing.assert_allclose(cells["unknowns"], expected, rtol=0, atol=SAME_ANSWER)


def test_answers_vary_smoothly_round_the_circle() -> None:
    heading = np.arange(360) * 2.0 * math.pi / 360
    row = solve(M113, np.array([4.0]), heading)["unknowns"][0]
    third = np.diff(np.vstack((row, row[:3])), n=3, axis=0)
    # A jump to another root would be a thousand times as large.
    assert np.abs(third).max() < 1e-4


TALL = replace(SMALL, cog_height=0.9, friction=1.2, curvature=0.2, slope=0.5)


def test_a_tall_vehicle_lifts_off_across_the_slope_and_pitches_over_along_it() -> None:
    status = solve(TALL, np.array([0.2, 1.0]))["status"]
    assert (status[:, [6, 18]] == Status.INFEASIBLE_LIFTOFF).all()
    assert (status[:, [0, 12]] == Status.INFEASIBLE_PITCHOVER).all()


def test_a_column_may_be_feasible_on_diagonals_only() -> None:
    # The weight rests on a square: it tips over its sides sooner than over its corners.
    square = replace(TALL, length=0.61, cog_height=0.7, slope=0.42, curvature=0.01)
    status = solve(square, np.array([0.5]))["status"][0]
    assert (status[[0, 6, 12, 18]] != CONVERGED).all()
    assert (status[[3, 9, 15, 21]] == CONVERGED).all()


def test_turn_about_the_inner_track_is_outside_the_model() -> None:
    status = solve(replace(SMALL, curvature=2.0 / SMALL.gauge, slope=0.0), np.array([0.1, 0.4]))["status"]
    assert (status == Status.OUTSIDE_MODEL).all()


def test_column_too_fast_for_its_grip_is_infeasible_throughout() -> None:
    cells = solve(UTV, np.array([5.0, 6.0]))
    assert (cells["status"] == Status.INFEASIBLE_GRIP).all()
    assert np.isnan(cells["unknowns"]).all()
    assert (cells["residual"] > 0.0).all()


def test_slope_too_steep_to_stand_on_can_be_turned_on() -> None:
    # Gravity across a slope of 40 degrees needs a friction of 0.84; a turn of the right speed takes it up.
    steep = replace(SMALL, slope=math.radians(40.0), friction=0.6, cog_height=0.05, curvature=0.2)
    balanced = math.sqrt(9.80665 * math.sin(steep.slope) / steep.curvature)
    status = solve(steep, np.array([0.2, 0.5, 1.0]) * balanced)["status"][:, 6]
    assert status.tolist() == [Status.INFEASIBLE_GRIP, status[1], CONVERGED]
