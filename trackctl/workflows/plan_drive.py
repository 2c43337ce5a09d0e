"""From a route to what the vehicle drives: blended lines and turns on the spot, with their commands."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise, zip_longest

import numpy as np
from numpy.typing import NDArray

from trackctl.planning.blending import blended_route
from trackctl.planning.ground import straight_tangent
from trackctl.planning.pose import advanced
from trackctl.planning.route import Route
from trackctl.planning.surface_line import gradients_along, is_plane, on_ground, on_map, slope_and_uphill
from trackctl.simulation.path_rule import no_slip_ratios
from trackctl.workflows.plan_line import DrivenLine, check_clear, check_roughly, drive_line, map_poses
from trackctl.workflows.plan_model import DriveModel, UndrivableError, blend_length, slopes_at
from trackctl.workflows.plan_turn import DrivenTurn, driven_turn

Array = NDArray[np.float64]
Pose = tuple[float, float, float]

#: Rounds in which the tangents at the ends settle to the sideslip there.
END_ROUNDS, SETTLED, TINY = 12, 1e-9, 1e-300
#: Curvature so gentle that a vehicle drives its jumps off by no more than this: it needs no blends of that length. [m]
SLIGHT = 3e-3
#: Ramps of a way as gentle as that, over its length.
GENTLE_RAMP = 0.2

Driven = DrivenLine | DrivenTurn
#: Drives between two ends, each x, y [m] and tangent [rad], with turns of the tangent where the gear changes; told
#: whether for the first time. The lines, and the turns on the spot before each and after the last. [rad]
DriveBetween = Callable[[Pose, Pose, Sequence[float] | None, bool], tuple[list[DrivenLine], Array]]


def drive_route(model: DriveModel, route: Route, start: Pose, goal: Pose, longer: float) -> list[Driven]:
    """Drive a route from pose to pose, x, y [m] and yaw [rad], both met exactly; its blends so many times the least.

    Raises
    ------
    UndrivableError
        If it cannot be blended, touches something, or asks for more than the vehicle can.
    """
    route, blend, sharpest = blend_of(model, route, longer)

    def driven_between(
        start: Pose, goal: Pose, kinks: Sequence[float] | None, first: bool
    ) -> tuple[list[DrivenLine], Array]:
        blended = blended_route(route, start, goal, blend, sharpest, kinks)
        if blended is None:
            near = math.dist(start[:2], goal[:2])
            between = f" between poses {near:.2g} m apart" if near < blend else ""
            raise UndrivableError(f"its turns leave no room for blends of {blend:.2g} m{between}")
        if first:
            check_roughly(model, blended.lines)
        driven = [drive_line(model, line) for line in blended.lines]
        check_clear(model, driven)
        return driven, blended.turns

    return settled(model, route, (start, goal), driven_between)


def as_straight(route: Route, gentle: float) -> Route | None:
    """The straight that a route driven one way is, but for turns by a curvature so gentle on average [1/m]; or None."""
    length = float(route.length.sum())
    turned = float(np.abs(route.curvature * route.length).sum())
    if route.pivot.any() or np.abs(route.length).sum() > abs(length) * (1.0 + 1e-9) or turned > gentle * abs(length):
        return None
    return Route(route.start, np.zeros(1), np.array([length]), np.zeros(1))


def blend_of(model: DriveModel, route: Route, longer: float) -> tuple[Route, float, float]:
    """A route, its blends, so many times the least [m], and the largest curvature between them. [1/m]

    A short way as good as straight has shorter blends, and stays as good as straight.
    """
    blend = least_blend(model, route)
    gentle = min(24.0 * SLIGHT / blend**2, model.sharpest)
    straight = as_straight(route, gentle)
    if straight is None or (ramp := GENTLE_RAMP * abs(float(straight.length[0]))) >= longer * blend:
        return route, longer * blend, model.sharpest
    return straight, ramp, gentle


def least_blend(model: DriveModel, route: Route) -> float:
    """Over which the curvature of a route may change. [m]"""
    return blend_length(model, steepest_along(model, route), float(np.abs(route.curvature).max()))


def settled(
    model: DriveModel,
    route: Route,
    ends: tuple[Pose, Pose],
    driven_between: DriveBetween,
) -> list[Driven]:
    """Drive a route so that the body's poses at the ends are met with the sideslips that it is driven with."""
    ways = route.length[route.length != 0.0]
    backwards = [bool(ways.size and ways[k] < 0.0) for k in (0, -1)]
    tangents = [
        straight_tangent(model.pace, model.pace.backward if back else model.pace.forward, *pose)
        for pose, back in zip(ends, backwards, strict=True)
    ]
    kinks, steps, before, slopes = None, np.zeros(2), np.zeros(2), -np.eye(2)
    for turn in range(END_ROUNDS):
        first, last = ((*pose[:2], tangent) for pose, tangent in zip(ends, tangents, strict=True))
        driven, turns = driven_between(first, last, kinks, turn == 0)
        if not driven:
            break
        sideslips = [driven[0].commands.sideslip[0], driven[-1].commands.sideslip[-1]]
        found = [tangent_of(model, pose, beta) for pose, beta in zip(ends, sideslips, strict=True)]
        kinks = [float(after.commands.sideslip[0] - before.commands.sideslip[-1]) for before, after in pairwise(driven)]
        moves = np.array([math.remainder(a - b, 2.0 * math.pi) for a, b in zip(found, tangents, strict=True)])
        if np.abs(moves).max() < SETTLED:
            break
        # Broyden's method: in a short way the ends have to do with each other.
        slopes += np.outer(moves - before - slopes @ steps, steps) / max(float(steps @ steps), TINY)
        steps, before = np.linalg.lstsq(slopes, -moves, rcond=None)[0], moves
        tangents = (np.array(tangents) + steps).tolist()
    return with_turns(model, driven, turns, ends[0])


