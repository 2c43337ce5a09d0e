"""Vehicles on slopes that several tests share, as the oracle's points, and what the package makes of them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from oracle import OraclePoint

from trackctl.mechanics.equilibrium import balance
from trackctl.mechanics.operating_point import OperatingPoint, operating_point
from trackctl.mechanics.parameters import TrackModel, track_model
from trackctl.mechanics.quadrature import Rule, rules
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile

Array = NDArray[np.float64]

ADAPTIVE = rules()
REFERENCE = rules((48,))

# The worked example of the model's description: two roots at 4 m/s, none at 4.2 m/s.
DOCUMENTED = OraclePoint(
    mass=3400,
    gauge=1.72,
    width=0.34,
    length=2.35,
    cog_height=0.72,
    cog_forward=0.11,
    cog_left=-0.06,
    friction=0.52,
    shear_modulus=0.018,
    cohesion=1600,
    resistance=0.09,
    gravity=9.80665,
    slope=math.radians(16),
    velocity=4.0,
    curvature=0.25,
    heading=math.radians(30),
)
# A small symmetric vehicle on firm ground.
SMALL = OraclePoint(
    mass=120,
    gauge=0.61,
    width=0.15,
    length=0.8,
    cog_height=0.25,
    cog_forward=0,
    cog_left=0,
    friction=0.8,
    shear_modulus=0.01,
    cohesion=0,
    resistance=0.04,
    gravity=9.80665,
    slope=math.radians(12.13),
    velocity=0.4,
    curvature=1 / 0.948,
    heading=0.3,
)
SLOW = replace(DOCUMENTED, velocity=2.0, heading=2.0)
VARIETY = {
    "offset mass, cohesion": SLOW,
    "front loaded": replace(SLOW, cog_forward=0.3, heading=3.1, slope=0.3),
    "rear loaded": replace(SLOW, cog_forward=-0.3, heading=0.1, slope=0.3),
    "right turn": replace(SLOW, curvature=-0.4),
    "straight": replace(SLOW, curvature=0.0),
    "nearly straight": replace(SLOW, curvature=1e-7),
    "no cohesion": replace(SMALL, heading=-1.5),
    "tight": replace(SMALL, curvature=1.5),
    "tight right turn": replace(SMALL, curvature=-1.5),
    "level": replace(SMALL, slope=0.0),
}


def model_of(point: OraclePoint) -> TrackModel:
    """The package's model of a point's vehicle and terrain."""
    vehicle = VehicleProfile(
        name="case",
        description="",
        source="",
        mass=point.mass,
        yaw_inertia=point.mass,
        track_gauge=point.gauge,
        track_width=point.width,
        contact_length=point.length,
        cog_height=point.cog_height,
        cog_forward=point.cog_forward,
        cog_left=point.cog_left,
        sprocket_radius=0.1,
        max_speed=20.0,
        max_acceleration=1.0,
        max_sprocket_rate=100.0,
        max_sprocket_acceleration=100.0,
        footprint=((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)),
    )
    terrain = TerrainProfile(
        name="case",
        description="",
        source="",
        friction_coefficient=point.friction,
        shear_deformation_modulus=point.shear_modulus,
        cohesion=point.cohesion,
        motion_resistance_coefficient=point.resistance,
    )
    return track_model(vehicle, terrain, point.gravity)


def operating_point_of(point: OraclePoint) -> OperatingPoint:
    """The package's operating point."""
    return operating_point(model_of(point), point.slope, point.velocity, point.curvature, point.heading)


def row_of(point: OraclePoint) -> list[float]:
    """Slope, velocity, curvature and heading: a row of `solve_points`."""
    return [point.slope, point.velocity, point.curvature, point.heading]


def evaluate(point: OraclePoint, unknowns: Array, rule: Rule = ADAPTIVE) -> tuple[Array, Array, Array]:
    """Residual, Jacobian and traction of the package's balance."""
    residual, jacobian, traction = np.empty(3), np.empty((3, 3)), np.empty(2)
    unknowns = np.asarray(unknowns, dtype=np.float64)
    balance(model_of(point), operating_point_of(point), rule, unknowns, residual, jacobian, traction, True)
    return residual, jacobian, traction


def no_slip(point: OraclePoint) -> Array:
    """Unknowns of rolling without slip, speeds no lower than a fifth of the vehicle's."""
    arms = 0.5 * point.gauge * np.array([1.0, -1.0]) - point.cog_left
    return np.append(np.maximum(1.0 - point.curvature * arms, 0.2), 0.0)


def random_points(number: int, seed: int) -> list[OraclePoint]:
    """Vehicles from toy to tank on all kinds of ground, slopes and turns, both ways; a few of them straight."""
    generator = np.random.default_rng(seed)
    return [random_point(generator) for _ in range(number)]


def random_point(generator: np.random.Generator) -> OraclePoint:
    """One of `random_points`: speeds up to the grip limit of level ground."""
    draw = generator.uniform
    gauge = draw(0.4, 3.0)
    length = gauge * draw(0.7, 1.8)
    friction = draw(0.25, 1.0)
    radius = gauge * draw(0.6, 1.0) * 10.0 ** draw(0.0, 1.7)
    straight = draw() < 0.05
    off_centre = generator.integers(0, 2, 2)
    return OraclePoint(
        mass=200.0 * gauge**3 * draw(0.5, 6.0),
        gauge=gauge,
        width=0.15 * gauge,
        length=length,
        cog_height=gauge * draw(0.0, 0.7),
        cog_forward=float(off_centre[0]) * length * draw(-0.12, 0.12),
        cog_left=float(off_centre[1]) * gauge * draw(-0.1, 0.1),
        friction=friction,
        shear_modulus=draw(0.003, 0.03),
        cohesion=float(generator.choice([0.0, 0.0, 1000.0, 4000.0])),
        resistance=draw(0.02, 0.15),
        gravity=9.80665,
        slope=draw(0.0, 0.6),
        velocity=draw(0.05, 1.05) * math.sqrt(friction * 9.80665 * radius),
        curvature=0.0 if straight else float(generator.choice([-1.0, 1.0])) / radius,
        heading=draw(0.0, 2.0 * math.pi),
    )
