"""Single operating points against the oracle: the right root where there is one, else the right reason."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from model_cases import DOCUMENTED, SMALL, Array, evaluate, model_of, random_points, row_of
from oracle import OraclePoint, Triple, default_starts, det_sign, roots

from trackctl.lut.cell import near_no_slip, solve_cold
from trackctl.lut.point import solve_points
from trackctl.lut.solver import solver
from trackctl.lut.swarm_search import SURELY_SMALLEST
from trackctl.lut.table import Status
from trackctl.mechanics.limits import ADMISSIBLE, proven_infeasible
from trackctl.mechanics.operating_point import operating_point
from trackctl.mechanics.parameters import TrackModel

CONVERGED, NOT_CONVERGED = Status.CONVERGED, Status.NOT_CONVERGED
# The package's quadrature moves a root by 1e-3 at most, and distinct roots lie much further apart.
SAME_ROOT = 2e-3


def solve(point: OraclePoint, *, swarm_always: bool = False, seed: int = 0) -> Any:
    """The cell of one point, a record."""
    return solve_points(model_of(point), np.array([row_of(point)]), seed=seed, swarm_always=swarm_always)[0]


def track_speeds(cell: Any, point: OraclePoint) -> Triple:
    left, right, sideslip = cell["unknowns"].tolist()
    return left * point.velocity, right * point.velocity, sideslip


def answer(point: OraclePoint, found: Array | None = None) -> Triple | None:
    """The root that the model's description asks for: of smallest sideslip among those of positive determinant.

    The oracle also starts at what the package has found: 64 starts of its own miss a root in one point of 200.
    """
    starts = default_starts(point, 64)
    if found is not None and np.isfinite(found).all():
        starts = np.vstack((starts, found))
    return next((root for root in roots(point, starts) if det_sign(point, root) > 0), None)


def assert_is_right(cell: Any, point: OraclePoint) -> None:
    """The cell holds the oracle's answer, or a reason why there is none."""
    expected = answer(point, cell["unknowns"])
    assert cell["status"] != NOT_CONVERGED, point
    assert (cell["status"] == CONVERGED) == (expected is not None), (Status(cell["status"]), expected, point)
    if expected is not None:
        found = np.array(track_speeds(cell, point)) / [point.velocity, point.velocity, 1.0]
        wanted = np.array(expected) / [point.velocity, point.velocity, 1.0]
        np.testing.assert_allclose(found, wanted, rtol=0, atol=SAME_ROOT, err_msg=str(point))


@pytest.mark.parametrize("swarm_always", [False, True], ids=["no-slip start", "swarm"])
@pytest.mark.parametrize(
    ("velocity", "expected"), [(4.0, (3.219, 6.744, -0.146)), (4.15, (3.485, 7.202, -0.189)), (4.2, None)]
)
def test_documented_points_have_their_answers(velocity: float, expected: Triple | None, swarm_always: bool) -> None:
    point = replace(DOCUMENTED, velocity=velocity)
    cell = solve(point, swarm_always=swarm_always)
    if expected is None:
        assert cell["status"] == Status.INFEASIBLE_GRIP
        return
    assert cell["status"] == CONVERGED
    assert track_speeds(cell, point) == pytest.approx(expected, abs=5.1e-4)  # Three decimals are given.


@pytest.mark.parametrize(("velocity", "sideslip"), [(4.0, -0.146), (4.15, -0.189)])
def test_no_swarm_lands_on_the_second_root(velocity: float, sideslip: float) -> None:
    point = replace(DOCUMENTED, velocity=velocity)
    for seed in range(30):
        found = solve(point, swarm_always=True, seed=seed)["unknowns"][2]
        assert found == pytest.approx(sideslip, abs=5.1e-4)  # Three decimals are given.


