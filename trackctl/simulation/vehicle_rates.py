"""Accelerations of a vehicle that slides on a slope plane: what the integrator integrates."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.mechanics.contact import Loads, loads
from trackctl.mechanics.operating_point import OperatingPoint
from trackctl.mechanics.parameters import TrackModel, track_model
from trackctl.mechanics.shear import TrackMotion
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.simulation.contact_memory import Entries, Memory
from trackctl.simulation.graded_quadrature import FEW_NODES, GradedRule, graded_rule
from trackctl.simulation.ground_force import NUMBERS, call_track_force, pack, track_force_there
from trackctl.simulation.shoe_displacement import Frame

Array = NDArray[np.float64]


class Scene(NamedTuple):
    """A vehicle on a slope plane of some terrain.

    Attributes
    ----------
    model
        Vehicle on its terrain.
    gyration_square
        Yaw inertia over mass. [m2]
    slope
        Angle of the plane. [rad]
    uphill_yaw
        Direction of up-slope in the plane, from the x axis. [rad]
    rule, rough_rule
        Quadrature along the tracks, of forces and of what needs them roughly.
    remember
        Whether each shoe's point of entry is kept; else the present motion is taken to have lasted since.
    track_force
        Address of `track_force_there`.
    """

    model: TrackModel
    gyration_square: float
    slope: float
    uphill_yaw: float
    rule: GradedRule
    rough_rule: GradedRule
    remember: bool
    track_force: int


def scene(
    vehicle: VehicleProfile,
    terrain: TerrainProfile,
    gravity: float,
    slope: float,
    uphill_yaw: float = 0.5 * math.pi,
    *,
    remember: bool = True,
) -> Scene:
    """The scene of profiles, gravity [m/s2] and a slope plane [rad]; see `Scene`."""
    model = track_model(vehicle, terrain, gravity)
    inertia = vehicle.yaw_inertia / vehicle.mass
    rules = graded_rule(), graded_rule(FEW_NODES)
    return Scene(model, inertia, slope, uphill_yaw, *rules, remember, track_force_there.address)


@kernel
def roughly(scene: Scene) -> Scene:
    """The scene with forces taken roughly."""
    return Scene(
        scene.model,
        scene.gyration_square,
        scene.slope,
        scene.uphill_yaw,
        scene.rough_rule,
        scene.rough_rule,
        scene.remember,
        scene.track_force,
    )


@kernel
def track_loads(scene: Scene, yaw: float, forward_acceleration: float, left_acceleration: float) -> Loads:
    """Loads from the real accelerations of the mass centre, in the body frame. [m/s2]"""
    heading = yaw - scene.uphill_yaw
    down = math.sin(scene.slope)
    apparent = OperatingPoint(
        -down * math.cos(heading) - forward_acceleration / scene.model.gravity,
        down * math.sin(heading) - left_acceleration / scene.model.gravity,
        math.cos(scene.slope),
        0.0,
        0.0,
    )
    return loads(scene.model, apparent, 0.0)


@kernel
def vehicle_rates(
    scene: Scene,
    pose: Array,
    velocity: Array,
    rate: Array,
    speed_left: float,
    speed_right: float,
    memory: Memory,
    entries: Entries,
    result: Array,
) -> None:
    """Rates of the body's velocities.

    m (dv_x/dt - r v_y) = F_x + m g_x, m (dv_y/dt + r v_x) = F_y + m g_y and I_z dr/dt = M, with the loads that the
    rates handed in make: a solution is where they are those that come out.

    Parameters
    ----------
    scene
        Vehicle on the slope.
    pose
        x, y of the mass centre [m] and yaw [rad], shape (3,).
    velocity
        Forward and lateral velocity [m/s] and yaw rate [rad/s], shape (3,).
    rate
        Their derivatives by time, for the loads. [m/s2, m/s2, rad/s2]
    speed_left, speed_right
        Of the tracks. [m/s]
    memory, entries
        Of the two tracks, shapes (2,) and (2, n).
    result
        The derivatives that the forces give, shape (3,).
    """
    model = scene.model
    v_x, v_y, r = velocity[0], velocity[1], velocity[2]
    weighing = track_loads(scene, pose[2], rate[0] - r * v_y, rate[1] + r * v_x)
    cos_yaw, sin_yaw = math.cos(pose[2]), math.sin(pose[2])
    heading = pose[2] - scene.uphill_yaw
    F_x = -math.sin(scene.slope) * math.cos(heading)
    F_y = math.sin(scene.slope) * math.sin(heading)
    M = 0.0
    numbers, found = np.empty(NUMBERS), np.empty(3)
    for track in range(2):
        arm = (0.5 - track) * model.gauge - model.cog_left
        speed = speed_left if track == 0 else speed_right
        motion = TrackMotion(speed, v_x - r * arm, 0.0, v_y - r * model.cog_forward, 0.0, r)
        frame = Frame(
            pose[0] - model.cog_forward * cos_yaw - arm * sin_yaw,
            pose[1] - model.cog_forward * sin_yaw + arm * cos_yaw,
            cos_yaw,
            sin_yaw,
        )
        load = weighing.left if track == 0 else weighing.right
        pack(numbers, model, load, weighing.pressure_centre, motion, frame)
        call_track_force(
            scene.track_force,
            numbers.ctypes,
            scene.rule.nodes.ctypes,
            scene.rule.weights.ctypes,
            scene.rule.nodes.size,
            int(scene.remember),
            memory.ctypes,
            entries.ctypes,
            entries.shape[1],
            track,
            found.ctypes,
        )
        F_x += found[0]
        F_y += found[1]
        M += found[2] - model.cog_forward * found[1] - arm * found[0]
    result[0] = model.gravity * F_x + r * v_y
    result[1] = model.gravity * F_y - r * v_x
    result[2] = model.gravity * M / scene.gyration_square
