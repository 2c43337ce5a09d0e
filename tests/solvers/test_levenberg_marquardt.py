"""Levenberg-Marquardt on systems with known roots: it gets there, quadratically, and never leaves the box."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from trackctl.solvers import levenberg_marquardt as lm
from trackctl.solvers.workspace import Workspace, workspace

Array = NDArray[np.float64]
Function = Callable[[Array], Array]

LARGE = 1e12


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """A square system, where to start and where it has its root."""

    function: Function
    jacobian: Function
    start: tuple[float, ...]
    root: tuple[float, ...]
    box: tuple[float, float] = (-LARGE, LARGE)
    accuracy: float = 1e-10

    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper ends of the box."""
        low, high = self.box
        return np.full(len(self.start), low), np.full(len(self.start), high)


def quadratic_roots_apart(x: Array) -> Array:
    return np.array([x[0] ** 2 + x[1] ** 2 - 4.0, x[0] - x[1]])


LINEAR = Problem(
    lambda x: np.array([2 * x[0] + x[1] - 4, x[0] - 3 * x[1] + 5]),
    lambda x: np.array([[2.0, 1.0], [1.0, -3.0]]),
    (100.0, -100.0),
    (1.0, 2.0),
)
ROSENBROCK = Problem(
    lambda x: np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]]),
    lambda x: np.array([[-20 * x[0], 10.0], [-1.0, 0.0]]),
    (-1.2, 1.0),
    (1.0, 1.0),
)
# Singular at its root, where Newton's method only halves the error.
POWELL_SINGULAR = Problem(
    lambda x: np.array(
        [x[0] + 10 * x[1], math.sqrt(5) * (x[2] - x[3]), (x[1] - 2 * x[2]) ** 2, math.sqrt(10) * (x[0] - x[3]) ** 2]
    ),
    lambda x: np.array(
        [
            [1.0, 10.0, 0.0, 0.0],
            [0.0, 0.0, math.sqrt(5), -math.sqrt(5)],
            [0.0, 2 * (x[1] - 2 * x[2]), -4 * (x[1] - 2 * x[2]), 0.0],
            [2 * math.sqrt(10) * (x[0] - x[3]), 0.0, 0.0, -2 * math.sqrt(10) * (x[0] - x[3])],
        ]
    ),
    (3.0, -1.0, 0.0, 1.0),
    (0.0, 0.0, 0.0, 0.0),
    accuracy=1e-5,  # The residual is the error's square.
)
BROWN_BADLY_SCALED = Problem(
    lambda x: np.array([x[0] - 1e6, x[1] - 2e-6 + x[0] * x[1] - 2.0]),
    lambda x: np.array([[1.0, 0.0], [x[1], 1.0 + x[0]]]),
    (1.0, 1.0),
    (1e6, (2.0 + 2e-6) / (1.0 + 1e6)),
)
CIRCLE_AND_LINE = Problem(
    quadratic_roots_apart,
    lambda x: np.array([[2 * x[0], 2 * x[1]], [1.0, -1.0]]),
    (3.0, 0.5),
    (math.sqrt(2), math.sqrt(2)),
)
EXPONENTIALS = Problem(
    lambda x: np.array([math.exp(x[0]) - math.exp(x[1] + 1), math.sin(x[0]) + x[1] ** 2 - math.sin(2) - 1]),
    lambda x: np.array([[math.exp(x[0]), -math.exp(x[1] + 1)], [math.cos(x[0]), 2 * x[1]]]),
    (2.5, 0.6),
    (2.0, 1.0),
)
# Newton's first step from the start leaves the box far behind.
ARCTANGENT = Problem(
    lambda x: np.array([math.atan(x[0] - 1.0)]),
    lambda x: np.array([[1.0 / (1.0 + (x[0] - 1.0) ** 2)]]),
    (4.0,),
    (1.0,),
    box=(-5.0, 5.0),
)
BOXED_ROSENBROCK = Problem(ROSENBROCK.function, ROSENBROCK.jacobian, (-1.2, 1.0), (1.0, 1.0), box=(-1.5, 1.5))
PROBLEMS = {
    "linear": LINEAR,
    "Rosenbrock": ROSENBROCK,
    "Powell, singular": POWELL_SINGULAR,
    "Brown, badly scaled": BROWN_BADLY_SCALED,
    "circle and line": CIRCLE_AND_LINE,
    "exponentials": EXPONENTIALS,
    "arctangent in a box": ARCTANGENT,
    "Rosenbrock in a box": BOXED_ROSENBROCK,
}


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """Where a solve ended, the points it accepted and those it tried."""

    x: Array
    solved: bool
    residual: Array
    accepted: list[Array]
    tried: list[Array]