# Found by comparing thousands of random points with the oracle.
HARD = {
    "straight line, where no slip is a singular start": replace(
        DOCUMENTED, mass=9731, gauge=2.55, width=0.3826, length=4.097, cog_height=1.332, cog_forward=0, cog_left=0,
        friction=0.5568, shear_modulus=0.006261, cohesion=4000, resistance=0.07876, slope=0.5106, velocity=1.0,
        curvature=0.0, heading=1.094,
    ),
    "wide turn on a side slope": replace(
        DOCUMENTED, mass=15480, gauge=2.58, width=0.387, length=3.335, cog_height=1.413, cog_forward=0, cog_left=0,
        friction=0.3396, shear_modulus=0.01074, cohesion=4000, resistance=0.1129, slope=0.2361, velocity=2.554,
        curvature=-0.01234, heading=5.428,
    ),
    "too steep to stand on, held by its turn": replace(
        DOCUMENTED, mass=61.35, gauge=0.5317, width=0.07975, length=0.6461, cog_height=0.2598, cog_forward=0,
        cog_left=-0.04873, friction=0.5968, shear_modulus=0.008816, cohesion=0, resistance=0.07564, slope=0.548,
        velocity=5.114, curvature=-0.05324, heading=5.053,
    ),
    "tall and off centre": replace(
        DOCUMENTED, mass=1447, gauge=1.131, width=0.1697, length=1.213, cog_height=0.774, cog_forward=0.08573,
        cog_left=0.106, friction=0.5624, shear_modulus=0.02829, cohesion=0, resistance=0.09096, slope=0.4871,
        velocity=2.359, curvature=0.1966, heading=1.265,
    ),
    "three roots, two of positive determinant": replace(
        DOCUMENTED, mass=510.8, gauge=0.9115, width=0.1367, length=0.8822, cog_height=0.3152, cog_forward=0,
        cog_left=0.05079, friction=0.4584, shear_modulus=0.02764, cohesion=0, resistance=0.08697, slope=0.1822,
        velocity=2.448, curvature=-0.3167, heading=math.pi / 4,
    ),
    "three roots at high speed": replace(
        DOCUMENTED, mass=4932, gauge=2.349, width=0.3523, length=1.861, cog_height=0.514, cog_forward=-0.06295,
        cog_left=-0.1939, friction=0.5278, shear_modulus=0.01182, cohesion=0, resistance=0.1132, slope=0.1921,
        velocity=13.01, curvature=0.01617, heading=math.radians(285),
    ),
    "no root, and none without the turn's speed": replace(
        DOCUMENTED, mass=4992, gauge=2.736, width=0.4105, length=3.772, cog_height=1.907, cog_forward=0.1139,
        cog_left=0, friction=0.2968, shear_modulus=0.008104, cohesion=1000, resistance=0.09419, slope=0.1787,
        velocity=0.6863, curvature=0.03416, heading=0.1033,
    ),
    "a hair beyond the fold": replace(
        DOCUMENTED, mass=10180, gauge=2.283, width=0.3424, length=3.883, cog_height=1.323, cog_forward=0, cog_left=0,
        friction=0.2617, shear_modulus=0.01672, cohesion=4000, resistance=0.1471, slope=0.1762, velocity=3.692,
        curvature=0.05471, heading=6.049,
    ),
}  # fmt: skip


@pytest.mark.parametrize("swarm_always", [False, True], ids=["no-slip start", "swarm"])
@pytest.mark.parametrize("point", HARD.values(), ids=HARD.keys())
def test_hard_points_are_decided_rightly(point: OraclePoint, swarm_always: bool) -> None:
    assert_is_right(solve(point, swarm_always=swarm_always), point)


@pytest.mark.parametrize("swarm_always", [False, True], ids=["no-slip start", "swarm"])
def test_random_points_are_decided_as_the_oracle_decides(swarm_always: bool) -> None:
    for point in random_points(50, 31):
        assert_is_right(solve(point, swarm_always=swarm_always), point)


def test_swarm_and_no_slip_start_agree_on_many_random_points() -> None:
    for point in random_points(400, 32):
        cell, other = solve(point), solve(point, swarm_always=True)
        assert cell["status"] == other["status"], point
        # Both solve the same equations to a residual of 1e-10; next to a fold that leaves more than rounding.
        np.testing.assert_allclose(cell["unknowns"], other["unknowns"], rtol=0, atol=1e-7)


def test_an_answer_balances_and_a_refusal_holds_no_numbers() -> None:
    for point in random_points(200, 33):
        cell = solve(point)
        if cell["status"] == CONVERGED:
            residual, _, traction = evaluate(point, cell["unknowns"])
            assert cell["residual"] <= 1e-10
            assert np.abs(residual).max() == pytest.approx(cell["residual"], abs=1e-12)
            np.testing.assert_allclose(cell["traction"], traction, rtol=0, atol=1e-12)
        else:
            assert np.isnan(cell["unknowns"]).all()
            assert np.isnan(cell["traction"]).all()
            assert cell["residual"] > 0.0


