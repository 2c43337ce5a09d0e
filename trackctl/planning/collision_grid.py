"""What a plan must not touch, as a grid: everything on a map ends up here before a search."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class CollisionGrid(NamedTuple):
    """Blocked cells of a map, for kernels; what lies outside the grid is blocked.

    Attributes
    ----------
    blocked
        Whether a cell is blocked, shape (n_rows, n_columns), row 0 the lowest y of the grid's own frame.
    distance
        From a cell's centre to the nearest blocked cell's centre, cells outside the grid included; 0 in blocked cells,
        shape of `blocked`. [m]
    resolution
        Width of a cell. [m]
    x, y
        Lower left corner of cell (0, 0) in the world. [m]
    cos_yaw, sin_yaw
        Of the grid's direction of columns (its own x axis) in the world.
    """

    blocked: NDArray[np.bool_]
    distance: NDArray[np.float64]
    resolution: float
    x: float
    y: float
    cos_yaw: float
    sin_yaw: float
