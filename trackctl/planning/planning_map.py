"""All that a map lays down for a plan, and the grids that a search works on."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.errors import MapError
from trackctl.geometry.circle import Circle
from trackctl.planning.collision_grid import CollisionGrid
from trackctl.planning.elevation import Elevation, fitted_slopes, footprint_scale
from trackctl.planning.obstacles import Polygon, block_circle, block_polygon
from trackctl.planning.occupancy import GridFrame, Occupancy
from trackctl.planning.slope_field import SlopeField, gradient_at, plane_slope
from trackctl.profiles.footprint import Footprint

Pose = tuple[float, float, float]
Bounds = tuple[float, float, float, float]

#: What a search can hold in memory: 4000 x 4000.
MAX_CELLS = 16_000_000
#: A map without an image: width of its cells at least, and cells along its longer side at most, unless told. [m]
FINEST, MOST_CELLS_ALONG = 0.05, 1000
#: And the room left around its obstacles, start and goal: this part of their extent, and at least so much. [m]
MARGIN, SMALLEST_MARGIN = 0.5, 10.0


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PlanningMap:
    """A map and what it says of the plan to be made on it; None where it says nothing.

    Attributes
    ----------
    file
        Where it was read from, for messages.
    occupancy
        Of the cells of an image or grid file.
    circles, polygons
        Obstacles in the world. [m]
    elevation
        Heights of the ground, in whose place `slope` and `uphill_yaw` may stand.
    slope, uphill_yaw
        Of one plane. [rad]
    bounds
        Lowest x, y and highest x, y of a map without an image. [m]
    resolution
        Width of its cells. [m]
    start, goal
        x, y and yaw. [m, m, rad]
    goal_tolerance
        Of the position [m] and the yaw [rad].
    vehicle, terrain, lut
        Profiles and look-up table, as named in the file.
    notes
        What was made of the files that the user should know of, as sentences.
    """

    file: str
    occupancy: Occupancy | None = None
    circles: tuple[Circle, ...] = ()
    polygons: tuple[Polygon, ...] = ()
    elevation: Elevation | None = None
    slope: float | None = None
    uphill_yaw: float | None = None
    bounds: Bounds | None = None
    resolution: float | None = None
    start: Pose | None = None
    goal: Pose | None = None
    goal_tolerance: tuple[float, float] | None = None
    vehicle: str | None = None
    terrain: str | None = None
    lut: str | None = None
    notes: tuple[str, ...] = ()


def overridden(planning_map: PlanningMap, **given: Any) -> PlanningMap:
    """The map with the values given in place of its own; None leaves its own.

    A plane takes the place of an elevation grid and the other way round; a `resolution` rescales an image about its
    origin.
    """
    chosen = {name: value for name, value in given.items() if value is not None}
    if chosen.get("slope") is not None:
        chosen.setdefault("elevation", None)
    elif chosen.get("elevation") is not None:
        chosen |= {"slope": None, "uphill_yaw": None}
    occupancy = planning_map.occupancy
    if "resolution" in chosen and occupancy is not None:
        frame = replace(occupancy.frame, resolution=chosen["resolution"])
        chosen["occupancy"] = replace(occupancy, frame=frame)
    return replace(planning_map, **chosen)


def slope_field(planning_map: PlanningMap, footprint: Footprint) -> SlopeField:
    """The slope that a vehicle of this outline stands on; level ground where the map tells none."""
    if planning_map.elevation is not None:
        return fitted_slopes(planning_map.elevation, footprint_scale(footprint))
    uphill_yaw = planning_map.uphill_yaw
    return plane_slope(planning_map.slope or 0.0, math.pi / 2 if uphill_yaw is None else uphill_yaw)


def grid_frame(planning_map: PlanningMap) -> GridFrame:
    """Where the cells of a map lie: those of its image, or else over its bounds.

    Raises
    ------
    MapError
        If there would be too many cells, or nothing is on the map to tell its bounds by.
    """
    if planning_map.occupancy is not None:
        return planning_map.occupancy.frame
    left, low, right, high = planning_map.bounds or _bounds(planning_map)
    longest = max(right - left, high - low)
    resolution = planning_map.resolution or max(FINEST, longest / MOST_CELLS_ALONG)
    n_rows, n_columns = (max(math.ceil(side / resolution - 1e-9), 1) for side in (high - low, right - left))
    if n_rows * n_columns > MAX_CELLS:
        raise MapError(
            planning_map.file,
            f"{right - left:g} m x {high - low:g} m in cells of {resolution:g} m are {n_rows * n_columns} cells; "
            f"allowed: up to {MAX_CELLS}, with a larger resolution",
        )
    return GridFrame(n_rows, n_columns, resolution, left, low)


def collision_grid(planning_map: PlanningMap, slopes: SlopeField, *, allow_unknown: bool = False) -> CollisionGrid:
    """Cells that are occupied, touched by an obstacle, or without a known slope at their centre.

    Parameters
    ----------
    planning_map
        The map.
    slopes
        Its `slope_field`.
    allow_unknown
        Whether cells that the image does not call occupied may be driven on.

    Raises
    ------
    MapError
        See `grid_frame`; or if no cell lies on known ground of the elevation grid.
    """
    frame = grid_frame(planning_map)
    blocked = np.zeros((frame.n_rows, frame.n_columns), np.bool_)
    if planning_map.occupancy is not None:
        blocked |= planning_map.occupancy.blocked(allow_unknown=allow_unknown)
    for circle in planning_map.circles:
        block_circle(blocked, frame, circle)
    for polygon in planning_map.polygons:
        block_polygon(blocked, frame, polygon)
    if planning_map.elevation is not None:
        along = frame.resolution * math.cos(frame.yaw), frame.resolution * math.sin(frame.yaw)
        if not block_unknown_ground(blocked, slopes, (frame.x, frame.y), along):
            raise _no_ground(planning_map, planning_map.elevation)
    return _with_distance(blocked, frame)


def _with_distance(blocked: NDArray[np.bool_], frame: GridFrame) -> CollisionGrid:
    from scipy.ndimage import distance_transform_edt

    # A rim of blocked cells stands for all that lies outside.
    free = np.pad(~blocked, 1, constant_values=False)
    distance = frame.resolution * distance_transform_edt(free)[1:-1, 1:-1]
    return CollisionGrid(
        blocked,
        np.ascontiguousarray(distance),
        frame.resolution,
        frame.x,
        frame.y,
        math.cos(frame.yaw),
        math.sin(frame.yaw),
    )


@kernel
def block_unknown_ground(
    blocked: NDArray[np.bool_], slopes: SlopeField, corner: tuple[float, float], along: tuple[float, float]
) -> int:
    """Block the cells at whose centre no gradient is known, in place; the number of the others comes back.

    `corner` is the lower left one of cell (0, 0), `along` the step from a column to the next. [m]
    """
    n_rows, n_columns = blocked.shape
    known = 0
    for i in range(n_rows):
        for j in range(n_columns):
            x = corner[0] + along[0] * (j + 0.5) - along[1] * (i + 0.5)
            y = corner[1] + along[1] * (j + 0.5) + along[0] * (i + 0.5)
            if math.isnan(gradient_at(slopes, x, y)[0]):
                blocked[i, j] = True
            else:
                known += 1
    return known


def _no_ground(planning_map: PlanningMap, elevation: Elevation) -> MapError:
    left, low, right, high = elevation.bounds
    return MapError(
        planning_map.file,
        f"no cell lies on known ground of {elevation.source}, which reaches from ({left:.10g}, {low:.10g}) to "
        f"({right:.10g}, {high:.10g}) m; `elevation_origin_m: [x, y]` puts its lower left corner elsewhere",
    )


def _bounds(planning_map: PlanningMap) -> Bounds:
    """Those of the elevation grid, or else of all that is on the map with a margin."""
    if planning_map.elevation is not None:
        return planning_map.elevation.bounds
    points = [pose[:2] for pose in (planning_map.start, planning_map.goal) if pose is not None]
    points += [corner for polygon in planning_map.polygons for corner in polygon]
    for circle in planning_map.circles:
        points += [(circle.x + sign * circle.radius, circle.y + sign * circle.radius) for sign in (-1.0, 1.0)]
    if not points:
        raise MapError(planning_map.file, "holds nothing; allowed: image, obstacles, elevation, or start and goal")
    x, y = np.array(points).T
    margin = max(SMALLEST_MARGIN, MARGIN * max(np.ptp(x), np.ptp(y)))
    return float(x.min() - margin), float(y.min() - margin), float(x.max() + margin), float(y.max() + margin)
