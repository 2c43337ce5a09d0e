"""Levenberg-Marquardt for square systems in a box: undamped where that works, damped where it does not.

A function to be solved is a kernel `evaluate(problem, x, residual, jacobian)` that fills both arrays; `problem` is any
value that it understands.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
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
        if not abs(value) <= result:
            result = abs(value)
    return result


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
        work.matrix[:] = work.jacobian
        work.step[:] = work.residual
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
def levenberg_marquardt(
    evaluate: Any, problem: Any, lower: Array, upper: Array, x: Array, settings: Settings, work: Workspace
) -> tuple[bool, int]:
    """Solve a square system from x, which is improved in place and kept in the box.

    A step that does not lower the sum of squares is shortened by damping; one that does resets the damping towards
    Newton's step.

    Parameters
    ----------
    evaluate, problem
        The function, see the module.
    lower, upper
        Box, shape (n,).
    x
        Start and result, shape (n,).
    settings
        When to stop.
    work
        Scratch; holds residual and Jacobian at x afterwards.

    Returns
    -------
    tuple of bool and int
        Whether the tolerance was met, and the number of evaluations.
    """
    n = x.size
    evaluate(problem, x, work.residual, work.jacobian)
    evaluations = 1
    damping = 0.0
    squares = sum_of_squares(work.residual)
    while evaluations < settings.evaluations:
        if largest(work.residual) <= settings.tolerance:
            return True, evaluations
        if descent(work, damping) != 0.0:
            for i in range(n):
                work.trial[i] = min(max(x[i] - work.step[i], lower[i]), upper[i])
            evaluate(problem, work.trial, work.trial_residual, work.trial_jacobian)
            evaluations += 1
            trial_squares = sum_of_squares(work.trial_residual)
            if trial_squares < squares:
                squares = trial_squares
                x[:] = work.trial
                work.residual[:] = work.trial_residual
                work.jacobian[:] = work.trial_jacobian
                damping = damping / DAMPING_FACTOR if damping > FIRST_DAMPING else 0.0
                continue
        damping = max(DAMPING_FACTOR * damping, FIRST_DAMPING)
        if not damping < LARGEST_DAMPING:
            break
    return largest(work.residual) <= settings.tolerance, evaluations
