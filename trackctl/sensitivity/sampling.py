"""Samples of a box of inputs."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trackctl.errors import UsageError

Array = NDArray[np.float64]


def latin_hypercube(lower: ArrayLike, upper: ArrayLike, count: int, seed: int | np.random.Generator) -> Array:
    """Points of a box, one at random in each of `count` equal strata of every axis [1]_.

    Written out because importing a library for it (scipy.stats) takes longer than the whole analysis.

    Parameters
    ----------
    lower, upper : array_like, shape (inputs,)
        Opposite corners of the box, any units; equal where an input is held fixed.
    count
        Number of points, at least 1.
    seed
        Seed or generator.

    Returns
    -------
    ndarray, shape (count, inputs)

    Raises
    ------
    UsageError
        If `count` is below 1.

    References
    ----------
    .. [1] McKay, Beckman, Conover, A comparison of three methods for selecting values of input variables,
       Technometrics 21 (1979), doi:10.1080/00401706.1979.10489755.
    """
    if count < 1:
        raise UsageError("--samples", count, "1 or more")
    low, high = np.asarray(lower, dtype=np.float64), np.asarray(upper, dtype=np.float64)
    random = np.random.default_rng(seed)
    strata = random.permuted(np.tile(np.arange(count)[:, None], low.size), axis=0)
    return low + (high - low) * (strata + random.random(strata.shape)) / count