TALL = replace(SMALL, cog_height=0.9, friction=2.0, curvature=0.2)
REFUSALS = {
    "grip": (replace(SMALL, velocity=4.0), Status.INFEASIBLE_GRIP),
    "grip, straight": (replace(SMALL, friction=0.2, curvature=0.0, heading=0.0), Status.INFEASIBLE_GRIP),
    "lift-off across the slope": (replace(TALL, slope=0.5, heading=math.pi / 2), Status.INFEASIBLE_LIFTOFF),
    "lift-off by speed": (replace(TALL, velocity=7.1, slope=0.0), Status.INFEASIBLE_LIFTOFF),
    "pitch-over uphill": (replace(TALL, slope=0.5, heading=0.0), Status.INFEASIBLE_PITCHOVER),
    "pitch-over downhill": (replace(TALL, slope=0.5, heading=math.pi), Status.INFEASIBLE_PITCHOVER),
    "inner track nearly at rest": (replace(SMALL, curvature=2.2, slope=0.0), Status.OUTSIDE_MODEL),
    "turn about the inner track": (replace(SMALL, curvature=2.0 / SMALL.gauge, slope=0.0), Status.OUTSIDE_MODEL),
}


@pytest.mark.parametrize("swarm_always", [False, True], ids=["no-slip start", "swarm"])
@pytest.mark.parametrize(("point", "status"), REFUSALS.values(), ids=REFUSALS.keys())
def test_each_reason_for_no_answer(point: OraclePoint, status: Status, swarm_always: bool) -> None:
    assert Status(solve(point, swarm_always=swarm_always)["status"]) == status
    assert answer(point) is None


@pytest.mark.parametrize("velocity", [0.01, 1.0, 10.0])
def test_velocity_does_not_matter_on_a_straight_line(velocity: float) -> None:
    straight = replace(DOCUMENTED, curvature=0.0)
    expected = solve(straight)["unknowns"]
    np.testing.assert_allclose(solve(replace(straight, velocity=velocity))["unknowns"], expected, rtol=0, atol=1e-9)


def model_and_rows(number: int) -> tuple[TrackModel, Array]:
    rows = [row_of(replace(DOCUMENTED, heading=0.1 * k, velocity=1.0 + 0.02 * k)) for k in range(number)]
    return model_of(DOCUMENTED), np.array(rows)


def test_threads_change_nothing() -> None:
    model, rows = model_and_rows(200)
    together, threaded = solve_points(model, rows), solve_points(model, rows, jobs=3)
    assert together.tobytes() == threaded.tobytes()


def test_answers_do_not_depend_on_other_points() -> None:
    model, rows = model_and_rows(130)
    together, backwards = solve_points(model, rows), solve_points(model, rows[::-1])[::-1]
    np.testing.assert_array_equal(together["status"], backwards["status"])
    np.testing.assert_allclose(together["unknowns"], backwards["unknowns"], rtol=0, atol=1e-9)


def test_no_points_are_no_cells() -> None:
    assert solve_points(model_of(DOCUMENTED), np.empty((0, 4))).shape == (0,)


def test_a_root_in_hand_is_not_lost_to_a_swarm_that_finds_none() -> None:
    """A root of large sideslip calls for a swarm, which may know a smaller one; it need not find any."""
    for point in random_points(4000, 991):
        if solves_from_no_slip(point):
            cell = solve_points(model_of(point), np.array([row_of(point)]))[0]
            assert cell["status"] not in (Status.INFEASIBLE_GRIP, Status.NOT_CONVERGED), point


def solves_from_no_slip(point: OraclePoint) -> bool:
    """Whether Levenberg-Marquardt alone finds an answer of large sideslip, without any swarm."""
    model, row, x = model_of(point), row_of(point), np.empty(3)
    operating = operating_point(model, *row)
    near_no_slip(model, row[2], x)
    if proven_infeasible(model, operating) != ADMISSIBLE:
        return False
    return solve_cold(solver(model)[0], operating, x) and abs(x[2]) >= SURELY_SMALLEST
