"""Memory that the solvers work in, made once for a thread."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel

Array = NDArray[np.float64]


class Workspace(NamedTuple):
    """Scratch arrays for a system of n equations in n unknowns.

    After a solve, `residual` and `jacobian` hold those of the returned point.
    """

    residual: Array
    jacobian: Array
    trial: Array
    trial_residual: Array
    trial_jacobian: Array
    matrix: Array
    step: Array


@kernel
def workspace(n: int) -> Workspace:
    """Scratch arrays for n equations."""
    return Workspace(
        np.empty(n), np.empty((n, n)), np.empty(n), np.empty(n), np.empty((n, n)), np.empty((n, n)), np.empty(n)
    )
