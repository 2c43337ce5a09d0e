"""Pseudo-arclength continuation: follow a root as a parameter goes from 0 to 1, through the fold where it turns back.

The parts of the method, for a loop that evaluates the function itself (see `levenberg_marquardt`). A curve is a
sequence of points (x, parameter) in n + 1 dimensions.

References
----------
.. [1] Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems, 1977.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.solvers.elimination import eliminate

Array = NDArray[np.float64]

FIRST_STEP = 0.05
SMALLEST_STEP = 1e-6
LARGEST_STEP = 0.5
SHRINK, GROW = 0.25, 2.0
#: Step of the parameter for the derivative by it.
DIFFERENCE = 1e-6


#: A record of the type `curve(n)`.
Curve = Any


def curve(n: int) -> np.dtype[np.void]:
    """Memory of a continuation in n unknowns.

    `point`, `before` and `predicted` are (x, parameter) now, at the last accepted point, and where the unit `tangent`
    leads; a correction stays in the plane through `predicted` with the `normal`. `matrix` and `step` are the bordered
    system and its Newton step, `by_parameter` the derivative of the function by the parameter.
    """
    names = ("point", "before", "predicted", "tangent", "normal", "step")
    vectors = [(name, np.float64, (n + 1,)) for name in names]
    more = [("by_parameter", np.float64, (n,)), ("matrix", np.float64, (n + 1, n + 1))]
    return np.dtype([*vectors, *more], align=True)


@kernel
def start(line: Curve, x: Array) -> None:
    """Begin at a root x of parameter 0, towards growing parameter."""
    n = x.size
    for i in range(n):
        line.point[i] = x[i]
        line.tangent[i] = 0.0
    line.point[n] = 0.0
    line.tangent[n] = 1.0
    predict(line, 0.0)


@kernel
def differentiate(line: Curve, residual: Array, residual_beside: Array) -> None:
    """Derivative by the parameter, from the residuals at the point and at its parameter plus `DIFFERENCE`."""
    for i in range(residual.size):
        line.by_parameter[i] = (residual_beside[i] - residual[i]) / DIFFERENCE


@kernel
def border(line: Curve, jacobian: Array, residual: Array) -> None:
    """Set up the bordered system at the point."""
    n = residual.size
    for i in range(n):
        for j in range(n):
            line.matrix[i, j] = jacobian[i, j]
        line.matrix[i, n] = line.by_parameter[i]
        line.step[i] = residual[i]
    line.step[n] = 0.0
    for j in range(n + 1):
        line.matrix[n, j] = line.normal[j]
        line.step[n] += line.normal[j] * (line.point[j] - line.predicted[j])


@kernel
def correct(line: Curve) -> bool:
    """Newton step to the plane of the correction and the curve; False where it is not defined."""
    if eliminate(line.matrix, line.step) == 0.0:
        return False
    for i in range(line.point.size):
        line.point[i] -= line.step[i]
    return True


@kernel
def turn(line: Curve) -> bool:
    """Unit tangent at the point, from the bordered system, towards the normal; False where it is not defined."""
    n = line.step.size - 1
    for i in range(n + 1):
        line.step[i] = 0.0
    line.step[n] = 1.0
    if eliminate(line.matrix, line.step) == 0.0:
        return False
    squares = 0.0
    for i in range(n + 1):
        squares += line.step[i] * line.step[i]
    for i in range(n + 1):
        line.tangent[i] = line.step[i] / math.sqrt(squares)
    return math.isfinite(squares)


@kernel
def predict(line: Curve, step: float) -> None:
    """Go along the tangent by a step, to be corrected normal to it."""
    for i in range(line.point.size):
        line.before[i] = line.point[i]
        line.normal[i] = line.tangent[i]
        line.predicted[i] = line.point[i] + step * line.tangent[i]
        line.point[i] = line.predicted[i]


@inlined
def way_to_go(line: Curve) -> float:
    """Length along the tangent to where the parameter is 1."""
    n = line.point.size - 1
    return float((1.0 - line.point[n]) / line.tangent[n])


@kernel
def predict_end(line: Curve) -> None:
    """Go along the tangent to parameter 1, to be corrected at that parameter."""
    predict(line, way_to_go(line))
    n = line.point.size - 1
    for i in range(n):
        line.normal[i] = 0.0
    line.normal[n] = line.point[n] = line.predicted[n] = 1.0


@kernel
def step_back(line: Curve) -> None:
    """Return to the last accepted point."""
    for i in range(line.point.size):
        line.point[i] = line.before[i]


@inlined
def has_folded(line: Curve) -> bool:
    """Whether the parameter no longer grows along the curve."""
    return bool(line.tangent[line.tangent.size - 1] <= 0.0)
