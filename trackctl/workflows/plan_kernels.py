"""Kernels of `plan`, compiled or loaded before the clock of a search starts."""

from __future__ import annotations

import contextlib

import numpy as np

from trackctl.planning.blending import Line
from trackctl.planning.ground import straight_tangent
from trackctl.planning.search import Problem, Settings, load_kernels, target_of, task_of
from trackctl.planning.target import nearest_end
from trackctl.workflows.plan_line import check_clear, check_roughly, drive_line
from trackctl.workflows.plan_model import DriveModel, UndrivableError

#: Length of a line that is driven to this end, over the contact length.
SHORT = 0.25


def load_plan_kernels(model: DriveModel, problem: Problem) -> None:
    """Compile the kernels of search and driving, or load them: by a small search, and a short line from the start."""
    load_kernels()
    if any(problem.goal_tolerance):
        nearest_end(task_of(problem, Settings()), target_of(problem))
    load_driving_kernels(model, problem.start)


def load_driving_kernels(model: DriveModel, start: tuple[float, float, float]) -> None:
    """Compile the kernels of driving, or load them: by a short line from x, y [m] and yaw. [rad]

    Where that line cannot be driven, there is no plan, either.
    """
    x, y, yaw = start
    tangent = float(straight_tangent(model.pace, model.pace.forward, x, y, yaw))
    knots = np.array([0.0, SHORT * model.vehicle.contact_length])
    line = Line(False, (x, y, tangent), knots, np.zeros(2))
    with contextlib.suppress(UndrivableError):
        driven = drive_line(model, line)
        check_roughly(model, [line])
        check_clear(model, [driven])
