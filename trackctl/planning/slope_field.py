"""Slope of the ground over a map."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel

Array = NDArray[np.float64]


class SlopeField(NamedTuple):
    """Gradient of the height at the nodes of a grid, for kernels; a plane has one node and no end.

    The gradient is what is interpolated: the direction of a slope has no mean, and none at all on level ground.

    Attributes
    ----------
    gradient_x, gradient_y
        Derivatives of the height along the world's x and y at the nodes, shape (n_rows, n_columns), row 0 the lowest y;
        NaN where the ground is not known. [-]
    spacing_x, spacing_y
        Of the nodes. [m]
    x, y
        Node (0, 0) in the world. [m]
    level_uphill
        What counts as the direction of up-slope where the ground is level. [rad]
    """

    gradient_x: Array
    gradient_y: Array
    spacing_x: float
    spacing_y: float
    x: float
    y: float
    level_uphill: float = 0.0


def plane_slope(slope: float, uphill_yaw: float) -> SlopeField:
    """One slope everywhere.

    Parameters
    ----------
    slope
        Angle of the steepest slope. [rad]
    uphill_yaw
        Direction in which the ground rises most. [rad]
    """
    steepness = math.tan(slope)
    gradient_x = np.array([[steepness * math.cos(uphill_yaw)]])
    gradient_y = np.array([[steepness * math.sin(uphill_yaw)]])
    return SlopeField(gradient_x, gradient_y, 1.0, 1.0, 0.0, 0.0, uphill_yaw)


@kernel
def gradient_at(slopes: SlopeField, x: float, y: float) -> tuple[float, float]:
    """Gradient of the height along the world's x and y at a point; a plane has one everywhere.

    Bilinear between four nodes, that of the rim up to half a spacing outside it; NaN beyond, and where one of the
    nodes that count is unknown.
    """
    n_rows, n_columns = slopes.gradient_x.shape
    if n_rows == 1 and n_columns == 1:
        return slopes.gradient_x[0, 0], slopes.gradient_y[0, 0]
    column = (x - slopes.x) / slopes.spacing_x
    row = (y - slopes.y) / slopes.spacing_y
    if not (-0.5 <= column <= n_columns - 0.5 and -0.5 <= row <= n_rows - 0.5):
        return np.nan, np.nan
    column = min(max(column, 0.0), n_columns - 1.0)
    row = min(max(row, 0.0), n_rows - 1.0)
    i, j = min(int(row), max(n_rows - 2, 0)), min(int(column), max(n_columns - 2, 0))
    up, right = row - i, column - j
    gradient_x = gradient_y = 0.0
    for di in range(2):
        for dj in range(2):
            weight = (up if di else 1.0 - up) * (right if dj else 1.0 - right)
            if weight > 0.0:
                gradient_x += weight * slopes.gradient_x[i + di, j + dj]
                gradient_y += weight * slopes.gradient_y[i + di, j + dj]
    return gradient_x, gradient_y
