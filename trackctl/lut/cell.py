"""The balance of one operating point, solved from a start near its root."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.mechanics.equilibrium import balance
from trackctl.mechanics.limits import FASTEST_TRACK, LARGEST_SIDESLIP, SLOWEST_TRACK, outside_box
from trackctl.mechanics.operating_point import OperatingPoint
from trackctl.mechanics.parameters import TrackModel
from trackctl.mechanics.quadrature import Rule
from trackctl.solvers import levenberg_marquardt as lm
from trackctl.solvers.workspace import Workspace, workspace

Array = NDArray[np.float64]

#: Largest residual of an accepted cell, in units of m g and m g L.
TOLERANCE = 1e-10
#: Most evaluations from a warm start.
WARM_EVALUATIONS = 14


class Solver(NamedTuple):
    """What a thread needs to solve cells.

    Attributes
    ----------
    model
        Vehicle on its terrain.
    rule
        Quadrature.
    lower, upper
        Physical box of the unknowns, shape (3,).
    work
        Scratch memory; residual and Jacobian of the last solution.
    traction
        Track forces of the last evaluation, shape (2,). [-]
    """

    model: TrackModel
    rule: Rule
    lower: Array
    upper: Array
    work: Workspace
    traction: Array


@kernel
def solver(model: TrackModel, rule: Rule) -> Solver:
    """A thread's solver: track speeds from 0.01 to 6 times the vehicle's, sideslip up to 60 degrees."""
    lower = np.array([SLOWEST_TRACK, SLOWEST_TRACK, -LARGEST_SIDESLIP])
    upper = np.array([FASTEST_TRACK, FASTEST_TRACK, LARGEST_SIDESLIP])
    return Solver(model, rule, lower, upper, workspace(3), np.empty(2))


@kernel
def evaluate(solver: Solver, point: OperatingPoint, x: Array, residual: Array, jacobian: Array) -> None:
    """Balance at x."""
    balance(solver.model, point, solver.rule, x, residual, jacobian, solver.traction)


@kernel
def residual_at(solver: Solver, point: OperatingPoint, x: Array) -> float:
    """Largest residual at x; `solver.work` holds the balance there."""
    evaluate(solver, point, x, solver.work.residual, solver.work.jacobian)
    return lm.largest(solver.work.residual)


@kernel
def solve_from(
    solver: Solver, point: OperatingPoint, x: Array, tolerance: float, most_evaluations: int
) -> tuple[bool, int]:
    """Levenberg-Marquardt from x, which is improved in place.

    Returns
    -------
    tuple of bool and int
        Whether the tolerance was met, and the evaluations used; `solver.work` holds the balance at x.
    """
    work = solver.work
    evaluate(solver, point, x, work.residual, work.jacobian)
    evaluations = 1
    damping = 0.0
    while not lm.is_solved(work, tolerance):
        if evaluations >= most_evaluations or damping > lm.LARGEST_DAMPING:
            return False, evaluations
        if lm.propose(x, damping, solver.lower, solver.upper, work):
            evaluate(solver, point, work.trial, work.trial_residual, work.trial_jacobian)
            evaluations += 1
            damping = lm.judge(x, damping, work)
        else:
            damping = lm.more_damping(damping)
    return True, evaluations


@kernel
def branch_sign(jacobian: Array) -> float:
    """Determinant of the balance: positive on the branch that goes on from low speed, negative beyond its fold."""
    a = jacobian
    return (
        a[0, 0] * (a[1, 1] * a[2, 2] - a[1, 2] * a[2, 1])
        - a[0, 1] * (a[1, 0] * a[2, 2] - a[1, 2] * a[2, 0])
        + a[0, 2] * (a[1, 0] * a[2, 1] - a[1, 1] * a[2, 0])
    )


@kernel
def is_answer(solver: Solver, x: Array) -> bool:
    """Whether a root just found is on the branch that goes on from low speed, inside the physical box."""
    return branch_sign(solver.work.jacobian) > 0.0 and not outside_box(x)


@kernel
def solve_warm(solver: Solver, point: OperatingPoint, x: Array) -> bool:
    """Solve from a start near the root; True if the root found is the answer."""
    solved, _ = solve_from(solver, point, x, TOLERANCE, WARM_EVALUATIONS)
    return solved and is_answer(solver, x)
