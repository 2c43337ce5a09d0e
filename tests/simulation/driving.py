"""Vehicles, paths and runs that the tests of the simulation share."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.mechanics.parameters import STANDARD_GRAVITY
from trackctl.simulation.following import Feedback, deviation, follow, start_on
from trackctl.simulation.motion import State, simulate
from trackctl.simulation.path import circle, path_of_curvature
from trackctl.simulation.track_speeds import TrackSpeeds, constant_speeds
from trackctl.simulation.vehicle_rates import scene

SMALL, ASPHALT = load_vehicle("utv-61cm"), load_terrain("asphalt")
BIG = load_vehicle("carrier-13t6")
BIG_GROUND = replace(load_terrain("hard-soil"), friction_coefficient=0.6, shear_deformation_modulus=0.025)
#: Vehicle, ground, radius [m] and speed [m/s] of the two that the path rule's table speaks of.
SIZES = {"small": (SMALL, ASPHALT, 2.0, 2.0 / 3.6), "big": (BIG, BIG_GROUND, 8.0, 2.0)}
TOLERANCE = 1e-6


def slope_scene(degrees, vehicle=SMALL, terrain=ASPHALT, uphill_yaw=0.5 * math.pi, remember=True):
    return scene(vehicle, terrain, STANDARD_GRAVITY, math.radians(degrees), uphill_yaw, remember=remember)


def drive(ground, left, right, duration, start=None, tolerance=TOLERANCE, **options):
    """Constant speeds, from rest at the origin."""
    speeds = constant_speeds(left, right, duration)
    return simulate(ground, speeds, start or State(), tolerance, **options)


def drive_along(ground, time, left, right, start=None, tolerance=TOLERANCE):
    speeds = TrackSpeeds(*(np.array(values, dtype=float) for values in (time, left, right)))
    return simulate(ground, speeds, start or State(), tolerance)


def velocity(simulation):
    return simulation.run["velocity"][0].copy()


def deviation_percent(ground, commands, path):
    """Largest distance from a path that is driven open loop, in percent of its length."""
    simulation, _ = follow(ground, commands, Feedback.NONE, start_on(commands), TOLERANCE, steady_start=True)
    places = simulation.steps["pose"][: simulation.count]
    return 100.0 * deviation(path, places[..., 0].ravel(), places[..., 1].ravel()).max() / path.length


def lap(size):
    _, _, radius, speed = SIZES[size]
    return circle(radius, speed, 1.0, (0.0, 0.0, 0.0))


def traverse(size):
    """Twenty contact lengths straight across the slope."""
    vehicle, _, _, speed = SIZES[size]
    s = np.linspace(0.0, 20.0 * vehicle.contact_length, 961)
    return path_of_curvature(s, 0.0 * s, np.full_like(s, speed), (0.0, 0.0, 0.0))


def s_curve(size):
    """One wave of curvature."""
    _, _, radius, speed = SIZES[size]
    sharpest, length, yaw = (
        (1.5 * radius, 3.0 * math.pi * radius, 0.25 * math.pi)
        if size == "small"
        else (radius, 3.0 * math.pi * radius, 0.0)
    )
    s = np.linspace(0.0, length, 1201)
    return path_of_curvature(s, np.sin(2.0 * math.pi * s / length) / sharpest, np.full_like(s, speed), (0.0, 0.0, yaw))


def speed_ramp(size):
    """A circle with 0.5 m/s2 from 0.4 to 1.2 m/s on the way."""
    _, _, radius, _ = SIZES[size]
    s = np.linspace(0.0, 2.0 * math.pi * radius, 761)
    speed = np.sqrt(np.clip(0.4**2 + 2.0 * 0.5 * (s - 3.0), 0.4**2, 1.2**2))
    return path_of_curvature(s, np.full_like(s, 1.0 / radius), speed, (0.0, 0.0, 0.0))


def blended_arcs(size):
    """Half a turn, a straight, half a turn, with blends of one contact length."""
    vehicle, _, radius, speed = SIZES[size]
    length = vehicle.contact_length
    ends = np.cumsum([0.0, math.pi * radius, length, 3.0 * length, length, math.pi * radius])
    s = np.arange(0.0, ends[-1], length / 48.0)
    curvature = np.interp(s, ends, np.array([1.0, 1.0, 0.0, 0.0, 1.0, 1.0]) / radius)
    return path_of_curvature(s, curvature, np.full_like(s, speed), (0.0, 0.0, 0.0))
