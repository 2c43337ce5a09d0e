"""Where a plan may end: poses of the body within a tolerance of the goal, and the ends of routes that lead there."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.planning.collision import Obstacles, is_clear
from trackctl.planning.ground import rate_at, straight_tangent
from trackctl.planning.pieces import Task, free_length, lent, motion_in
from trackctl.planning.pose import wrapped
from trackctl.planning.random_numbers import Stream, between, normal, uniform

Array = NDArray[np.float64]
Pose = tuple[float, float, float]

#: What an end lies inside the tolerance, so that a driven plan keeps it to rounding. [m], [rad]
POSITION_SLACK, YAW_SLACK = 1e-9, 2e-6
#: Share of shots at the surest end.
SUREST_SHARE = 0.25
#: Tries to draw an end that will do.
TRIES = 32
#: Decades over which the changes of an end are spread, below the tolerance.
DECADES = 3.0
#: Distances, bearings and yaws of poses that are looked at where the goal itself will not do.
RINGS, BEARINGS, YAWS = 16, 32, 17


class Target(NamedTuple):
    """The goal and its tolerance.

    Attributes
    ----------
    x, y, yaw
        Of the body. [m], [rad]
    distance, turn
        Tolerance of position [m] and yaw [rad], 0: met exactly.
    lead
        Straight from the end of a route to that of the plan, negative backwards. [m]
    """

    x: float
    y: float
    yaw: float
    distance: float
    turn: float
    lead: float


class End(NamedTuple):
    """Where a route and its plan end, arrays of shape (3,) that kernels fill.

    Attributes
    ----------
    route
        x, y, tangent. [m], [rad]
    body
        x, y, yaw at the end of the plan. [m], [rad]
    """

    route: Array
    body: Array


def new_end(route: Pose = (0.0, 0.0, 0.0), body: Pose = (0.0, 0.0, 0.0)) -> End:
    """An end of its own."""
    return End(np.array(route), np.array(body))


@kernel
def is_exact(target: Target) -> bool:
    """Whether there is but one end."""
    return target.distance <= POSITION_SLACK and target.turn <= YAW_SLACK


@inlined
def lent_end(end: End) -> End:
    """An end, its arrays lent."""
    return End(lent(end.route), lent(end.body))


@kernel
def copy_end(source: End, end: End) -> None:
    """Write one end over another."""
    for i in range(3):
        end.route[i], end.body[i] = source.route[i], source.body[i]


@kernel
def set_end(task: Task, target: Target, x: float, y: float, yaw: float, end: End) -> bool:
    """Let a plan end at a pose of the body, if that is clear and can be driven to straight; whether it is so."""
    ground, motion, cos_yaw, sin_yaw = task.ground, motion_in(task, task.last_gear), math.cos(yaw), math.sin(yaw)
    if not is_clear(task.obstacles, x, y, cos_yaw, sin_yaw, 0.0):
        return False
    tangent = straight_tangent(ground, motion, x, y, yaw)
    from_x, from_y = x - target.lead * math.cos(tangent), y - target.lead * math.sin(tangent)
    tangent = straight_tangent(ground, motion, from_x, from_y, yaw)
    if rate_at(ground, motion, from_x, from_y, tangent, 0.0)[0] == np.inf:
        return False
    if not is_clear(task.obstacles, from_x, from_y, cos_yaw, sin_yaw, 0.0):
        return False
    end.route[0], end.route[1], end.route[2] = from_x, from_y, tangent
    end.body[0], end.body[1], end.body[2] = x, y, yaw
    return free_length(task, from_x, from_y, tangent, 0.0, target.lead) >= abs(target.lead)


@kernel
def _set_within(task: Task, target: Target, x: float, y: float, yaw: float, end: End) -> bool:
    """`set_end` at the pose within the tolerance that is nearest to one."""
    off_x, off_y, turn = x - target.x, y - target.y, wrapped(yaw - target.yaw)
    most, most_turn = max(0.0, target.distance - POSITION_SLACK), max(0.0, target.turn - YAW_SLACK)
    share = min(1.0, most / max(math.hypot(off_x, off_y), 1e-300))
    turn = min(most_turn, max(-most_turn, turn))
    return set_end(task, target, target.x + share * off_x, target.y + share * off_y, target.yaw + turn, end)


@kernel
def draw_end(task: Task, target: Target, surest: End, stream: Stream, end: End) -> None:
    """Any end within the tolerance, or the surest one."""
    for _ in range(TRIES if uniform(stream) >= SUREST_SHARE else 0):
        away, bearing = target.distance * math.sqrt(uniform(stream)), between(stream, -math.pi, math.pi)
        yaw = target.yaw + target.turn * between(stream, -1.0, 1.0)
        x, y = target.x + away * math.cos(bearing), target.y + away * math.sin(bearing)
        if _set_within(task, target, x, y, yaw, end):
            return
    copy_end(surest, end)


@kernel
def draw_beside(task: Task, target: Target, before: End, stream: Stream, end: End) -> bool:
    """An end near another one, moved, turned or both; whether it will do."""
    spread, kind = 10.0 ** (-DECADES * uniform(stream)), 3.0 * uniform(stream)
    away, turned = (spread * target.distance if kind < 2.0 else 0.0), (spread * target.turn if kind > 1.0 else 0.0)
    x, y = before.body[0] + away * normal(stream), before.body[1] + away * normal(stream)
    return _set_within(task, target, x, y, before.body[2] + turned * normal(stream), end)


@kernel
def _first_end(task: Task, target: Target, poses: Array, end: End) -> int:
    for i in range(poses.shape[0]):
        if set_end(task, target, poses[i, 0], poses[i, 1], poses[i, 2], end):
            return i
    return -1


@kernel
def _first_clear(obstacles: Obstacles, poses: Array) -> int:
    for i in range(poses.shape[0]):
        if is_clear(obstacles, poses[i, 0], poses[i, 1], math.cos(poses[i, 2]), math.sin(poses[i, 2]), 0.0):
            return i
    return -1


def poses_within(target: Target) -> Array:
    """Poses of the body spread over a tolerance, the nearest to the goal first, shape (n, 3)."""
    most, most_turn = max(0.0, target.distance - POSITION_SLACK), max(0.0, target.turn - YAW_SLACK)
    rings, bearings = np.arange(1, RINGS + 1) / RINGS, 2.0 * np.pi * np.arange(BEARINGS) / BEARINGS
    across = np.concatenate(([0.0], np.outer(rings, np.cos(bearings)).ravel())) if most else np.zeros(1)
    along = np.concatenate(([0.0], np.outer(rings, np.sin(bearings)).ravel())) if most else np.zeros(1)
    turns = np.linspace(-1.0, 1.0, YAWS) if most_turn else np.zeros(1)
    place, turn = (part.ravel() for part in np.meshgrid(np.arange(across.size), turns, indexing="ij"))
    order = np.argsort(np.hypot(across, along)[place] + np.abs(turn), kind="stable")
    place, turn = place[order], turn[order]
    x, y = target.x + most * across[place], target.y + most * along[place]
    return np.stack((x, y, target.yaw + most_turn * turn), axis=1)


def nearest_end(task: Task, target: Target) -> End | None:
    """An end near the goal that will do, None where none is found."""
    end = new_end()
    return end if _first_end(task, target, poses_within(target), end) >= 0 else None


def is_clear_somewhere(obstacles: Obstacles, target: Target) -> bool:
    """Whether a pose within the tolerance is found at which the footprint touches nothing."""
    return _first_clear(obstacles, poses_within(target)) >= 0
