"""A map as the picture of a plan shows it."""

from __future__ import annotations

import math

import numpy as np

from trackctl.planning.collision_grid import CollisionGrid
from trackctl.planning.occupancy import UNKNOWN
from trackctl.planning.planning_map import PlanningMap
from trackctl.plots.plan import MapImage

UNKNOWN_LIGHTNESS = 0.75


def map_image(planning_map: PlanningMap, grid: CollisionGrid) -> MapImage:
    """What is blocked dark, what an image does not know grey, the rest light."""
    lightness = np.where(grid.blocked, 0.0, 1.0)
    if planning_map.occupancy is not None:
        lightness[planning_map.occupancy.cells == UNKNOWN] = UNKNOWN_LIGHTNESS
    return MapImage(lightness[::-1], grid.resolution, (grid.x, grid.y, math.atan2(grid.sin_yaw, grid.cos_yaw)))
