"""Samples of a box of inputs."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import qmc

from trackctl.errors import UsageError

Array = NDArray[np.float64]


def sobol_sample(lower: ArrayLike, upper: ArrayLike, count: int, seed: int | np.random.Generator) -> Array:
    """Scrambled Sobol' points in a box: even in every axis, yet each point uniformly distributed.

    The first `count` points of a sequence of 2^m: any count is allowed, and a power of two is the evenest.

    Parameters
    ----------
    lower, upper : array_like, shape (inputs,)
        Opposite corners of the box, any units; equal where an input is held fixed.
    count
        Number of points, at least 1.
    seed
        Seed or generator of the scrambling.

    Returns
    -------
    ndarray, shape (count, inputs)

    Raises
    ------
    UsageError
        If `count` is below 1.

    References
    ----------
    .. [1] A. B. Owen, "Scrambling Sobol' and Niederreiter-Xing points", J. Complexity 14 (1998),
       doi:10.1006/jcom.1998.0487.
    """
    if count < 1:
        raise UsageError("--samples", count, "1 or more")
    low, high = np.asarray(lower, dtype=np.float64), np.asarray(upper, dtype=np.float64)
    sequence = qmc.Sobol(low.size, scramble=True, seed=np.random.default_rng(seed))
    unit_points = sequence.random_base2((count - 1).bit_length())[:count]
    return low + (high - low) * unit_points
