"""Pseudo-arclength continuation: follow a root as a parameter goes from 0 to 1, through the fold where it turns back.

The parts of the method, for a loop that evaluates the function itself (see `levenberg_marquardt`). A curve is a sequence
of points (x, parameter) in n + 1 dimensions.

References
----------
.. [1] Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems, 1977.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.solvers.elimination import eliminate

Array = NDArray[np.float64]

FIRST_STEP = 0.1
SMALLEST_STEP = 1e-6
LARGEST_STEP = 0.5
SHRINK, GROW = 0.25, 1.6
#: Step of the parameter for the derivative by it.
DIFFERENCE = 1e-6


class Curve(NamedTuple):
    """State of a continuation in n unknowns.

    Attributes
    ----------
    point, before, predicted
        (x, parameter) now, at the last accepted point, and where the tangent leads, shape (n + 1,).
    tangent
        Unit tangent in the direction of travel, shape (n + 1,).
    matrix
        Jacobian, bordered by the derivative by the parameter and by the tangent, shape (n + 1, n + 1).
    step
        Right-hand side and Newton step, shape (n + 1,).
    """

    point: Array
    before: Array
    predicted: Array
    tangent: Array
    matrix: Array
    step: Array


@kernel
def curve(n: int) -> Curve:
    """Memory of a continuation."""
    return Curve(
        np.empty(n + 1), np.empty(n + 1), np.empty(n + 1), np.empty(n + 1), np.empty((n + 1, n + 1)), np.empty(n + 1)
    )


@kernel
def start(line: Curve, x: Array) -> None:
    """Begin at a root x of parameter 0, towards growing parameter."""
    n = x.size
    line.point[:n] = x
    line.point[n] = 0.0
    line.tangent[:] = 0.0
    line.tangent[n] = 1.0


@kernel
def border(line: Curve, jacobian: Array, residual: Array, residual_beside: Array) -> None:
    """Set up the bordered system at the point; `residual_beside` is at the parameter plus `DIFFERENCE`."""
    n = residual.size
    for i in range(n):
        for j in range(n):
            line.matrix[i, j] = jacobian[i, j]
        line.matrix[i, n] = (residual_beside[i] - residual[i]) / DIFFERENCE
        line.step[i] = residual[i]
    line.step[n] = 0.0
    for j in range(n + 1):
        line.matrix[n, j] = line.tangent[j]
        line.step[n] += line.tangent[j] * (line.point[j] - line.predicted[j])


@kernel
def correct(line: Curve) -> bool:
    """Newton step in the plane normal to the tangent through the predicted point; False where it is not defined."""
    if eliminate(line.matrix, line.step) == 0.0:
        return False
    line.point[:] = line.point - line.step
    return True


@kernel
def turn(line: Curve) -> bool:
    """Unit tangent at the point, from the bordered system; False where it is not defined."""
    n = line.step.size - 1
    line.step[:] = 0.0
    line.step[n] = 1.0
    if eliminate(line.matrix, line.step) == 0.0:
        return False
    norm = math.sqrt(np.sum(line.step * line.step))
    line.tangent[:] = line.step / norm
    return math.isfinite(norm)


@kernel
def predict(line: Curve, step: float) -> None:
    """Go along the tangent by a step."""
    line.before[:] = line.point
    line.predicted[:] = line.point + step * line.tangent
    line.point[:] = line.predicted


@kernel
def has_folded(line: Curve) -> bool:
    """Whether the parameter no longer grows along the curve."""
    return line.tangent[line.tangent.size - 1] <= 0.0
