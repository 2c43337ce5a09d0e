"""Motion of a planar tracked vehicle under given track forces, with Coulomb friction sideways.

The vehicle of Shiller, Serate and Hua (1993): pressure that is even or, on a slope, grows linearly along the tracks;
sliding friction whose direction follows the sideways velocity of each point of the tracks.
"""

from __future__ import annotations

import math
from bisect import bisect
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.errors import NoAnswerError

Array = NDArray[np.float64]
#: Sum of the track forces, and right minus left, at a time; and rates of a state at a time.
ForcesAt = Callable[[float], tuple[float, float]]
Rates = Callable[[float, Array], tuple[float, ...]]

RELATIVE_TOLERANCE = 1e-10
ABSOLUTE_TOLERANCE = 1e-10
#: Of forces that are linear between samples: the absolute tolerance over the relative one.
ABSOLUTE_SHARE = 1e-2
#: Yaw rate below which the friction moment has not settled its direction, unless a caller knows better. [rad/s]
YAW_RATE_SCALE = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackForceVehicle:
    """A vehicle on level ground or a slope.

    Attributes
    ----------
    mass, yaw_inertia
        [kg], [kg m2]
    gauge, length, cog_height
        Between the track centre lines, of the ground contact, of the mass centre above the ground. [m]
    lateral_friction
        Friction over load, sideways. [1]
    gravity
        [m/s2]
    slope, uphill_yaw
        Angle of the ground, and the yaw of its steepest ascent. [rad]
    yaw_rate_scale
        eps, above 0: friction depends on sqrt(omega^2 + eps^2) in place of abs(omega). [rad/s]
    """

    mass: float
    yaw_inertia: float
    gauge: float
    length: float
    cog_height: float
    lateral_friction: float
    gravity: float
    slope: float = 0.0
    uphill_yaw: float = 0.5 * math.pi
    yaw_rate_scale: float = YAW_RATE_SCALE


class BodyState(NamedTuple):
    """Where a body is and how it moves: numbers, or arrays of shape (n,).

    Attributes
    ----------
    x, y, yaw
        Of the mass centre in the world. [m], [rad]
    forward_velocity, lateral_velocity, yaw_rate
        In the body. [m/s], [rad/s]
    """

    x: float | Array
    y: float | Array
    yaw: float | Array
    forward_velocity: float | Array
    lateral_velocity: float | Array
    yaw_rate: float | Array


@dataclass(frozen=True, slots=True, eq=False)
class ForceHistory:
    """Track forces at times between which they change smoothly, arrays of shape (n,).

    Attributes
    ----------
    time
        Ascending. [s]
    total, difference
        Sum of both tracks, and right minus left. [N]
    """

    time: Array
    total: Array
    difference: Array


@dataclass(frozen=True, slots=True, eq=False)
class TrackForces:
    """Forward forces of the left and right track, linear between samples, arrays of shape (n,).

    Attributes
    ----------
    time
        Ascending. [s]
    left, right
        The first and last hold outside their times. [N]
    """

    time: Array
    left: Array
    right: Array


def drive(vehicle: TrackForceVehicle, start: BodyState, histories: Sequence[ForceHistory]) -> BodyState:
    """Motion under forces, one stretch after the other; they may jump in between.

    Parameters
    ----------
    vehicle
        On its ground.
    start
        At the first time.
    histories
        Of the forces, each from where the last one ends.

    Returns
    -------
    BodyState
        At the times of all histories, in order.

    Raises
    ------
    NoAnswerError
        If the integrator fails.
    """
    state, parts = np.array(start), []
    for history in histories:
        rates = derivative(vehicle, interpolator(history))
        parts.append(integrated(rates, state, history.time, RELATIVE_TOLERANCE, ABSOLUTE_TOLERANCE))
        state = parts[-1][:, -1]
    return BodyState(*np.concatenate(parts, axis=1))


def drive_linear(
    vehicle: TrackForceVehicle, start: BodyState, forces: TrackForces, time: Array, tolerance: float
) -> BodyState:
    """Motion under forces that are linear between samples.

    Parameters
    ----------
    vehicle
        On its ground.
    start
        At the first of the times asked for.
    forces
        Of the tracks.
    time
        Where the motion is wanted, ascending, shape (n,). [s]
    tolerance
        Relative tolerance of the integration; the absolute one is `ABSOLUTE_SHARE` of it. [m, rad and their rates]

    Returns
    -------
    BodyState
        At those times.

    Raises
    ------
    NoAnswerError
        If the integrator fails.
    """
    total, difference = forces.left + forces.right, forces.right - forces.left

    def forces_at(t: float) -> tuple[float, float]:
        return float(np.interp(t, forces.time, total)), float(np.interp(t, forces.time, difference))

    # No step beyond a sample: the forces have corners there.
    longest = float(np.diff(forces.time).max(initial=0.0)) or math.inf
    rates = derivative(vehicle, forces_at)
    return BodyState(*integrated(rates, np.array(start), time, tolerance, ABSOLUTE_SHARE * tolerance, longest))


