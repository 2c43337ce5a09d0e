"""Turns on the spot on level ground: track speeds that turn the body by an angle, from rest to rest.

The tracks run against each other at one speed, which rises and falls at a constant rate. The mass centre, over the
centre of the contact, stays where it is by symmetry. How far the body turns depends on slip: it is taken from the
simulation with the memory of the contact, since the shoes travel hardly more than a contact length, and no turn is
steady.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.mechanics.parameters import TrackModel
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.simulation.motion import End, Motion, State, sample, simulate
from trackctl.simulation.track_speeds import TrackSpeeds
from trackctl.simulation.vehicle_rates import Scene

Array = NDArray[np.float64]

#: Acceleration of the ends of the contact towards the centre, at most, over gravity.
CENTRIPETAL = 0.1
#: Limits are kept with this share, so that rounding does not exceed them.
SHARE = 0.97
#: Standstill after the tracks have stopped, in which the body comes to rest. [s]
REST = 0.2
#: Between samples of a turn. [s]
INTERVAL = 0.05
TOLERANCE, ANGLE_ERROR = 1e-6, 1e-6
#: Travel of a track over that without slip, at most: beyond, the tracks spin more than they turn the body.
MOST_TRAVEL = 4.0
BISECTIONS = 60


@dataclass(frozen=True, slots=True)
class SpotDrive:
    """Speed [m/s] that tracks may have in a turn on the spot, and its rate. [m/s2]"""

    speed: float
    acceleration: float


@dataclass(frozen=True, slots=True, eq=False)
class SpotTurn:
    """A turn on the spot, arrays of shape (n,).

    Attributes
    ----------
    time
        From 0. [s]
    track_speed_left, track_speed_right
        Linear between samples. [m/s]
    yaw
        From 0. [rad]
    yaw_rate
        [rad/s]
    slip_left, slip_right
        Of the tracks. [-]
    """

    time: Array
    track_speed_left: Array
    track_speed_right: Array
    yaw: Array
    yaw_rate: Array
    slip_left: Array
    slip_right: Array


def spot_drive(scene: Scene, vehicle: VehicleProfile, most_speed: float) -> SpotDrive | None:
    """How a vehicle may turn on the spot; None where it cannot.

    It can where its mass centre lies over the centre of the contact, its profile bounds no radius, and its drive gives
    what the turn takes at most: mu W L/4 for the moment of friction across the tracks, and motion resistance.

    Parameters
    ----------
    scene
        Vehicle on level ground.
    vehicle
        Its profile, for the limits.
    most_speed
        Upper bound of track speeds. [m/s]
    """
    model = scene.model
    if vehicle.min_turn_radius is not None or model.cog_forward != 0.0 or model.cog_left != 0.0:
        return None
    strength = full_friction(model)
    if strength <= model.resistance:
        return None
    force = vehicle.mass * model.gravity * (strength * model.length / (4.0 * model.gauge) + 0.5 * model.resistance)
    if vehicle.max_track_force is not None and force > SHARE * vehicle.max_track_force:
        return None
    swung = 0.5 * model.gauge * math.sqrt(2.0 * CENTRIPETAL * model.gravity / model.length)
    by_drive = vehicle.max_sprocket_rate * vehicle.sprocket_radius
    gain = vehicle.max_sprocket_acceleration * vehicle.sprocket_radius
    speed = min(SHARE * vehicle.max_speed, SHARE * most_speed, SHARE * by_drive, swung)
    return SpotDrive(speed, SHARE * min(vehicle.max_acceleration, gain))


def full_friction(model: TrackModel) -> float:
    """What the ground holds against sliding, over the weight. [-]"""
    return model.friction + 2.0 * model.adhesion * model.length


def spot_rate(model: TrackModel, drive: SpotDrive) -> float:
    """Yaw rate of a turn on stiff ground, which others fall short of. [rad/s]

    Every point of a track slides, along it by e and across it by r x, against full friction mu. With a = e/r the turn
    is driven by (B/2) (2 a asinh(L/(2 a)) - f_r L/mu) and held by (L/2) sqrt(L^2/4 + a^2) - a^2 asinh(L/(2 a)); where
    they are one, r = V/(B/2 + a).
    """
    half, B = 0.5 * model.length, model.gauge
    held = model.resistance / full_friction(model)
    low, high = 0.0, half * (1.0 + half / B) / (1.0 - held)
    for _ in range(BISECTIONS):
        a = 0.5 * (low + high)
        reach = math.asinh(half / a)
        is_driven = 0.5 * B * (2.0 * a * reach - 2.0 * held * half) > half * math.hypot(half, a) - a * a * reach
        low, high = (low, a) if is_driven else (a, high)
    return drive.speed / (0.5 * B + a)


def spot_turn(scene: Scene, drive: SpotDrive, angle: float) -> SpotTurn | None:
    """A turn by an angle [rad], from rest; None where the tracks spin more than they turn the body.

    Parameters
    ----------
    scene
        Vehicle on level ground, its mass centre over the centre of the contact.
    drive
        How its tracks may run.
    angle
        Left positive. [rad]
    """
    from scipy.optimize import root_scalar

    sense, size = math.copysign(1.0, angle), abs(angle)
    without_slip = 0.5 * scene.model.gauge * size

    def missing(travel: float) -> float:
        return float(_turned(scene, drive, travel, sense)[1].yaw[-1]) - sense * size

    if sense * missing(MOST_TRAVEL * without_slip) < 0.0:
        return None
    bracket = (0.5 * without_slip, MOST_TRAVEL * without_slip)
    travel = root_scalar(missing, bracket=bracket, method="brentq", xtol=ANGLE_ERROR * scene.model.gauge, rtol=1e-12)
    speeds, motion = _turned(scene, drive, float(travel.root), sense)
    left, right = (np.interp(motion.time, speeds.time, values) for values in (speeds.left, speeds.right))
    # At rest slip is the quotient of rounding errors.
    slips = (np.where(left == 0.0, 0.0, slip) for slip in (motion.slip_left, motion.slip_right))
    return SpotTurn(motion.time, left, right, motion.yaw, motion.yaw_rate, *slips)


def _turned(scene: Scene, drive: SpotDrive, travel: float, sense: float) -> tuple[TrackSpeeds, Motion]:
    """Track speeds of a travel [m] of either track, and the motion that they make."""
    speeds = _trapezoid(drive, travel, sense)
    simulation, end = simulate(scene, speeds, State(), TOLERANCE)
    if end is not End.DONE:
        raise RuntimeError(f"the simulation of a turn on the spot has ended early: {end.name.lower()}")
    end_time = float(speeds.time[-1])
    time = np.union1d(speeds.time, np.linspace(0.0, end_time, math.ceil(end_time / INTERVAL) + 1))
    return speeds, sample(simulation, 1.0, time)


def _trapezoid(drive: SpotDrive, travel: float, sense: float) -> TrackSpeeds:
    """Speeds that rise, last where the travel is long enough, fall, and rest."""
    speed = min(drive.speed, math.sqrt(drive.acceleration * travel))
    rise = speed / drive.acceleration
    lasting = [(travel / speed - rise, speed)] if speed == drive.speed else []
    steps, sizes = zip(*[(0.0, 0.0), (rise, speed), *lasting, (rise, 0.0), (REST, 0.0)], strict=True)
    speeds = sense * np.array(sizes)
    return TrackSpeeds(np.cumsum(steps), -speeds, speeds)
