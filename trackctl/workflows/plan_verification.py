"""Whether a vehicle that is fed a plan's sprocket rates drives it: simulation with the memory of its contact."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.planning.clearance import least_clearance
from trackctl.planning.collision import Obstacles
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.simulation.following import Feedback, deviation, follow
from trackctl.simulation.motion import End, State, sample
from trackctl.simulation.slopes import Slopes
from trackctl.simulation.track_speeds import TrackSpeeds
from trackctl.simulation.vehicle_rates import scene
from trackctl.workflows.drive_commands import Target, target_commands
from trackctl.workflows.plan_rows import Rows
from trackctl.workflows.unrolled_ground import PlannedGround, Unrolled, unrolled

Array = NDArray[np.float64]

TOLERANCE = 1e-5
#: Between poses that are compared and checked. [s]
INTERVAL = 0.01


@dataclass(frozen=True, slots=True)
class Verification:
    """What a simulation of a plan comes to.

    Attributes
    ----------
    max_deviation
        Largest distance of the mass centre from the plan; NaN if the simulation has ended early. [m]
    min_clearance
        Least distance of the footprint from blocked cells. [m]
    collision
        Whether the footprint touches one.
    problem
        Why the simulation has ended early, empty if it has not.
    """

    max_deviation: float
    min_clearance: float
    collision: bool
    problem: str


def planned_ground(rows: Rows) -> PlannedGround:
    """The ground under a plan's rows."""
    return PlannedGround(
        rows.time,
        rows.x,
        rows.y,
        np.unwrap(rows.yaw),
        rows.velocity,
        rows.curvature,
        rows.slope,
        rows.heading,
        rows.sideslip,
    )


def verify(
    rows: Rows,
    vehicle: VehicleProfile,
    terrain: TerrainProfile,
    gravity: float,
    obstacles: Obstacles,
    feedback: Feedback = Feedback.NONE,
) -> Verification:
    """Simulate a plan's rows and look where the vehicle gets.

    Parameters
    ----------
    rows
        The plan.
    vehicle, terrain, gravity
        [m/s2]
    obstacles
        Of the map.
    feedback
        What is fed back.
    """
    ground = planned_ground(rows)
    uphill = float(rows.yaw[0] - rows.heading[0])
    surroundings = scene(vehicle, terrain, gravity, float(rows.slope[0]), uphill)
    flat = None if ground.is_plane else unrolled(ground)
    pose = (rows.x, rows.y, ground.yaw) if flat is None else (flat.x, flat.y, flat.yaw)
    speeds = TrackSpeeds(rows.time, vehicle.sprocket_radius * rows.rate_left, vehicle.sprocket_radius * rows.rate_right)
    commands = target_commands(Target(rows.time, *pose, rows.sideslip, rows.velocity), speeds)
    start = State(*(float(values[0]) for values in pose))
    slopes: Slopes | None = None if flat is None else flat.slopes
    simulation, end = follow(surroundings, commands, feedback, start, TOLERANCE, steady_start=False, slopes=slopes)
    count = math.ceil((simulation.time - rows.time[0]) / INTERVAL)
    time = np.linspace(rows.time[0], simulation.time, count + 1)
    motion = sample(simulation, vehicle.mass, time)
    x, y, yaw = on_the_map(flat, time, motion.x, motion.y, motion.yaw)
    clearance = least_clearance(obstacles, x, y, yaw)
    done = end is End.DONE
    away = float(deviation(rows.path, x, y).max())
    return Verification(away, clearance, clearance <= 0.0, "" if done else end.name.lower())


def on_the_map(flat: Unrolled | None, time: Array, x: Array, y: Array, yaw: Array) -> tuple[Array, Array, Array]:
    """Simulated poses on the map."""
    return (x, y, yaw) if flat is None else flat.to_map(time, x, y, yaw)
