"""Motion on level ground under given track forces, with the saturated lateral friction of Shiller et al.

Lateral friction is Coulomb's, spread evenly along both tracks, so that it needs neither shear displacement nor track
speeds.

References
----------
.. [1] Shiller, Serate, Hua, Trajectory planning of tracked vehicles, 1993.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from trackctl.simulation.motion import State

Array = NDArray[np.float64]

#: Yaw rate below which the friction moment has not settled its direction. [rad/s]
YAW_RATE_FLOOR = 1e-6
#: Absolute tolerance over the relative one, in metres, radians and their rates.
ABSOLUTE_TOLERANCE = 1e-2


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionVehicle:
    """A vehicle as the friction law sees it.

    Attributes
    ----------
    mass, yaw_inertia
        [kg], [kg m2]
    track_gauge, contact_length
        [m]
    lateral_friction
        mu_t. [-]
    gravity
        [m/s2]
    yaw_rate_floor
        Regularises |r| to sqrt(r^2 + floor^2). [rad/s]
    """

    mass: float
    yaw_inertia: float
    track_gauge: float
    contact_length: float
    lateral_friction: float
    gravity: float
    yaw_rate_floor: float = YAW_RATE_FLOOR


@dataclass(frozen=True, slots=True, eq=False)
class TrackForces:
    """Forward forces of the left and right track over time, linear between samples, shape (n,). [s, N]"""

    time: Array
    left: Array
    right: Array


@dataclass(frozen=True, slots=True, eq=False)
class ForcedMotion:
    """Samples of a motion, arrays of shape (n,): pose of the mass centre, velocities in the body frame."""

    time: Array
    x: Array
    y: Array
    yaw: Array
    forward_velocity: Array
    lateral_velocity: Array
    yaw_rate: Array


def friction(vehicle: FrictionVehicle, lateral_velocity: float, yaw_rate: float) -> tuple[float, float]:
    """Lateral friction force [N] and friction moment [N m] of both tracks.

    F_t = -2 mu_t w L v_y / max(|v_y|, |r| L/2) and M = -sign(r) 2 mu_t w (L^2/4 - D^2), with D = -v_y / r kept within
    the contact and w = m g / (2 L).
    """
    half = 0.5 * vehicle.contact_length
    strength = vehicle.lateral_friction * vehicle.mass * vehicle.gravity / vehicle.contact_length
    turning = math.hypot(yaw_rate, vehicle.yaw_rate_floor)
    force = -strength * vehicle.contact_length * lateral_velocity / max(abs(lateral_velocity), turning * half)
    centre = min(abs(lateral_velocity) / turning, half)
    return force, -yaw_rate / turning * strength * (half * half - centre * centre)


def drive_by_forces(
    vehicle: FrictionVehicle, forces: TrackForces, start: State, time: Array, tolerance: float
) -> ForcedMotion:
    """Integrate the motion under track forces.

    Parameters
    ----------
    vehicle
        What is driven.
    forces
        Of the tracks; the first and last hold outside their times.
    start
        State at the first of the times asked for.
    time
        Where the motion is wanted, ascending. [s]
    tolerance
        Relative tolerance of the integration.
    """

    def rates(t: float, state: Array) -> list[float]:
        _, _, yaw, v_x, v_y, r = state.tolist()
        left, right = np.interp(t, forces.time, forces.left), np.interp(t, forces.time, forces.right)
        lateral, moment = friction(vehicle, v_y, r)
        return [
            v_x * math.cos(yaw) - v_y * math.sin(yaw),
            v_x * math.sin(yaw) + v_y * math.cos(yaw),
            r,
            float(left + right) / vehicle.mass + r * v_y,
            lateral / vehicle.mass - r * v_x,
            (0.5 * vehicle.track_gauge * float(right - left) + moment) / vehicle.yaw_inertia,
        ]

    # No step beyond a sample: the forces have corners there.
    longest = float(np.diff(forces.time).max(initial=0.0)) or math.inf
    solution = solve_ivp(
        rates,
        (time[0], time[-1]),
        (*start.pose, *start.velocity),
        method="LSODA",
        t_eval=time,
        rtol=tolerance,
        atol=ABSOLUTE_TOLERANCE * tolerance,
        max_step=longest,
    )
    x, y, yaw, v_x, v_y, r = solution.y
    return ForcedMotion(time, x, y, yaw, v_x, v_y, r)
