"""Following a branch of solutions to where it ends: the evidence that a cell is infeasible."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.lut.cell import Solver, evaluate, model_of
from trackctl.mechanics.limits import ADMISSIBLE, GRIP, exceeded_limit, outside_box
from trackctl.mechanics.operating_point import OperatingPoint, operating_point
from trackctl.solvers import continuation
from trackctl.solvers import levenberg_marquardt as lm

Array = NDArray[np.float64]

#: How a trace ends; a positive end is a code of `trackctl.mechanics.limits`.
REACHED, LOST = 0, -1

TOLERANCE = 1e-9
MOST_STEPS = 120
MOST_CORRECTIONS = 5


class Way(NamedTuple):
    """A straight way through operating points, from parameter 0 to 1, at one slope [rad] and curvature [1/m].

    Velocities [m/s] and headings [rad] change linearly.
    """

    slope: float
    curvature: float
    first_velocity: float
    last_velocity: float
    first_heading: float
    last_heading: float


@kernel
def point_at(solver: Solver, way: Way, parameter: float) -> OperatingPoint:
    """Operating point on the way."""
    velocity = way.first_velocity + parameter * (way.last_velocity - way.first_velocity)
    heading = way.first_heading + parameter * (way.last_heading - way.first_heading)
    return operating_point(model_of(solver), way.slope, velocity, way.curvature, heading)


@kernel
def border(solver: Solver, way: Way, line: continuation.Curve) -> None:
    """Balance at the curve's point into `solver.work`, and the bordered system."""
    work, x, parameter = solver.work, line.point[:3], line.point[3]
    beside = point_at(solver, way, parameter + continuation.DIFFERENCE)
    evaluate(solver, beside, x, work.trial_residual, work.trial_jacobian)
    evaluate(solver, point_at(solver, way, parameter), x, work.residual, work.jacobian)
    continuation.border(line, work.jacobian, work.residual, work.trial_residual)


@kernel
def corrected(solver: Solver, way: Way, line: continuation.Curve) -> bool:
    """Bring the predicted point back to the branch; the bordered system is that of the point found."""
    for _ in range(MOST_CORRECTIONS):
        border(solver, way, line)
        if lm.is_solved(solver.work, TOLERANCE):
            return True
        if not continuation.correct(line):
            return False
    return False


@kernel
def limit_of(solver: Solver, way: Way, line: continuation.Curve) -> int:
    """The limit that the curve's point exceeds; leaving the physical box is want of grip."""
    x = line.point[:3]
    exceeded = exceeded_limit(model_of(solver), point_at(solver, way, line.point[3]), x)
    if exceeded == ADMISSIBLE and outside_box(x):
        return GRIP
    return exceeded


@kernel
def follow(solver: Solver, way: Way, x: Array) -> int:
    """Follow the root x from the way's first operating point towards its last.

    Returns
    -------
    int
        `REACHED`; or the limit at which the branch ends on the way (a fold is want of grip); or `LOST`. x holds the
        last root found.
    """
    line = solver.curve
    continuation.start(line, x)
    border(solver, way, line)
    if not continuation.turn(line):
        return LOST
    step = continuation.FIRST_STEP
    for _ in range(MOST_STEPS):
        if continuation.has_folded(line):
            return GRIP
        step = min(step, (1.0 - line.point[3]) / line.tangent[3])
        continuation.predict(line, step)
        if not corrected(solver, way, line):
            continuation.step_back(line)
            step *= continuation.SHRINK
            if step < continuation.SMALLEST_STEP:
                return LOST
            continue
        for i in range(3):
            x[i] = line.point[i]
        exceeded = limit_of(solver, way, line)
        if exceeded != ADMISSIBLE:
            return exceeded
        if line.point[3] >= 1.0 - 1e-9:
            return REACHED
        if not continuation.turn(line):
            return LOST
        step = min(continuation.GROW * step, continuation.LARGEST_STEP)
    return LOST
