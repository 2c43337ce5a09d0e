"""Circles and their least-squares fit."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Circle:
    """Centre and radius. [m]"""

    x: float
    y: float
    radius: float


def fitted_circle(x: Array, y: Array) -> Circle:
    """Circle through points by linear least squares in x^2 + y^2 = 2 x_c x + 2 y_c y + (r^2 - x_c^2 - y_c^2).

    Parameters
    ----------
    x, y : ndarray, shape (n_points,)
        Three points or more. [m]
    """
    # About the points' mean, so that nothing is lost far from the origin.
    x_mean, y_mean = float(x.mean()), float(y.mean())
    u, v = x - x_mean, y - y_mean
    system = np.stack((2.0 * u, 2.0 * v, np.ones_like(u)), axis=1)
    a, b, c = np.linalg.lstsq(system, u * u + v * v, rcond=None)[0].tolist()
    return Circle(x_mean + a, y_mean + b, math.sqrt(c + a * a + b * b))
