"""From a problem to a driven plan: searches that leave room for blends and drift, until a route can be driven."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from trackctl.errors import NoAnswerError
from trackctl.planning.ground import straight_tangent
from trackctl.planning.search import Improvement, Problem, SearchResult, Settings, search
from trackctl.planning.slope_field import SlopeField
from trackctl.workflows.plan_drive import (
    LONG_BLENDS,
    DriveModel,
    DrivenLine,
    UndrivableError,
    blend_length,
    drive_route,
    slopes_at,
)

Progress = Callable[[float, float], None]

#: How far a vehicle may leave its plan open loop, over the way from start to goal and the tangent of the slope.
DEVIATION = 0.05
#: Blends move a path by more than they cut where its pieces are many; then so many times the room is tried.
MORE_ROOM = (3.0, 9.0)
#: Routes that are tried to drive, the best first.
MOST_ROUTES = 8


def slope_range(field: SlopeField) -> tuple[float, float]:
    """Least and largest slope of a map. [rad]"""
    slopes = np.arctan(np.hypot(field.gradient_x, field.gradient_y))
    return float(np.nanmin(slopes)), float(np.nanmax(slopes))


def led_in(model: DriveModel, problem: Problem) -> Problem:
    """The problem from half a blend ahead of the start to half a blend short of the goal, driven straight."""
    poses = []
    for pose, sense in ((problem.start, 0.5), (problem.goal, -0.5)):
        x, y, yaw = pose
        slope = float(slopes_at(model, np.array([x]), np.array([y]))[0])
        way = sense * min(LONG_BLENDS) * blend_length(model, slope, model.sharpest)
        tangent = straight_tangent(model.pace, model.pace.forward, x, y, yaw)
        poses.append((x + way * math.cos(tangent), y + way * math.sin(tangent), yaw))
    return replace(problem, start=poses[0], goal=poses[1])


def driven_plan(
    model: DriveModel, problem: Problem, settings: Settings, progress: Progress
) -> tuple[SearchResult, list[DrivenLine], float]:
    """Search, and drive the best route that can be driven.

    Raises
    ------
    NoAnswerError
        If there is none.
    """
    reasons: list[str] = []
    searched: list[SearchResult] = []
    for attempt in attempts(model, problem):
        found = search(attempt, settings, progress)
        if found.route is None:
            reasons.append(found.reason)
            continue
        searched.append(found)
        best = [(found.improvements[-1], long) for long in LONG_BLENDS]
        if (driven := first_driven(model, problem, best, reasons)) is not None:
            return found, *driven
    for found in searched:
        routes = [(each, 1.0) for each in found.improvements[::-1][:MOST_ROUTES]]
        if (driven := first_driven(model, problem, routes, reasons)) is not None:
            return found, *driven
    raise NoAnswerError(reasons[0])


def first_driven(
    model: DriveModel, problem: Problem, candidates: Sequence[tuple[Improvement, float]], reasons: list[str]
) -> tuple[list[DrivenLine], float] | None:
    """The first of some routes, each with its blends over the least, that can be driven, and its cost.

    Why others cannot is added to the reasons.
    """
    for improvement, longer in candidates:
        try:
            return drive_route(model, improvement.route, problem.start, problem.goal, longer), improvement.cost
        except UndrivableError as error:
            reasons.append(f"a way was found but cannot be driven: {error}")
    return None


def attempts(model: DriveModel, problem: Problem) -> list[Problem]:
    """Searches to be made until a route can be driven.

    Blends cut corners by up to curvature blend^2 / 24, and on a slope the vehicle leaves its plan: the first searches
    keep that much farther away (for the slope only where no clearance was asked for), the next no more than they must.
    The last one starts and ends at the poses themselves; when driving backwards is allowed, whether the ends are driven
    forwards is not known beforehand, and there is no other.
    """
    slope = float(slopes_at(model, *(np.array([value]) for value in problem.start[:2]))[0])
    away = DEVIATION * math.tan(slope_range(problem.field)[1]) * math.dist(problem.start[:2], problem.goal[:2])
    cut = model.sharpest * (min(LONG_BLENDS) * blend_length(model, slope, model.sharpest)) ** 2 / 24.0
    led = problem if problem.backward is not None else led_in(model, problem)
    preferred = () if away == 0.0 or problem.clearance > 0.0 else (cut + away, cut + away / 3.0)
    rooms = (*preferred, cut, *(factor * cut for factor in MORE_ROOM), 0.0)
    found = [replace(led, clearance=problem.clearance + room) for room in rooms]
    return found if problem.backward is not None else [*found, problem]
