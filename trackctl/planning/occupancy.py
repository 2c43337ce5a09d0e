"""A grid of cells in the world, and what a map says of each cell."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Coordinate = TypeVar("Coordinate", float, NDArray[np.float64])

#: What a cell may hold besides the numbers between: how sure a map is that it is occupied, in percent.
UNKNOWN, FREE, OCCUPIED = -1, 0, 100


@dataclass(frozen=True, slots=True)
class GridFrame:
    """Where the cells of a grid lie.

    Attributes
    ----------
    n_rows, n_columns
        Number of cells along the grid's own y and x.
    resolution
        Width of a cell. [m]
    x, y, yaw
        Pose of the lower left corner of cell (0, 0) in the world; the grid is turned counter-clockwise about it.
        [m, m, rad]
    """

    n_rows: int
    n_columns: int
    resolution: float
    x: float
    y: float
    yaw: float = 0.0

    def to_grid(self, x: Coordinate, y: Coordinate) -> tuple[Coordinate, Coordinate]:
        """Points of the world in the grid's own axes, in cells from its lower left corner."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        dx, dy = x - self.x, y - self.y
        return (cos * dx + sin * dy) / self.resolution, (cos * dy - sin * dx) / self.resolution

    def to_world(self, column: Coordinate, row: Coordinate) -> tuple[Coordinate, Coordinate]:
        """The inverse of `to_grid`; the centre of cell (i, j) is at column j + 1/2 and row i + 1/2. [m]"""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        dx, dy = column * self.resolution, row * self.resolution
        return self.x + cos * dx - sin * dy, self.y + sin * dx + cos * dy

    def cell(self, x: float, y: float) -> tuple[int, int] | None:
        """Row and column of the cell that holds a point of the world; None outside the grid."""
        column, row = (math.floor(value) for value in self.to_grid(x, y))
        inside = 0 <= row < self.n_rows and 0 <= column < self.n_columns
        return (row, column) if inside else None


@dataclass(frozen=True, slots=True, eq=False)
class Occupancy:
    """What an image or a grid file says of the ground.

    Attributes
    ----------
    cells
        `UNKNOWN`, or from `FREE` to `OCCUPIED`, int8, shape (n_rows, n_columns), row 0 the lowest y.
    frame
        Where the cells lie.
    source
        The file they come from, for messages.
    """

    cells: NDArray[np.int8]
    frame: GridFrame
    source: str

    def blocked(self, *, allow_unknown: bool) -> NDArray[np.bool_]:
        """Cells that must not be touched: all that are not free, or with `allow_unknown` the occupied alone."""
        return self.cells >= OCCUPIED if allow_unknown else self.cells != FREE
