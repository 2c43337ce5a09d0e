"""What turns a route into commands: the vehicle, the ground and its limits."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trackctl.planning.collision import Obstacles
from trackctl.planning.ground import Cost, Ground, ground_of
from trackctl.planning.slope_field import SlopeField
from trackctl.planning.steering_limits import SteeringLimits
from trackctl.planning.surface_line import gradients_along
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.simulation.spot_turn import SpotDrive, spot_drive
from trackctl.simulation.vehicle_rates import Scene, scene

Array = NDArray[np.float64]

#: Between poses that are checked for collisions, in cells, or over the footprint's reach if that is less.
CHECKED = 0.25
#: Slip that a plan may need, or so many times that of the steady turns, if it is more; and where there is no other. [-]
MOST_SLIP, MORE_SLIP, MUCH_MORE_SLIP = 0.25, 1.1, 1.5
#: Blends over the least that the model page asks for, as far as there is room: the longer, the better they are driven.
LONG_BLENDS = (2.0, 1.5)
#: Slope from which tight turns, of radii below two contact lengths, need blends of as much. [rad]
STEEP = math.radians(15.0)


@dataclass(frozen=True, slots=True, eq=False)
class DriveModel:
    """What turns a route into commands.

    Attributes
    ----------
    vehicle, terrain
        Profiles.
    field
        Slope of the map.
    obstacles
        What the footprint must not touch.
    ahead, behind
        The vehicle, and as it is when turned round to drive backwards.
    pace, slips
        Speeds and slips of steady turns as the search's kernels read them.
    sharpest
        Largest curvature. [1/m]
    spot
        How it turns on the spot; None: it cannot.
    more_slip
        Slip over that of the steady turns, at most, where it is more than `MOST_SLIP`.
    """

    vehicle: VehicleProfile
    terrain: TerrainProfile
    field: SlopeField
    obstacles: Obstacles
    ahead: Scene
    behind: Scene
    pace: Ground
    slips: Ground
    sharpest: float
    spot: SpotDrive | None
    more_slip: float = MORE_SLIP


class UndrivableError(Exception):
    """A route cannot be driven; says why."""


class SlippingError(UndrivableError):
    """A route asks for too much slip, and for nothing else that cannot be."""


def turned_round(vehicle: VehicleProfile) -> VehicleProfile:
    """The vehicle with its rear in front."""
    footprint = tuple((-x, -y) for x, y in vehicle.footprint)
    return replace(vehicle, cog_forward=-vehicle.cog_forward, cog_left=-vehicle.cog_left, footprint=footprint)


def drive_model(
    vehicle: VehicleProfile,
    terrain: TerrainProfile,
    gravity: float,
    field: SlopeField,
    obstacles: Obstacles,
    limits: tuple[SteeringLimits, SteeringLimits | None],
    most_speed: float,
) -> DriveModel:
    """The model of profiles, gravity [m/s2], slopes, obstacles, limits of both gears and a bound of speed. [m/s]"""
    ahead, behind = (scene(each, terrain, gravity, 0.0, 0.0) for each in (vehicle, turned_round(vehicle)))
    pace, slips = (ground_of(field, *limits, cost) for cost in (Cost.TIME, Cost.SLIP))
    sharpest = float(limits[0].curvature[-1])
    spot = spot_drive(ahead, vehicle, most_speed) if pace.is_level else None
    return DriveModel(vehicle, terrain, field, obstacles, ahead, behind, pace, slips, sharpest, spot)


def blend_length(model: DriveModel, slope: float, sharpest: float) -> float:
    """Over which curvature may change on a slope, in turns up to a curvature; see the model page. [m]"""
    length = model.vehicle.contact_length
    if slope >= STEEP and sharpest * 2.0 * length > 1.0:
        return 2.0 * length
    return max(length, 2.0 * length * math.tan(slope) / model.terrain.friction_coefficient)


def slopes_at(model: DriveModel, x: Array, y: Array) -> Array:
    """Slope angle at points of the map; 0 where it is not known. [rad]"""
    g_x, g_y = gradients_along(model.field, x, y)
    return np.asarray(np.arctan(np.nan_to_num(np.hypot(g_x, g_y))))


def checked_step(obstacles: Obstacles) -> float:
    """Between poses that are checked for collisions: small beside a cell and beside the vehicle. [m]"""
    return CHECKED * min(obstacles.resolution, obstacles.footprint.reach)