def work_for(n: int) -> Workspace:
    return np.zeros(1, workspace(n))[0]


def evaluate(problem: Problem, x: Array, work: Workspace, prefix: str = "") -> None:
    work[f"{prefix}residual"][:] = problem.function(x)
    work[f"{prefix}jacobian"][:] = problem.jacobian(x)


def solve(problem: Problem, tolerance: float = 1e-12, most: int = 300) -> Solution:
    """The loop of the module's description."""
    x = np.array(problem.start)
    work, (lower, upper) = work_for(x.size), problem.bounds()
    accepted, tried = [x.copy()], [x.copy()]
    evaluate(problem, x, work)
    damping = 0.0
    while not lm.is_solved(work, tolerance) and damping < lm.LARGEST_DAMPING and len(tried) < most:
        if lm.propose(x, damping, lower, upper, work):
            tried.append(work["trial"].copy())
            evaluate(problem, work["trial"], work, "trial_")
            damping = lm.judge(x, damping, work)
            if np.array_equal(x, tried[-1]):
                accepted.append(x.copy())
        else:
            damping = lm.more_damping(damping)
    return Solution(x, lm.is_solved(work, tolerance), work["residual"].copy(), accepted, tried)


@pytest.mark.parametrize("problem", PROBLEMS.values(), ids=PROBLEMS.keys())
def test_known_roots_are_found(problem: Problem) -> None:
    found = solve(problem)
    assert found.solved
    np.testing.assert_allclose(found.x, problem.root, rtol=problem.accuracy, atol=problem.accuracy)


@pytest.mark.parametrize("problem", PROBLEMS.values(), ids=PROBLEMS.keys())
def test_every_trial_lies_in_the_box(problem: Problem) -> None:
    lower, upper = problem.bounds()
    for x in solve(problem).tried:
        assert ((lower <= x) & (x <= upper)).all()


@pytest.mark.parametrize("problem", PROBLEMS.values(), ids=PROBLEMS.keys())
def test_accepted_points_only_ever_improve(problem: Problem) -> None:
    costs = [float(np.sum(problem.function(x) ** 2)) for x in solve(problem).accepted]
    assert all(later < earlier for earlier, later in pairwise(costs))


@pytest.mark.parametrize("problem", PROBLEMS.values(), ids=PROBLEMS.keys())
def test_memory_holds_the_balance_of_the_returned_point(problem: Problem) -> None:
    found = solve(problem)
    np.testing.assert_array_equal(found.residual, problem.function(found.x))


def test_linear_system_takes_one_step() -> None:
    assert len(solve(LINEAR).tried) == 2


@pytest.mark.parametrize("problem", [CIRCLE_AND_LINE, EXPONENTIALS], ids=["circle and line", "exponentials"])
def test_convergence_is_quadratic_near_a_regular_root(problem: Problem) -> None:
    errors = np.array([np.abs(x - problem.root).max() for x in solve(problem, 1e-15).accepted])
    errors = errors[(errors < 0.3) & (errors > 1e-13)]
    assert len(errors) >= 4
    order = np.polyfit(np.log(errors[:-1]), np.log(errors[1:]), 1)[0]
    assert order == pytest.approx(2.0, abs=0.2)