def integrated(
    rates: Rates, state: Array, time: Array, relative: float, absolute: float, longest: float = math.inf
) -> Array:
    """States at the times, shape (6, n), from that at the first; no step is longer than `longest`. [s]"""
    from scipy.integrate import solve_ivp  # takes its time

    solution = solve_ivp(
        rates,
        (time[0], time[-1]),
        state,
        method="BDF",  # friction that turns round is stiff; LSODA may then not come back
        t_eval=time,
        rtol=relative,
        atol=absolute,
        max_step=longest,
    )
    if not solution.success:
        raise NoAnswerError(f"the simulation stops before {time[-1]:.6g} s: {solution.message}")
    states: Array = solution.y
    return states


def derivative(vehicle: TrackForceVehicle, forces_at: ForcesAt) -> Rates:
    """Right-hand side of the equations of motion, from the sum of the forces and right minus left. [N]

    m (v_x' - omega v_y) = Q + m g_x,  m (v_y' + omega v_x) = F_t + m g_y,  I omega' = dQ b/2 + M.
    """
    pull = vehicle.gravity * math.sin(vehicle.slope)

    def rates(time: float, state: Array) -> tuple[float, ...]:
        _, _, yaw, forward, lateral, yaw_rate = state.tolist()
        total, difference = forces_at(time)
        heading = yaw - vehicle.uphill_yaw
        force, moment = lateral_friction(vehicle, heading, lateral, yaw_rate)
        return (
            forward * math.cos(yaw) - lateral * math.sin(yaw),
            forward * math.sin(yaw) + lateral * math.cos(yaw),
            yaw_rate,
            total / vehicle.mass - pull * math.cos(heading) + yaw_rate * lateral,
            force / vehicle.mass + pull * math.sin(heading) - yaw_rate * forward,
            (0.5 * vehicle.gauge * difference + moment) / vehicle.yaw_inertia,
        )

    return rates


def lateral_friction(
    vehicle: TrackForceVehicle, heading: float, lateral: float, yaw_rate: float
) -> tuple[float, float]:
    """Sideways friction on both tracks and its moment, left positive. [N], [N m]

    A point of a track resists sliding with mu_t times its load. The load per length grows along the track as
    (N/L) (1 + 12 x_p x / L^2), x_p its centre; the sliding changes sides at D = -v_y / omega, D = +-L/2 standing
    for none. `heading` is the yaw from up-slope. [rad]
    """
    half = 0.5 * vehicle.length
    magnitude = math.hypot(yaw_rate, vehicle.yaw_rate_scale)
    sign = yaw_rate / magnitude
    turn = -lateral / max(magnitude * half, abs(lateral))  # D / (L/2), times the sign
    shift = -vehicle.cog_height * math.tan(vehicle.slope) * math.cos(heading) / half  # x_p / (L/2)
    grip = vehicle.lateral_friction * vehicle.mass * vehicle.gravity * math.cos(vehicle.slope)
    force = turn - 1.5 * sign * shift * (1.0 - turn**2)
    moment = 0.5 * half * (1.0 - turn**2 - 2.0 * shift * (sign * turn) ** 3)
    return grip * force, -sign * grip * moment


def interpolator(history: ForceHistory) -> ForcesAt:
    """Both forces of a history at a time, by cubic splines."""
    from scipy.interpolate import CubicSpline  # takes its time

    splines = CubicSpline(history.time, np.stack((history.total, history.difference), axis=1))
    knots: list[float] = splines.x.tolist()
    pieces: Any = splines.c.transpose(1, 2, 0).tolist()

    def forces_at(time: float) -> tuple[float, float]:
        k = min(max(bisect(knots, time) - 1, 0), len(pieces) - 1)
        t = time - knots[k]
        (a, b, c, d), (e, f, g, h) = pieces[k]
        return ((a * t + b) * t + c) * t + d, ((e * t + f) * t + g) * t + h

    return forces_at
