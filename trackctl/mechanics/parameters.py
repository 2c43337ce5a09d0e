"""The constants of the slope-steering model, made dimensionless once."""

from __future__ import annotations

from typing import NamedTuple

from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile

STANDARD_GRAVITY = 9.80665


class TrackModel(NamedTuple):
    """A vehicle on a terrain, forces in units of its weight m g.

    Attributes
    ----------
    gauge, length, cog_height, cog_forward, cog_left
        B, L, h, c_f, c_l of the model. [m]
    friction, resistance
        mu and f_r. [-]
    shear_modulus
        K. [m]
    adhesion
        c b / (m g): strength of the ground along a track that carries no load. [1/m]
    gravity
        [m/s2]
    """

    gauge: float
    length: float
    cog_height: float
    cog_forward: float
    cog_left: float
    friction: float
    resistance: float
    shear_modulus: float
    adhesion: float
    gravity: float


def track_model(vehicle: VehicleProfile, terrain: TerrainProfile, gravity: float = STANDARD_GRAVITY) -> TrackModel:
    """The model's constants for a vehicle on a terrain."""
    return TrackModel(
        gauge=vehicle.track_gauge,
        length=vehicle.contact_length,
        cog_height=vehicle.cog_height,
        cog_forward=vehicle.cog_forward,
        cog_left=vehicle.cog_left,
        friction=terrain.friction_coefficient,
        resistance=terrain.motion_resistance_coefficient,
        shear_modulus=terrain.shear_deformation_modulus,
        adhesion=terrain.cohesion * vehicle.track_width / (vehicle.mass * gravity),
        gravity=gravity,
    )
