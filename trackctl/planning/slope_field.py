"""Slope of the ground over a map."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class SlopeField(NamedTuple):
    """Angle and direction of the steepest slope at the nodes of a grid, for kernels; a plane has one node.

    The gradient of the height is what is interpolated: the direction has no mean, and none at all on level ground.

    Attributes
    ----------
    gradient_x, gradient_y
        Derivatives of the height along the world's x and y at the nodes, shape (n_rows, n_columns), row 0 the lowest y;
        NaN where the ground is not known. [-]
    spacing_x, spacing_y
        Of the nodes. [m]
    x, y
        Node (0, 0) in the world. [m]
    """

    gradient_x: Array
    gradient_y: Array
    spacing_x: float
    spacing_y: float
    x: float
    y: float
