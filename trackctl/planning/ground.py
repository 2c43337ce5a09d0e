"""What a metre of path costs, and how the body lies across it, at a place, curvature and direction of motion."""

from __future__ import annotations

import math
from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.planning.pose import wrapped
from trackctl.planning.slope_field import SlopeField, gradient_at
from trackctl.planning.steering_limits import SteeringLimits

Array = NDArray[np.float64]

FULL_CIRCLE = 2.0 * math.pi
#: Share of the mean rate that every metre costs on top of work or slip, which may vanish: ties go to the shorter way.
LENGTH_SHARE = 1e-3
#: How far outside an axis still counts as on its end: rounding of radii and angles.
SLACK = 1e-9
#: Sideslip and direction settle within so many rounds: each shrinks the error by the table's slope in direction.
ROUNDS = 30


class Cost(Enum):
    """What a search minimises."""

    TIME = "time"
    LENGTH = "length"
    ENERGY = "energy"
    SLIP = "slip"


class Motion(NamedTuple):
    """Cost and sideslip of driving, for kernels; tables of shape (n_slope, n_curvature, n_direction).

    Attributes
    ----------
    slope, curvature
        Axes as of `SteeringLimits`.
    rate
        Cost of a metre, infinite where the vehicle cannot drive.
    sideslip
        tangent - yaw of the body. [rad]
    least_rate
        Smallest of the table.
    turning
        Largest size of d sideslip / d direction in the table. [-]
    """

    slope: Array
    curvature: Array
    rate: Array
    sideslip: Array
    least_rate: float
    turning: float


class Ground(NamedTuple):
    """Slope of a map and what driving on it costs, for kernels.

    Attributes
    ----------
    field
        The slope.
    forward, backward
        Driving in either gear; without a reverse gear nothing of `backward` is feasible.
    is_level
        Whether slope and direction matter nowhere, so that one sample tells all of an arc.
    """

    field: SlopeField
    forward: Motion
    backward: Motion
    is_level: bool


def motion_of(limits: SteeringLimits, cost: Cost) -> Motion:
    """Table of the cost of a metre.

    Parameters
    ----------
    limits
        Of one gear.
    cost
        What counts: 1/speed [s/m], 1, work [J/m] or slip [-].
    """
    feasible = limits.speed > 0.0
    rate = _feasible_rates(limits, cost)
    sideslip = np.where(feasible, limits.sideslip, 0.0)
    return Motion(
        slope=np.array(limits.slope, dtype=np.float64),
        curvature=np.array(limits.curvature, dtype=np.float64),
        rate=np.ascontiguousarray(rate),
        sideslip=np.ascontiguousarray(sideslip),
        least_rate=float(rate.min()),
        turning=_steepest(sideslip, feasible),
    )


def cost_of_a_second(limits: SteeringLimits, cost: Cost) -> float:
    """What driving for a second costs, the mean over all turns that are feasible; 1 where there is none."""
    feasible = limits.speed > 0.0
    if cost is Cost.TIME or not feasible.any():
        return 1.0
    return float((_feasible_rates(limits, cost) * limits.speed)[feasible].mean())


def _feasible_rates(limits: SteeringLimits, cost: Cost) -> Array:
    """Cost of a metre, infinite where the vehicle cannot drive."""
    feasible = limits.speed > 0.0
    rate = np.where(feasible, _rates(limits, cost), np.inf)
    if cost in (Cost.ENERGY, Cost.SLIP) and feasible.any():
        rate += LENGTH_SHARE * max(float(rate[feasible].mean()), 1e-9)
    return rate


def _rates(limits: SteeringLimits, cost: Cost) -> Array:
    match cost:
        case Cost.TIME:
            with np.errstate(divide="ignore"):
                return 1.0 / limits.speed
        case Cost.LENGTH:
            return np.ones_like(limits.speed)
        case Cost.ENERGY:
            return np.maximum(limits.work, 0.0)
        case Cost.SLIP:
            return np.abs(limits.slip)


def _steepest(sideslip: Array, feasible: NDArray[np.bool_]) -> float:
    """Largest change of sideslip over change of direction between neighbours that are both feasible."""
    both = feasible & np.roll(feasible, -1, axis=2)
    change = np.abs(np.roll(sideslip, -1, axis=2) - sideslip)[both]
    steepest: float = change.max(initial=0.0) * sideslip.shape[2] / FULL_CIRCLE
    return steepest


def without_gear(motion: Motion) -> Motion:
    """The same tables with nothing feasible."""
    return motion._replace(rate=np.full_like(motion.rate, np.inf), least_rate=math.inf)


