"""Arcs, straights and turns on the spot: whether they can be driven, and what they cost."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel, lending
from trackctl.planning.collision import (
    HALF_DIAGONAL,
    Obstacles,
    cell_position,
    cleared_movement,
    disc_clearance,
    is_clear,
)
from trackctl.planning.footprint import Footprint
from trackctl.planning.ground import Ground, Motion, rate_at
from trackctl.planning.pose import advanced
from trackctl.planning.slope_field import SlopeField

Array = NDArray[np.float64]

#: Pieces of a connection at most: the longest words of Reeds and Shepp.
MOST_PIECES = 5
#: Between two samples of cost and feasibility along a piece. [m]
COST_STEP = 0.2
#: First step of a sweep whose start is too near an obstacle for the discs, in cells.
FIRST_STEP = 2.0
#: Movement between two checks below which a sweep gives up, in cells: that near an obstacle it counts as touching.
FINEST_STEP = 0.2
#: Between two checks of a turn on the spot, as movement of the farthest vertex, in cells.
PIVOT_STEP = 0.5


lent = lending()


class Way(NamedTuple):
    """Pieces one after the other, arrays as of `Route` with space for some more.

    Attributes
    ----------
    curvature
        [1/m]
    length
        [m]
    pivot
        [rad]
    """

    curvature: Array
    length: Array
    pivot: Array


class Task(NamedTuple):
    """What the kernels of a search read and never change.

    Attributes
    ----------
    obstacles
        What not to touch.
    ground
        What driving costs.
    radii
        Turning radii that connections try, ascending. [m]
    gear_change
        Cost of changing between forwards and backwards.
    pivot_rate
        Cost of turning on the spot by a radian, besides that of a gear change for the stop; infinite where it cannot.
        [1/rad]
    can_reverse
        Whether there is a reverse gear.
    first_gear, last_gear
        Before the start and behind the goal: 1 forwards, -1 backwards, 0 either.
    inner_radius
        Of the largest disc about the mass centre within the footprint. [m]
    least_rate
        No metre costs less. [1/m]
    estimates
        Work space of connections: what their words cost at least.
    """

    obstacles: Obstacles
    ground: Ground
    radii: Array
    gear_change: float
    pivot_rate: float
    can_reverse: bool
    first_gear: int
    last_gear: int
    inner_radius: float
    least_rate: float
    estimates: Array


@inlined
def lent_way(way: Way) -> Way:
    """Pieces, their arrays lent."""
    return Way(lent(way.curvature), lent(way.length), lent(way.pivot))


@kernel
def lent_motion(motion: Motion) -> Motion:
    """Tables of a gear, their arrays lent."""
    return Motion(
        lent(motion.slope),
        lent(motion.curvature),
        lent(motion.rate),
        lent(motion.sideslip),
        motion.least_rate,
        motion.turning,
    )


@kernel
def lent_task(task: Task) -> Task:
    """A task, its arrays lent."""
    o, f, g = task.obstacles, task.obstacles.footprint, task.ground
    field = SlopeField(
        lent(g.field.gradient_x),
        lent(g.field.gradient_y),
        g.field.spacing_x,
        g.field.spacing_y,
        g.field.x,
        g.field.y,
        g.field.level_uphill,
    )
    footprint = Footprint(lent(f.vertices), lent(f.edges), lent(f.first), lent(f.discs), f.reach)
    obstacles = Obstacles(
        lent(o.before),
        lent(o.distance),
        o.resolution,
        o.x,
        o.y,
        o.cos_yaw,
        o.sin_yaw,
        o.margin,
        footprint,
        lent(o.spans),
    )
    return Task(
        obstacles,
        Ground(field, lent_motion(g.forward), lent_motion(g.backward), g.is_level),
        lent(task.radii),
        task.gear_change,
        task.pivot_rate,
        task.can_reverse,
        task.first_gear,
        task.last_gear,
        task.inner_radius,
        task.least_rate,
        lent(task.estimates),
    )


def new_way(count: int = MOST_PIECES) -> Way:
    """Space for some pieces."""
    return Way(*(np.zeros(count) for _ in range(3)))


@inlined
def gear_of(length: float, before: int) -> int:
    """1 forwards, -1 backwards, and what it was where nothing is driven."""
    if length == 0.0:
        return before
    return 1 if length > 0.0 else -1


@inlined
def motion_in(task: Task, length: float) -> Motion:
    """Tables of the gear that a piece is driven in."""
    if length < 0.0:
        return task.ground.backward
    return task.ground.forward


@kernel
def drive_cost(task: Task, x: float, y: float, tangent: float, curvature: float, length: float) -> float:
    """Cost of an arc or a straight, by the midpoint rule; infinite where a sample or an end cannot be driven."""
    if length == 0.0:
        return 0.0
    motion = motion_in(task, length)
    if task.ground.is_level:
        return rate_at(task.ground, motion, x, y, tangent, curvature)[0] * abs(length)
    end_x, end_y, end_tangent = advanced(x, y, tangent, curvature, length)
    if (
        rate_at(task.ground, motion, x, y, tangent, curvature)[0] == np.inf
        or rate_at(task.ground, motion, end_x, end_y, end_tangent, curvature)[0] == np.inf
    ):
        return np.inf
    count = math.ceil(abs(length) / COST_STEP)
    step, total = length / count, 0.0
    for i in range(count):
        at_x, at_y, at_tangent = advanced(x, y, tangent, curvature, (i + 0.5) * step)
        total += rate_at(task.ground, motion, at_x, at_y, at_tangent, curvature)[0]
        if total == np.inf:
            return np.inf
    return float(total * abs(step))


@kernel
def free_length(task: Task, x: float, y: float, tangent: float, curvature: float, length: float) -> float:
    """How far an arc or a straight can be driven before the footprint touches; all in between is clear.

    A check at a point covers what is nearer to it than the clearance there, over the fastest that a point of the
    footprint moves.

    Parameters
    ----------
    task
        Obstacles and sideslip.
    x, y, tangent
        A start that is clear. [m], [rad]
    curvature, length
        Of the piece, the length negative backwards. [1/m], [m]

    Returns
    -------
    float
        Not negative; the size of `length` where nothing is in the way. [m]
    """
    obstacles, motion = task.obstacles, motion_in(task, length)
    total, sense = abs(length), (1.0 if length >= 0.0 else -1.0)
    per_metre = 1.0 + obstacles.footprint.reach * abs(curvature) * (1.0 + motion.turning)
    sideslip = rate_at(task.ground, motion, x, y, tangent, curvature)[1]
    yaw = tangent - sideslip
    covered = disc_clearance(obstacles, x, y, math.cos(yaw), math.sin(yaw)) - obstacles.margin
    covered = max(0.0, covered / per_metre)
    step = max(covered, FIRST_STEP * obstacles.resolution / per_metre)
    while covered < total:
        step = min(step, total - covered)
        at = covered + step
        at_x, at_y, at_tangent = advanced(x, y, tangent, curvature, sense * at)
        if not task.ground.is_level:
            sideslip = rate_at(task.ground, motion, at_x, at_y, at_tangent, curvature)[1]
        moved = cleared_movement(obstacles, at_x, at_y, at_tangent - sideslip, step * per_metre)
        if moved >= 0.0:
            covered = at + moved / per_metre
            step = max(2.0 * step, moved / per_metre)
        else:
            step *= 0.5
            if step * per_metre < FINEST_STEP * obstacles.resolution:
                return covered
    return total


@inlined
def pivot_cost(task: Task, angle: float) -> float:
    """Cost of turning on the spot by an angle, which needs a stop as a change of gear does."""
    return task.gear_change + task.pivot_rate * abs(angle)


@kernel
def pivot_is_free(task: Task, x: float, y: float, yaw: float, angle: float) -> bool:
    """Whether the body can turn on the spot by an angle without touching."""
    obstacles = task.obstacles
    step = PIVOT_STEP * obstacles.resolution
    count = math.ceil(abs(angle) * obstacles.footprint.reach / step)
    for i in range(count):
        at = yaw + angle * (i + 0.5) / count
        if not is_clear(obstacles, x, y, math.cos(at), math.sin(at), 0.5 * step):
            return False
    return True


@kernel
def way_cost(task: Task, x: float, y: float, tangent: float, gear: int, way: Way, count: int, bound: float) -> float:
    """Cost of driving some pieces, obstacles left aside; infinite where that cannot be or costs the bound or more."""
    total = 0.0
    for i in range(count):
        length = way.length[i]
        if length != 0.0:
            if gear * length < 0.0:
                total += task.gear_change
            gear = gear_of(length, gear)
            total += drive_cost(task, x, y, tangent, way.curvature[i], length)
        elif way.pivot[i] != 0.0:
            total += pivot_cost(task, way.pivot[i])
        if not total < bound:
            return np.inf
        x, y, tangent = advanced(x, y, tangent, way.curvature[i], length)
        tangent += way.pivot[i]
    return total


@kernel
def is_hopeless(task: Task, x: float, y: float, tangent: float, way: Way, count: int) -> bool:
    """Whether the footprint surely touches somewhere along some pieces: a coarse look, before the sweep."""
    obstacles = task.obstacles
    radius = task.inner_radius + obstacles.margin - HALF_DIAGONAL * obstacles.resolution
    n_rows, n_columns = obstacles.distance.shape
    for i in range(count):
        length = way.length[i]
        steps = int(abs(length) / task.radii[0]) + 1
        for k in range(1, steps + 1 if length != 0.0 else 1):
            at_x, at_y, _ = advanced(x, y, tangent, way.curvature[i], length * k / steps)
            column, row = cell_position(obstacles, at_x, at_y)
            if not (0.0 <= column < n_columns and 0.0 <= row < n_rows):
                return True
            if obstacles.distance[int(row), int(column)] < radius:
                return True
        x, y, tangent = advanced(x, y, tangent, way.curvature[i], length)
        tangent += way.pivot[i]
    return False


@kernel
def way_is_free(task: Task, x: float, y: float, tangent: float, way: Way, count: int) -> bool:
    """Whether some pieces can be driven from a clear pose without touching."""
    if is_hopeless(task, x, y, tangent, way, count):
        return False
    for i in range(count):
        curvature, length = way.curvature[i], way.length[i]
        if length != 0.0 and free_length(task, x, y, tangent, curvature, length) < abs(length):
            return False
        if way.pivot[i] != 0.0 and not pivot_is_free(task, x, y, tangent, way.pivot[i]):
            return False
        x, y, tangent = advanced(x, y, tangent, curvature, length)
        tangent += way.pivot[i]
    return True
