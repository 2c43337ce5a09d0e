"""Circles and polygons drawn into a grid: every cell is blocked whose inside a shape touches."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from trackctl.geometry.circle import Circle
from trackctl.planning.occupancy import GridFrame

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Polygon = tuple[tuple[float, float], ...]


def block_circle(blocked: Mask, frame: GridFrame, circle: Circle) -> None:
    """Block the cells that a disc touches, in place."""
    column, row = frame.to_grid(circle.x, circle.y)
    radius = circle.radius / frame.resolution
    window = _window(frame, column - radius, column + radius, row - radius, row + radius)
    columns, rows = _centres(window)
    dx = np.maximum(np.abs(columns - column) - 0.5, 0.0)
    dy = np.maximum(np.abs(rows - row) - 0.5, 0.0)
    blocked[window] |= dx * dx + dy * dy < radius * radius


def block_polygon(blocked: Mask, frame: GridFrame, polygon: Polygon) -> None:
    """Block the cells that a polygon touches, in place; where it crosses itself, all that it winds around."""
    corners = np.array(polygon)
    columns, rows = frame.to_grid(corners[:, 0], corners[:, 1])
    window = _window(frame, columns.min(), columns.max(), rows.min(), rows.max())
    winding = np.zeros(blocked[window].shape, np.int32)
    for edge in _edges(columns, rows):
        _add_winding(winding, _centres(window), edge)
        _block_edge(blocked, frame, edge)
    blocked[window] |= winding != 0


def _edges(columns: Array, rows: Array) -> Iterator[Array]:
    """Start and end of each edge: column, row, column, row."""
    corners = np.stack((columns, rows), axis=1)
    return iter(np.concatenate((corners, np.roll(corners, -1, axis=0)), axis=1))


def _add_winding(winding: NDArray[np.int32], centres: tuple[Array, Array], edge: Array) -> None:
    """Count an edge's passage to the right of each centre: +1 upwards, -1 downwards."""
    columns, rows = centres
    column, row, end_column, end_row = edge
    rises = end_row > row
    spanned = (min(row, end_row) <= rows) & (rows < max(row, end_row))
    left = (end_column - column) * (rows - row) - (columns - column) * (end_row - row)
    winding += np.where(spanned & ((left > 0.0) if rises else (left < 0.0)), 1 if rises else -1, 0)


def _block_edge(blocked: Mask, frame: GridFrame, edge: Array) -> None:
    """Block the cells whose inside an edge crosses: no axis, nor the edge's normal, parts it from the square."""
    column, row, end_column, end_row = edge
    low_column, high_column = sorted((column, end_column))
    low_row, high_row = sorted((row, end_row))
    window = _window(frame, low_column, high_column, low_row, high_row)
    columns, rows = _centres(window)
    along, across = end_column - column, end_row - row
    distance = np.abs(along * (rows - row) - across * (columns - column))
    blocked[window] |= distance < 0.5 * (abs(along) + abs(across))


def _window(frame: GridFrame, left: float, right: float, low: float, high: float) -> tuple[slice, slice]:
    """Rows and columns of the cells that a box touches, empty outside the grid."""
    first_row, end_row = _span(low, high, frame.n_rows)
    first_column, end_column = _span(left, right, frame.n_columns)
    return slice(first_row, end_row), slice(first_column, end_column)


def _span(low: float, high: float, count: int) -> tuple[int, int]:
    first = int(np.clip(np.floor(low), 0, count))
    return first, max(first, int(np.clip(np.ceil(high), 0, count)))


def _centres(window: tuple[slice, slice]) -> tuple[Array, Array]:
    """Columns, shape (1, n), and rows, shape (m, 1), of the centres of a window's cells."""
    rows, columns = (np.arange(part.start, part.stop) + 0.5 for part in window)
    return columns[None, :], rows[:, None]