def ground_of(field: SlopeField, forward: SteeringLimits, backward: SteeringLimits | None, cost: Cost) -> Ground:
    """Slope and costs for the kernels.

    Parameters
    ----------
    field
        The slope over the map.
    forward, backward
        Limits of each gear; None: forward only.
    cost
        What to minimise.
    """
    ahead = motion_of(forward, cost)
    behind = without_gear(ahead) if backward is None else motion_of(backward, cost)
    # Copies, since a locked array is of another type to the kernels.
    nodes = (np.array(field.gradient_x, np.float64), np.array(field.gradient_y, np.float64))
    plane = nodes[0].size == 1
    is_level = plane and not np.any(nodes) and all(_has_no_direction(motion) for motion in (ahead, behind))
    slopes = SlopeField(*nodes, *map(float, field[2:]))
    return Ground(slopes, ahead, behind, is_level)


def gear_motion(ground: Ground, gear: int) -> Motion:
    """Driving in a gear: backwards in -1, else forwards."""
    return ground.backward if gear < 0 else ground.forward


def _has_no_direction(motion: Motion) -> bool:
    return all(bool((table == table[:, :, :1]).all()) for table in (motion.rate, motion.sideslip))


@kernel
def _stretch(axis: Array, at: float) -> tuple[int, float]:
    """Node before a value and the share of the way to the next; a node of -1 outside the axis."""
    last = axis.size - 1
    if at < axis[0] - SLACK or at > axis[last] + SLACK:
        return -1, 0.0
    if last == 0 or at <= axis[0]:
        return 0, 0.0
    low, high = 0, last
    while high - low > 1:
        middle = (low + high) // 2
        if axis[middle] <= at:
            low = middle
        else:
            high = middle
    return low, min(1.0, (at - axis[low]) / (axis[high] - axis[low]))


@inlined
def slope_at(field: SlopeField, x: float, y: float) -> tuple[float, float]:
    """Angle of the slope and direction of up-slope in the world; NaN where the ground is not known. [rad]"""
    gradient_x, gradient_y = gradient_at(field, x, y)
    return math.atan(math.hypot(gradient_x, gradient_y)), math.atan2(gradient_y, gradient_x)


@kernel
def rate_and_sideslip(motion: Motion, slope: float, curvature: float, direction: float) -> tuple[float, float]:
    """Cost of a metre and sideslip, linear between nodes.

    Parameters
    ----------
    motion
        The gear's tables.
    slope
        Of the ground, not NaN. [rad]
    curvature
        Left positive. [1/m]
    direction
        Of the tangent from up-slope. [rad]

    Returns
    -------
    tuple
        Infinite cost outside the axes and next to an infeasible node. [1/m], [rad]
    """
    i, up = _stretch(motion.slope, slope)
    j, along = _stretch(motion.curvature, curvature)
    if i < 0 or j < 0:
        return np.inf, 0.0
    n_direction = motion.rate.shape[2]
    turns = direction / FULL_CIRCLE
    position = (turns - math.floor(turns)) * n_direction
    k = min(int(position), n_direction - 1)
    rate, sideslip = 0.0, 0.0
    for a in range(2):
        for b in range(2):
            for c in range(2):
                weight = (up if a else 1.0 - up) * (along if b else 1.0 - along)
                weight *= position - k if c else 1.0 - (position - k)
                if weight > SLACK:
                    behind = (k + c) % n_direction
                    rate += weight * motion.rate[i + a, j + b, behind]
                    sideslip += weight * motion.sideslip[i + a, j + b, behind]
    return rate, sideslip


@kernel
def rate_at(
    ground: Ground, motion: Motion, x: float, y: float, tangent: float, curvature: float
) -> tuple[float, float]:
    """Cost of a metre and sideslip at a pose of the path; infinite where the ground is not known. [1/m], [rad]"""
    slope, uphill = slope_at(ground.field, x, y)
    if math.isnan(slope):
        return np.inf, 0.0
    return rate_and_sideslip(motion, slope, curvature, tangent - uphill)


@kernel
def straight_tangent(ground: Ground, motion: Motion, x: float, y: float, yaw: float) -> float:
    """Tangent of straight driving at a body's heading: tangent = yaw + sideslip(tangent). [rad]"""
    tangent = yaw
    for _ in range(ROUNDS):
        rate, sideslip = rate_at(ground, motion, x, y, tangent, 0.0)
        if rate == np.inf or abs(yaw + sideslip - tangent) < 1e-15:
            break
        tangent = yaw + sideslip
    return wrapped(tangent)