def test_convergence_is_linear_at_a_singular_root() -> None:
    errors = np.array([np.abs(x).max() for x in solve(POWELL_SINGULAR).accepted])
    ratios = errors[5:] / errors[4:-1]
    # Newton's method at a double root.
    np.testing.assert_allclose(ratios, 0.5, atol=0.01)


def test_damping_turns_the_step_from_newtons_to_steepest_descent() -> None:
    work = work_for(2)
    x = np.array([1.0, 0.5])
    evaluate(EXPONENTIALS, x, work)
    jacobian, residual = work["jacobian"].copy(), work["residual"].copy()
    lm.descent(work, 0.0)
    np.testing.assert_allclose(work["step"], np.linalg.solve(jacobian, residual), rtol=1e-13)
    normal, gradient = jacobian.T @ jacobian, jacobian.T @ residual
    for damping in (1e-4, 1.0, 1e8):
        lm.descent(work, damping)
        damped = normal + damping * np.diag(np.diag(normal))
        np.testing.assert_allclose(work["step"], np.linalg.solve(damped, gradient), rtol=1e-12)
    np.testing.assert_allclose(1e8 * work["step"], gradient / np.diag(normal), rtol=1e-6)


def test_failed_step_is_not_taken_and_shortens_the_next() -> None:
    work, x = work_for(1), np.array([4.0])
    evaluate(ARCTANGENT, x, work)
    work["trial"][:] = -100.0
    evaluate(ARCTANGENT, work["trial"], work, "trial_")
    damping = lm.judge(x, 0.0, work)
    assert x[0] == 4.0
    assert 0.0 < damping < lm.judge(x, damping, work)


def test_success_returns_to_newtons_step() -> None:
    work, x = work_for(1), np.array([4.0])
    evaluate(ARCTANGENT, x, work)
    work["trial"][:] = 2.0
    evaluate(ARCTANGENT, work["trial"], work, "trial_")
    damping = lm.judge(x, 1.0, work)
    assert x[0] == 2.0
    assert 0.0 < damping < 1.0
    for _ in range(20):
        damping = lm.judge(np.array([4.0]), damping, work_that_improves())
    assert damping == 0.0


def work_that_improves() -> Workspace:
    work = work_for(1)
    work["residual"][:], work["trial_residual"][:] = 2.0, 1.0
    return work


def test_without_a_root_it_stops_at_the_least_residual() -> None:
    found = solve(Problem(lambda x: x**2 + 1.0, lambda x: 2.0 * np.diag(x), (1.0,), (0.0,)))
    assert not found.solved
    assert abs(found.x[0]) < 1e-3
    assert found.residual[0] == pytest.approx(1.0, abs=1e-6)


def test_root_outside_the_box_is_not_found() -> None:
    found = solve(Problem(LINEAR.function, LINEAR.jacobian, (0.0, 0.0), (1.0, 2.0), box=(-1.0, 1.5)))
    assert not found.solved
    assert (np.abs(found.x) <= 1.5).all()


def test_singular_system_asks_for_damping() -> None:
    work = work_for(2)
    work["residual"][:] = 1.0
    assert not lm.propose(np.zeros(2), 0.0, np.full(2, -1.0), np.full(2, 1.0), work)
    assert lm.more_damping(0.0) == lm.FIRST_DAMPING


@pytest.mark.parametrize("position", [0, 1, 2])
def test_nan_in_a_residual_is_no_solution(position: int) -> None:
    values = np.zeros(3)
    values[position] = np.nan
    assert math.isnan(lm.largest(values))
    work = work_for(3)
    work["residual"][:] = values
    assert not lm.is_solved(work, 1e-6)


def test_nan_at_a_trial_point_is_a_failed_step() -> None:
    work, x = work_for(1), np.array([4.0])
    evaluate(ARCTANGENT, x, work)
    work["trial"][:], work["trial_residual"][:] = 2.0, np.nan
    assert lm.judge(x, 0.0, work) > 0.0
    assert x[0] == 4.0
