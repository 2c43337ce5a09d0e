"""Branches followed to their ends: the next answer, the fold, or the limit that ends them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from model_cases import DOCUMENTED, SMALL, Array, evaluate, model_of, row_of
from oracle import OraclePoint

from trackctl.lut.branch import REACHED, Way, follow, settle
from trackctl.lut.point import solve_points
from trackctl.lut.solver import solver
from trackctl.mechanics.limits import GRIP, LIFTOFF, PITCHOVER
from trackctl.mechanics.operating_point import OperatingPoint, operating_point


def root_of(point: OraclePoint) -> Array:
    unknowns: Array = solve_points(model_of(point), np.array([row_of(point)]))[0]["unknowns"]
    return unknowns.copy()


def operating(point: OraclePoint) -> OperatingPoint:
    return operating_point(model_of(point), *row_of(point))


def followed(first: OraclePoint, **last: float) -> tuple[int, Array, float]:
    """How the branch from a point to another ends, its last root, and the share of the way there."""
    goal = replace(first, **last)
    memory, x = solver(model_of(first)), root_of(first)
    end = follow(memory[0], Way(operating(first), operating(goal)), x)
    return end, x, float(memory[0]["curve"]["point"][3])


def settled(point: OraclePoint) -> tuple[int, Array, float]:
    """The same for the branch from level ground."""
    memory, x = solver(model_of(point)), np.empty(3)
    end = settle(memory[0], operating(point), x)
    return end, x, float(memory[0]["curve"]["point"][3])


@pytest.mark.parametrize(
    "last", [{"velocity": 4.0}, {"velocity": 0.5}, {"heading": 5.0}, {"heading": -1.0, "velocity": 3.0}]
)
def test_a_branch_leads_to_the_answer_at_its_end(last: dict[str, float]) -> None:
    first = replace(DOCUMENTED, velocity=2.0)
    end, x, share = followed(first, **last)
    assert end == REACHED
    assert share == 1.0
    np.testing.assert_allclose(x, root_of(replace(first, **last)), rtol=0, atol=1e-9)


def test_a_branch_ends_at_its_fold() -> None:
    end, x, share = followed(replace(DOCUMENTED, velocity=3.0), velocity=4.5)
    assert end == GRIP
    # Two roots at 4.15 m/s, none at 4.2 m/s; the centripetal acceleration grows linearly on the way. The last point
    # lies beyond the fold, on the second branch, by a step at most.
    velocity = math.sqrt(3.0**2 + share * (4.5**2 - 3.0**2))
    assert 4.0 < velocity < 4.2
    residual, jacobian, _ = evaluate(replace(DOCUMENTED, velocity=velocity), x)
    assert np.abs(residual).max() < 2e-5
    assert np.linalg.det(jacobian) <= 0.0


def test_the_fold_is_where_answers_end() -> None:
    feasible, infeasible = 4.15, 4.2
    while infeasible - feasible > 1e-5:
        middle = 0.5 * (feasible + infeasible)
        found = np.isfinite(root_of(replace(DOCUMENTED, velocity=middle))).all()
        feasible, infeasible = (middle, infeasible) if found else (feasible, middle)
    first = replace(DOCUMENTED, velocity=4.0)
    assert followed(first, velocity=feasible)[0] == REACHED
    assert followed(first, velocity=infeasible + 1e-5)[0] == GRIP
    # There the matrix of the balance is singular.
    singular = evaluate(replace(DOCUMENTED, velocity=feasible), root_of(replace(DOCUMENTED, velocity=feasible)))[1]
    regular = evaluate(first, root_of(first))[1]
    assert abs(np.linalg.det(singular)) < 0.02 * abs(np.linalg.det(regular))


@pytest.mark.parametrize("curvature", [0.0, 0.02, 0.25, -0.4])
@pytest.mark.parametrize("heading_deg", [0, 60, 150, 270])
def test_the_branch_from_level_ground_leads_to_the_answer(curvature: float, heading_deg: float) -> None:
    point = replace(DOCUMENTED, velocity=1.0, curvature=curvature, heading=math.radians(heading_deg))
    end, x, _ = settled(point)
    assert end == REACHED
    assert np.abs(evaluate(point, x)[0]).max() < 1e-10
    np.testing.assert_allclose(x, root_of(point), rtol=0, atol=1e-8)


def test_the_branch_from_level_ground_ends_at_the_same_fold() -> None:
    assert settled(replace(DOCUMENTED, velocity=4.15))[0] == REACHED
    end, _, share = settled(replace(DOCUMENTED, velocity=4.2))
    assert end == GRIP
    assert 0.9 < share < 1.0


def test_no_branch_begins_where_the_ground_resists_more_than_it_carries() -> None:
    assert settled(replace(SMALL, friction=0.1, resistance=0.2))[0] == GRIP


TALL = replace(SMALL, cog_height=0.9, friction=1.5, curvature=0.05, slope=0.45, velocity=0.3)


@pytest.mark.parametrize(
    ("first", "last", "limits"),
    [
        (replace(TALL, cog_height=0.7, heading=math.radians(40)), {"heading": math.pi / 2}, {GRIP, LIFTOFF}),
        (replace(TALL, gauge=1.4, heading=math.radians(50)), {"heading": 0.0}, {GRIP, PITCHOVER}),
    ],
    ids=["towards lift-off", "towards pitch-over"],
)
def test_a_branch_ends_before_the_vehicle_tips_over(
    first: OraclePoint, last: dict[str, float], limits: set[int]
) -> None:
    # The track that is all but unloaded may fail to hold its share first.
    end, x, share = followed(first, **last)
    assert end in limits
    assert 0.0 < share < 1.0
    assert np.isfinite(x).all()
