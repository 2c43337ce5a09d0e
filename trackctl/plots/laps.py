"""Laps of a driven path, and the circles that fit them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from trackctl.plots.style import Array


@dataclass(frozen=True, slots=True)
class Circle:
    """A circle in the plane. [m]"""

    centre_x: float
    centre_y: float
    radius: float


def laps(yaw: Array) -> list[slice]:
    """Rows of each lap: 2 pi of yaw from the start, whole laps only; the row that ends a lap begins the next.

    Parameters
    ----------
    yaw : ndarray, shape (n_rows,)
        Wrapped or not, less than half a turn between rows. [rad]
    """
    turned = np.abs(np.unwrap(yaw) - yaw[0]) / (2.0 * np.pi)
    # Rounding must not lose a last lap that ends with the file.
    whole = int(turned[-1] + 1e-6)
    ends = [int(np.argmax(turned >= lap - 1e-6)) for lap in range(whole + 1)]
    return [slice(start, end) for start, end in pairwise(ends)]


def fitted_circle(x: Array, y: Array) -> Circle:
    """Least-squares circle: 2 x_c x + 2 y_c y + (r^2 - x_c^2 - y_c^2) = x^2 + y^2, linear in its unknowns.

    Parameters
    ----------
    x, y : ndarray, shape (n_points,)
        Three points or more. [m]
    """
    middle_x, middle_y = float(np.mean(x)), float(np.mean(y))
    u, v = x - middle_x, y - middle_y
    (a, b, c), *_ = np.linalg.lstsq(np.column_stack((2.0 * u, 2.0 * v, np.ones_like(u))), u**2 + v**2)
    return Circle(middle_x + float(a), middle_y + float(b), float(np.sqrt(c + a**2 + b**2)))
