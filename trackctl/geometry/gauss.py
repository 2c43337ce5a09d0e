"""Gauss-Legendre quadrature over the stretches between breaks."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@functools.cache
def unit_rule(count: int) -> tuple[Array, Array]:
    """Points in (0, 1) and weights of sum 1, each of shape (count,)."""
    points, weights = np.polynomial.legendre.leggauss(count)
    return 0.5 * (points + 1.0), 0.5 * weights


def gauss_points(breaks: Array, count: int) -> tuple[Array, Array]:
    """Points and weights of `count` points a stretch, each of shape (breaks.size - 1, count)."""
    points, weights = unit_rule(count)
    widths = np.diff(breaks)[:, None]
    return breaks[:-1, None] + widths * points, widths * weights
