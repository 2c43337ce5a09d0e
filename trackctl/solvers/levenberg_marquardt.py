"""Levenberg-Marquardt for square systems in a box: undamped where that works, damped where it does not.

The parts of the method, for a loop that evaluates the function itself (reverse communication, so that a compiled loop
can be cached and the method knows nothing of the problem)::

    evaluate(x, work.residual, work.jacobian)
    damping = 0.0
    while not is_solved(work, tolerance) and damping < LARGEST_DAMPING:
        if propose(x, damping, lower, upper, work):
            evaluate(work.trial, work.trial_residual, work.trial_jacobian)
            damping = judge(x, damping, work)
        else:
            damping = more_damping(damping)
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.solvers.elimination import eliminate
from trackctl.solvers.workspace import Workspace

Array = NDArray[np.float64]

FIRST_DAMPING = 1e-4
DAMPING_FACTOR = 8.0
LARGEST_DAMPING = 1e8


class Settings(NamedTuple):
    """When to stop.

    Attributes
    ----------
    tolerance
        Largest absolute residual of a solution. [-]
    evaluations
        Most evaluations of the function. [-]
    """

    tolerance: float
    evaluations: int


@kernel
def largest(values: Array) -> float:
    """Largest absolute value; NaN if any is."""
    result = 0.0
    for value in values:
        if abs(value) > result or math.isnan(value):
            result = abs(value)
    return result


@kernel
def is_solved(work: Workspace, tolerance: float) -> bool:
    """Whether every residual is within the tolerance."""
    return largest(work.residual) <= tolerance


@kernel
def sum_of_squares(values: Array) -> float:
    """Sum of squares."""
    total = 0.0
    for value in values:
        total += value * value
    return total


@kernel
def descent(work: Workspace, damping: float) -> float:
    """Step of the damped system (J^T J + damping diag(J^T J)) d = J^T r into `work.step`; its determinant.

    Without damping it is Newton's, J d = r, whose condition is the square root of that.
    """
    n = work.step.size
    if damping == 0.0:
        for i in range(n):
            work.step[i] = work.residual[i]
            for j in range(n):
                work.matrix[i, j] = work.jacobian[i, j]
        return eliminate(work.matrix, work.step)
    for i in range(n):
        projected = 0.0
        for k in range(n):
            projected += work.jacobian[k, i] * work.residual[k]
        work.step[i] = projected
        for j in range(n):
            normal = 0.0
            for k in range(n):
                normal += work.jacobian[k, i] * work.jacobian[k, j]
            work.matrix[i, j] = normal
    for i in range(n):
        work.matrix[i, i] *= 1.0 + damping
    return eliminate(work.matrix, work.step)


@kernel
def propose(x: Array, damping: float, lower: Array, upper: Array, work: Workspace) -> bool:
    """Next trial point, kept in the box, into `work.trial`; False where the damped system is singular."""
    if descent(work, damping) == 0.0:
        return False
    for i in range(x.size):
        work.trial[i] = min(max(x[i] - work.step[i], lower[i]), upper[i])
    return True


@kernel
def judge(x: Array, damping: float, work: Workspace) -> float:
    """Take the trial point if it lowers the sum of squares; the damping of the next step.

    A success lowers the damping towards Newton's step, a failure shortens the next step.
    """
    if sum_of_squares(work.trial_residual) < sum_of_squares(work.residual):
        for i in range(x.size):
            x[i] = work.trial[i]
            work.residual[i] = work.trial_residual[i]
            for j in range(x.size):
                work.jacobian[i, j] = work.trial_jacobian[i, j]
        return damping / DAMPING_FACTOR if damping > FIRST_DAMPING else 0.0
    return more_damping(damping)


@inlined
def more_damping(damping: float) -> float:
    """Damping after a failed step."""
    return max(DAMPING_FACTOR * damping, FIRST_DAMPING)
