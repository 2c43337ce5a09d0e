"""What a vehicle can do on a slope, read from a look-up table and kept within its profile."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.lut.axes import FULL_CIRCLE
from trackctl.lut.interpolation import Interpolant, LookupResult, interpolant, interpolant_of, look_up
from trackctl.lut.shape_functions import Method
from trackctl.lut.table import Table
from trackctl.planning.steering_limits import SteeringLimits
from trackctl.profiles.vehicle import VehicleProfile

Array = NDArray[np.float64]

#: Directions of motion; an even number, so that every one has its reverse.
DIRECTIONS = 48
#: A speed keeps so far below the slowest node that is infeasible, and a rate or force below the profile's limit.
MARGIN = 0.9
#: Rounds in which heading = direction - sideslip settles: the sideslip changes far less than the heading.
ROUNDS = 6
#: The sharpest curvature that a search may use, over that of the blended path: blends need a little more.
SEARCHED = 0.92


@dataclass(frozen=True, slots=True, eq=False)
class _Readers:
    """The table's commands, and its tractions packed the same way."""

    commands: Interpolant
    tractions: Interpolant


def table_limits(table: Table, vehicle: VehicleProfile, sharpest: float, most_speed: float) -> SteeringLimits:
    """The fastest feasible turns of a table within the limits of a profile, driving forwards.

    Feasible is a speed that the table has an answer to, as it has to all below, with drive forces within the profile's;
    the speed given out is at most `MARGIN` of the next one that is not.

    Parameters
    ----------
    table
        Of the vehicle on its terrain.
    vehicle
        Whose limits count.
    sharpest
        Largest curvature either way. [1/m]
    most_speed
        Upper bound. [m/s]

    Returns
    -------
    SteeringLimits
        Its outermost curvatures but one are `SEARCHED` times the outermost; see `searched`.
    """
    readers = _readers(table, vehicle)
    curvature = _curvatures(table, sharpest)
    direction = FULL_CIRCLE * np.arange(DIRECTIONS) / DIRECTIONS
    shape = table.axes.slope.size, curvature.size, DIRECTIONS
    slopes, turns, ways = (axis.ravel() for axis in np.meshgrid(table.axes.slope, curvature, direction, indexing="ij"))
    nodes = table.axes.velocity[table.axes.velocity <= max(most_speed, table.axes.velocity[0])]
    speed, going = np.zeros(slopes.size), np.ones(slopes.size, np.bool_)
    for k, velocity in enumerate(nodes):
        found, force, _ = _answers(readers, slopes, np.full_like(slopes, velocity), turns, ways)
        feasible = going & ~np.isnan(found.sideslip)
        if vehicle.max_track_force is not None:
            feasible &= force <= MARGIN * vehicle.max_track_force
        stopped = going & ~feasible
        if k > 0:
            speed[stopped] = np.minimum(nodes[k - 1], MARGIN * velocity)
        going = feasible
        fastest_track = np.maximum(found.track_speed_left, found.track_speed_right) / velocity
        allowed = MARGIN * vehicle.max_sprocket_rate * vehicle.sprocket_radius / fastest_track
        speed[going] = np.minimum(most_speed, allowed)[going]
    at = np.clip(speed, nodes[0], nodes[-1])
    found, _, work = _answers(readers, slopes, at, turns, ways)
    slip = np.maximum(np.abs(found.slip_left), np.abs(found.slip_right))
    feasible = (speed > 0.0) & ~np.isnan(found.sideslip)
    columns = (np.where(feasible, values, 0.0).reshape(shape) for values in (speed, found.sideslip, slip, work))
    limits = SteeringLimits(np.array(table.axes.slope), curvature, direction, *columns)
    return _same_all_round_where_level(limits)


def _readers(table: Table, vehicle: VehicleProfile) -> _Readers:
    tractions = np.stack([table.values[name] for name in ("traction_left", "traction_right", "sideslip")], axis=-1)
    commands = interpolant(table)
    # The profile's rate bounds the speed itself, so that none is refused here.
    free = Interpolant(commands.grid._replace(max_sprocket_rate=math.inf))
    return _Readers(free, interpolant_of(table.axes, tractions, table.status, vehicle, math.inf))


def _curvatures(table: Table, sharpest: float) -> Array:
    """Those of the table either way, up to the sharpest, which must be within them."""
    sizes = np.unique(np.abs(table.axes.curvature))
    inner = sizes[(sizes < SEARCHED * sharpest * (1.0 - 1e-9)) & (sizes > 0.0)]
    right = np.concatenate((inner, [SEARCHED * sharpest, sharpest]))
    return np.concatenate((-right[::-1], [0.0], right))


def _answers(
    readers: _Readers, slope: Array, velocity: Array, curvature: Array, direction: Array
) -> tuple[LookupResult, Array, Array]:
    """Commands, the larger traction [N] and the work of the driving tracks [J/m], at directions of motion."""
    sideslip = np.zeros_like(direction)
    for _ in range(ROUNDS):
        heading = direction - sideslip
        found = look_up(readers.commands, slope, velocity, curvature, heading, Method.LINEAR)
        sideslip = np.where(np.isnan(found.sideslip), sideslip, found.sideslip)
    pulled = look_up(readers.tractions, slope, velocity, curvature, heading, Method.LINEAR)
    left, right = pulled.track_speed_left / velocity, pulled.track_speed_right / velocity
    work = np.maximum(left * found.track_speed_left, 0.0) + np.maximum(right * found.track_speed_right, 0.0)
    return found, np.maximum(np.abs(left), np.abs(right)), work / velocity


def _same_all_round_where_level(limits: SteeringLimits) -> SteeringLimits:
    """On level ground every direction is the same, to the last bit."""
    level = limits.slope == 0.0
    for table in (limits.speed, limits.sideslip, limits.slip, limits.work):
        table[level] = table[level][:, :, :1]
    return limits


def searched(limits: SteeringLimits) -> SteeringLimits:
    """The same without the outermost curvatures, which are left to blends."""
    tables = (values[:, 1:-1] for values in (limits.speed, limits.sideslip, limits.slip, limits.work))
    return SteeringLimits(limits.slope, limits.curvature[1:-1], limits.direction, *tables)


def driven_backwards(turned: SteeringLimits) -> SteeringLimits:
    """Limits of driving backwards, from those of the vehicle turned round by half a circle driving forwards.

    Told as by the vehicle itself: curvature is yaw change per metre travelled forwards, and direction that of the
    reverse of the motion.
    """
    tables = (
        np.roll(values[:, ::-1], DIRECTIONS // 2, axis=2)
        for values in (turned.speed, turned.sideslip, turned.slip, turned.work)
    )
    return SteeringLimits(turned.slope, -turned.curvature[::-1], turned.direction, *tables)


def is_feasible_somewhere(limits: SteeringLimits) -> bool:
    """Whether there is any turn that can be driven."""
    return bool((limits.speed > 0.0).any())