def with_turns(model: DriveModel, driven: Sequence[DrivenLine], turns: Array, start: Pose) -> list[Driven]:
    """Driven lines with the turns on the spot before, between and after them; from x, y [m] and yaw. [rad]"""
    parts: list[Driven] = []
    pose = start
    for angle, line in zip_longest(turns.tolist(), driven):
        if angle != 0.0:
            parts.append(driven_turn(model, pose, angle))
        if line is not None:
            parts.append(line)
            x, y, yaw, _ = map_poses(line)
            pose = float(x[-1]), float(y[-1]), float(yaw[-1])
    return parts


def steepest_along(model: DriveModel, route: Route) -> float:
    """Largest slope under a route, looked for at a few points of each piece. [rad]"""
    pose, points = route.start, [route.start]
    for curvature, length, turn in zip(route.curvature, route.length, route.pivot, strict=True):
        points += [advanced(*pose, curvature, share * length) for share in (0.25, 0.5, 0.75, 1.0)]
        x, y, tangent = points[-1]
        pose = x, y, tangent + turn
    across, up, _ = np.ascontiguousarray(np.array(points).T)
    return float(slopes_at(model, across, up).max())


def tangent_of(model: DriveModel, pose: Pose, sideslip: float) -> float:
    """Tangent on the map of a body's pose with a sideslip. [rad]"""
    x, y, yaw = pose
    if is_plane(model.field):
        return yaw + sideslip
    slope, (uphill,) = slope_and_uphill(model.field, *gradients_along(model.field, np.array([x]), np.array([y])))
    return float(uphill) + float(on_map(on_ground(np.array([yaw - uphill]), slope) + sideslip, slope)[0])


def no_slip_twin(model: DriveModel, driven: Driven) -> Driven:
    """The same with commands that would drive it without slip."""
    if isinstance(driven, DrivenTurn):
        return driven.without_slip
    path = driven.commands.path
    left, right, _ = no_slip_ratios((model.behind if driven.line.backwards else model.ahead).model, path.curvature)
    speeds = {"track_speed_left": left * path.speed, "track_speed_right": right * path.speed}
    return replace(driven, commands=replace(driven.commands, **speeds))
