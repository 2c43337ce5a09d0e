"""Gauss and Newton's method for sums of squares of many residuals."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: After a step below this share of the largest unknown, or of 1, what is left is less by far.
STEP = 1e-9
ITERATIONS = 50
HALVINGS = 20

#: From unknowns to the sum of squares there, and what computes the step to the minimum of the linearised problem.
Linearise = Callable[[Array], tuple[float, Callable[[], Array]]]


def gauss_newton(linearise: Linearise, start: Array) -> tuple[Array, int]:
    """Least sum of squares from a start, each step halved until it does not go up.

    Returns
    -------
    tuple of ndarray, shape (n,), and int
        The minimum, or where no step goes down any more, and the number of steps to it.
    """
    unknowns = start
    squares, step = linearise(unknowns)
    for iteration in range(1, ITERATIONS + 1):
        change = step()
        if np.abs(change).max() <= STEP * max(1.0, float(np.abs(unknowns).max())):
            return unknowns + change, iteration
        for _ in range(HALVINGS):
            new_squares, new_step = linearise(unknowns + change)
            if new_squares <= squares:
                break
            change = 0.5 * change
        else:
            return unknowns, iteration
        unknowns, squares, step = unknowns + change, new_squares, new_step
    return unknowns, ITERATIONS
