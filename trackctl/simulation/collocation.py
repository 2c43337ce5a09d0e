"""Radau IIA collocation of fifth order: coefficients, and interpolation between its nodes.

A step of length h is parametrised by theta in [0, 1]. The solution is the cubic through its value at 0 whose
derivative is the right-hand side at the three nodes; the last one is the end of the step. The method is stiffly
accurate and L-stable.

References
----------
.. [1] Hairer, Wanner, Solving ordinary differential equations II, 1996, section IV.8.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel

Array = NDArray[np.float64]

ROOT_6 = math.sqrt(6.0)
STAGES = 3
NODES: Array = np.array([(4.0 - ROOT_6) / 10.0, (4.0 + ROOT_6) / 10.0, 1.0])
#: Integral over [0, c_i] of the Lagrange polynomial of node j.
INTEGRAL: Array = np.array(
    np.linalg.solve(
        (NODES[None, :] ** np.arange(STAGES)[:, None]),
        (NODES[None, :] ** np.arange(1, STAGES + 1)[:, None]) / np.arange(1, STAGES + 1)[:, None],
    ).T,
    np.float64,
    order="C",
)
#: Derivative by theta at the nodes of a cubic that is 0 at 0, from its values there.
DERIVATIVE: Array = np.asarray(np.linalg.inv(INTEGRAL), np.float64)
#: Coefficients, lowest first, of the cubic through values at 0 and the nodes.
TO_CUBIC: Array = np.asarray(np.linalg.inv(np.vander(np.concatenate(([0.0], NODES)), increasing=True)), np.float64)
#: Real eigenvalue of `DERIVATIVE`, and weights of the stages in the embedded error estimate.
REAL_EIGENVALUE = float(next(value.real for value in np.linalg.eigvals(DERIVATIVE) if abs(value.imag) < 1e-9))
ERROR_WEIGHTS: Array = np.array([-(13.0 + 7.0 * ROOT_6), -13.0 + 7.0 * ROOT_6, -1.0]) / 3.0


@kernel
def interpolate(values: Array, theta: float) -> float:
    """Value at theta of the cubic through four values at 0 and the nodes."""
    result = 0.0
    for i in range(STAGES, -1, -1):
        coefficient = 0.0
        for j in range(STAGES + 1):
            coefficient += TO_CUBIC[i, j] * values[j]
        result = result * theta + coefficient
    return result


@kernel
def invert(matrix: Array, inverse: Array) -> bool:
    """Invert a matrix, which is overwritten, by Gauss-Jordan elimination with pivoting; False if it is singular."""
    n = matrix.shape[0]
    for i in range(n):
        for j in range(n):
            inverse[i, j] = 1.0 if i == j else 0.0
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[pivot, k]):
                pivot = i
        if not abs(matrix[pivot, k]) > 0.0:
            return False
        for j in range(n):
            matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
            inverse[k, j], inverse[pivot, j] = inverse[pivot, j], inverse[k, j]
        scale = 1.0 / matrix[k, k]
        for j in range(n):
            matrix[k, j] *= scale
            inverse[k, j] *= scale
        for i in range(n):
            factor = matrix[i, k]
            if i != k and factor != 0.0:
                for j in range(n):
                    matrix[i, j] -= factor * matrix[k, j]
                    inverse[i, j] -= factor * inverse[k, j]
    return True
