"""Why a cell of a map is blocked, in words."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeVar

import numpy as np

from trackctl.planning.obstacles import Mask, block_circle, block_polygon
from trackctl.planning.occupancy import FREE, OCCUPIED, GridFrame
from trackctl.planning.planning_map import PlanningMap, grid_frame

Shape = TypeVar("Shape")


def describe_cell(planning_map: PlanningMap, row: int, column: int) -> str:
    """Where a blocked cell is and what blocks it, such as ``cell (3, 7) at (0.375, 0.175) m, occupied in hall.pgm``.

    Parameters
    ----------
    planning_map
        The map.
    row, column
        Of the cell, counted from 0 at the lowest y and x of the grid; it may lie outside.
    """
    frame = grid_frame(planning_map)
    x, y = frame.to_world(column + 0.5, row + 0.5)
    reason = next(_reasons(planning_map, frame, row, column), "without a known slope")
    return f"cell ({row}, {column}) at ({x:.3f}, {y:.3f}) m, {reason}"


def _reasons(planning_map: PlanningMap, frame: GridFrame, row: int, column: int) -> Iterator[str]:
    if not (0 <= row < frame.n_rows and 0 <= column < frame.n_columns):
        yield "outside the map"
        return
    occupancy = planning_map.occupancy
    if occupancy is not None and occupancy.cells[row, column] >= OCCUPIED:
        yield f"occupied in {occupancy.source}"
    cell = _cell_alone(frame, row, column)
    for count, circle in enumerate(planning_map.circles, start=1):
        if _touches(cell, block_circle, circle):
            yield f"touched by circle {count}, of {circle.radius:g} m about ({circle.x:.10g}, {circle.y:.10g})"
    for count, polygon in enumerate(planning_map.polygons, start=1):
        if _touches(cell, block_polygon, polygon):
            yield f"touched by polygon {count}, from ({polygon[0][0]:.10g}, {polygon[0][1]:.10g}) on"
    if occupancy is not None and occupancy.cells[row, column] != FREE:
        yield f"neither free nor occupied in {occupancy.source}"


def _touches(cell: GridFrame, block: Callable[[Mask, GridFrame, Shape], None], shape: Shape) -> bool:
    blocked = np.zeros((1, 1), np.bool_)
    block(blocked, cell, shape)
    return bool(blocked[0, 0])


def _cell_alone(frame: GridFrame, row: int, column: int) -> GridFrame:
    """A grid of that one cell."""
    x, y = frame.to_world(float(column), float(row))
    return GridFrame(1, 1, frame.resolution, x, y, frame.yaw)
