"""Gaussian elimination for systems of a few equations, inside compiled code."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel

Array = NDArray[np.float64]


@kernel
def eliminate(matrix: Array, vector: Array) -> float:
    """Solve matrix @ y = vector in place, with partial pivoting.

    Parameters
    ----------
    matrix
        Shape (n, n); overwritten.
    vector
        Right-hand side, shape (n,); overwritten by the solution.

    Returns
    -------
    float
        The determinant; at 0 the vector holds no solution.
    """
    n = vector.size
    determinant = 1.0
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[pivot, k]):
                pivot = i
        if pivot != k:
            for j in range(k, n):
                kept = matrix[k, j]
                matrix[k, j] = matrix[pivot, j]
                matrix[pivot, j] = kept
            kept = vector[k]
            vector[k] = vector[pivot]
            vector[pivot] = kept
            determinant = -determinant
        determinant *= matrix[k, k]
        if matrix[k, k] == 0.0:
            return 0.0
        for i in range(k + 1, n):
            factor = matrix[i, k] / matrix[k, k]
            for j in range(k + 1, n):
                matrix[i, j] -= factor * matrix[k, j]
            vector[i] -= factor * vector[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            vector[k] -= matrix[k, j] * vector[j]
        vector[k] /= matrix[k, k]
    return determinant
