"""Straights that a plan begins and ends with: room for the first and the last blend, in the gears of the ends."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from trackctl.planning.ground import gear_motion, straight_tangent
from trackctl.planning.route import Route
from trackctl.planning.search import Problem
from trackctl.workflows.plan_model import LONG_BLENDS, DriveModel, blend_length, slopes_at

#: Length of a piece that only stands for a stop. [m]
STOP = 1e-6


def led_in(model: DriveModel, problem: Problem, gears: tuple[int, int]) -> Problem:
    """The problem from half a blend ahead of the start to half a blend short of the goal, driven straight in gears."""
    ways = []
    for (x, y, _), gear in zip((problem.start, problem.goal), gears, strict=True):
        slope = float(slopes_at(model, np.array([x]), np.array([y]))[0])
        ways.append(0.5 * gear * min(LONG_BLENDS) * blend_length(model, slope, model.sharpest))
    x, y, yaw = problem.start
    tangent = straight_tangent(model.pace, gear_motion(model.pace, gears[0]), x, y, yaw)
    start = x + ways[0] * math.cos(tangent), y + ways[0] * math.sin(tangent), yaw
    return replace(problem, start=start, goal_lead=ways[1], gears=gears)


def in_gears(route: Route, gears: tuple[int, int]) -> Route:
    """A route begun and ended in the gears of its leads: where it turns round at once, it stops.

    The stop is a piece of no length to speak of, which is blended as a stretch of its own. Gears of 0 need none.
    """
    driven = np.sign(route.length[route.length != 0.0])
    if driven.size == 0:
        return route
    before, after = (
        [gear * STOP] if gear * sign < 0.0 else [] for gear, sign in zip(gears, driven[[0, -1]], strict=True)
    )
    straight = [0.0] * len(before), [0.0] * len(after)
    curvature, pivot = (np.concatenate((straight[0], part, straight[1])) for part in (route.curvature, route.pivot))
    return Route(route.start, curvature, np.concatenate((before, route.length, after)), pivot)
