"""Branches followed to their ends: the next answer, the fold, or the limit that ends them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from model_cases import DOCUMENTED, SMALL, Array, evaluate, model_of, row_of
from oracle import OraclePoint

from trackctl.lut.branch import REACHED, Way, follow
from trackctl.lut.cell import solver
from trackctl.lut.point import solve_points
from trackctl.mechanics.limits import GRIP, LIFTOFF, PITCHOVER


def root_of(point: OraclePoint) -> Array:
    unknowns: Array = solve_points(model_of(point), np.array([row_of(point)]))[0]["unknowns"]
    return unknowns.copy()


def followed(first: OraclePoint, **last: float) -> tuple[int, Array, OraclePoint]:
    """How the branch from a point to another velocity or heading ends, its last root, and where that is."""
    goal = replace(first, **last)
    memory, x = solver(model_of(first)), root_of(first)
    way = Way(first.slope, first.curvature, first.velocity, goal.velocity, first.heading, goal.heading)
    end = follow(memory[0], way, x)
    share = float(memory[0]["curve"]["point"][3])
    ended = replace(
        first,
        velocity=first.velocity + share * (goal.velocity - first.velocity),
        heading=first.heading + share * (goal.heading - first.heading),
    )
    return end, x, ended


@pytest.mark.parametrize(
    "last", [{"velocity": 4.0}, {"velocity": 0.5}, {"heading": 5.0}, {"heading": -1.0, "velocity": 3.0}]
)
def test_a_branch_leads_to_the_answer_at_its_end(last: dict[str, float]) -> None:
    first = replace(DOCUMENTED, velocity=2.0)
    end, x, ended = followed(first, **last)
    assert end == REACHED
    # The last step may end beside the goal by the curve's bend; x is on the branch there.
    assert np.abs(evaluate(ended, x)[0]).max() < 1e-8
    np.testing.assert_allclose(x, root_of(replace(first, **last)), rtol=0, atol=1e-2)


def test_a_branch_ends_at_its_fold() -> None:
    end, x, ended = followed(replace(DOCUMENTED, velocity=3.0), velocity=4.5)
    assert end == GRIP
    # Two roots at 4.15 m/s, none at 4.2 m/s.
    assert 4.15 < ended.velocity < 4.2
    assert np.abs(evaluate(ended, x)[0]).max() < 1e-8


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
    end, x, ended = followed(first, **last)
    assert end in limits
    assert abs(ended.heading - last["heading"]) > 0.1
    assert np.isfinite(x).all()
