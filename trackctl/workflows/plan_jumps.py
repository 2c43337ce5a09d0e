"""The last resort where no blend fits: a route with its jumps of curvature, and the commands of its blended twin."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from trackctl.planning.blending import SAME_CURVATURE, Line, jumping_route, stretches_of
from trackctl.planning.route import Route
from trackctl.planning.surface_line import surface_line
from trackctl.simulation.following import deviation
from trackctl.simulation.path import Path
from trackctl.workflows.plan_drive import Driven, least_blend, settled
from trackctl.workflows.plan_line import DrivenLine, check_clear, check_roughly, drive_line, map_poses
from trackctl.workflows.plan_model import DriveModel, UndrivableError

Array = NDArray[np.float64]
Pose = tuple[float, float, float]

#: How far the twin may miss the goal, over a blend.
MOST_MISSED = 0.25


def drive_jumps(model: DriveModel, route: Route, start: Pose, goal: Pose) -> list[Driven]:
    """Follow a route with its jumps of curvature from pose to pose, x, y [m] and yaw [rad], both met exactly.

    The lines are those of the route; the commands are those of its twin, and both keep clear of obstacles.

    Raises
    ------
    UndrivableError
        If either touches something, the twin asks for more than the vehicle can, or misses the goal by too much.
    """
    blend = least_blend(model, route)

    def driven_between(
        start: Pose, goal: Pose, kinks: Sequence[float] | None, first: bool
    ) -> tuple[list[DrivenLine], Array]:
        found = jumping_route(route, start, goal, blend, model.sharpest, kinks)
        if found is None:
            raise UndrivableError("its turns leave no room for what the sideslip changes at its ends")
        jumping, twins = found
        if first:
            check_roughly(model, [*jumping.lines, *twins.lines])
        driven = [
            followed(model, line, drive_line(model, twin))
            for line, twin in zip(jumping.lines, twins.lines, strict=True)
        ]
        check_clear(model, driven)
        check_clear(model, [each.twin for each in driven if each.twin is not None])
        return driven, jumping.turns

    driven = settled(model, route, (start, goal), driven_between)
    if (missed := departures(driven)[1]) > MOST_MISSED * blend:
        raise UndrivableError(
            f"no blend fits, and the commands of its blended twin miss the goal by {missed:.2f} m, more than "
            f"{MOST_MISSED:g} of a blend of {blend:.2f} m"
        )
    return driven


def followed(model: DriveModel, line: Line, twin: DrivenLine) -> DrivenLine:
    """A line with the commands of its twin at each arc length."""
    pose, curvature = line.at(twin.place), line.curvature_at(twin.place)
    surface = surface_line(model.field, twin.place, pose, curvature)
    path = Path(surface.arc_length, pose[0], pose[1], surface.direction, surface.curvature, twin.commands.path.speed)
    return DrivenLine(line, surface, twin.place, replace(twin.commands, path=path), twin)


def departures(parts: Sequence[Driven]) -> tuple[float, float, float]:
    """How far the twins leave the plan at most and miss the goal [m], and the turn that is missing there. [rad]"""
    driven = [part for part in parts if isinstance(part, DrivenLine)]
    x, y, yaw = (np.concatenate(parts) for parts in list(zip(*map(map_poses, driven), strict=True))[:3])
    twins = [each.twin or each for each in driven]
    twin_x, twin_y, twin_yaw = (np.concatenate(parts) for parts in list(zip(*map(map_poses, twins), strict=True))[:3])
    nothing = np.zeros_like(x)
    away = deviation(Path(nothing, x, y, nothing, nothing, nothing), twin_x, twin_y).max()
    turned = abs(math.remainder(twin_yaw[-1] - yaw[-1], 2.0 * math.pi))
    return float(away), math.hypot(twin_x[-1] - x[-1], twin_y[-1] - y[-1]), turned


def jumps_note(route: Route, driven: Sequence[Driven]) -> str:
    """What the user should know of a plan with jumps."""
    bends = np.concatenate([np.diff(stretch.curvature) for stretch in stretches_of(route)[0]])
    count = int(np.count_nonzero(np.abs(bends) > SAME_CURVATURE))
    away, missed, turned = departures(driven)
    return (
        f"no blend fits: the curvature of the plan jumps {count} time{'s' if count != 1 else ''}. The sprocket rates "
        f"are those of its blended twin, which leaves the plan by up to {away:.3f} m and misses the goal by "
        f"{missed:.3f} m and {math.degrees(turned):.2f} deg"
    )
