"""Following a branch of solutions to where it ends: the evidence that a cell is infeasible."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import carray  # type: ignore[attr-defined]
from numpy.typing import NDArray

from trackctl.compiled import call_by_address, inlined, kernel, procedure
from trackctl.lut.cell import (
    FOLLOW,
    POINT_SIZE,
    SOLVER,
    Solver,
    branch_sign,
    evaluate,
    model_of,
    near_no_slip,
    residuals,
    set_point,
    solve_cold,
    solve_warm,
)
from trackctl.lut.cell import TOLERANCE as SOLVED
from trackctl.mechanics.limits import GRIP, exceeded_limit, outside_box
from trackctl.mechanics.operating_point import OperatingPoint
from trackctl.solvers import continuation
from trackctl.solvers import levenberg_marquardt as lm

Array = NDArray[np.float64]

#: How a trace ends; a positive end is a code of `trackctl.mechanics.limits`.
REACHED, LOST = 0, -1

#: Largest residual of the points on the way, which only show where the branch goes; beyond `NEAR_END` they are answers.
TOLERANCE = 1e-5
NEAR_END = 0.99
MOST_STEPS = 120
MOST_CORRECTIONS = 6

call_follow = call_by_address(FOLLOW)


class Way(NamedTuple):
    """From one operating point to another, from parameter 0 to 1: all five quantities change linearly."""

    first: OperatingPoint
    last: OperatingPoint


@inlined
def point_at(way: Way, parameter: float) -> OperatingPoint:
    """Operating point on the way."""
    a, b = way.first, way.last
    return OperatingPoint(
        a.gravity_forward + parameter * (b.gravity_forward - a.gravity_forward),
        a.gravity_left + parameter * (b.gravity_left - a.gravity_left),
        a.normal + parameter * (b.normal - a.normal),
        a.curvature + parameter * (b.curvature - a.curvature),
        a.centripetal + parameter * (b.centripetal - a.centripetal),
    )


@kernel
def corrected(solver: Solver, way: Way, line: continuation.Curve, tolerance: float) -> bool:
    """Bring the predicted point back to the branch; `solver.work` holds the balance there.

    The derivative by the parameter is that of the last point: a chord, which the residual corrects.
    """
    work = solver.work
    for _ in range(MOST_CORRECTIONS):
        evaluate(solver, point_at(way, line.point[3]), line.point[:3], work.residual, work.jacobian)
        if lm.is_solved(work, tolerance):
            return True
        continuation.border(line, work.jacobian, work.residual)
        if not continuation.correct(line):
            return False
    return False


@kernel
def turned(solver: Solver, way: Way, line: continuation.Curve) -> bool:
    """Turn the tangent at the curve's point, whose balance `solver.work` holds; False where the branch has none."""
    work = solver.work
    beside = point_at(way, line.point[3] + continuation.DIFFERENCE)
    set_point(solver, beside)
    residuals(solver, line.point[:3], work.trial_residual)
    continuation.differentiate(line, work.residual, work.trial_residual)
    continuation.border(line, work.jacobian, work.residual)
    return continuation.turn(line)


@kernel
def exceeded_at(solver: Solver, way: Way, line: continuation.Curve) -> int:
    """The limit exceeded at the curve's point, or `ADMISSIBLE`, which is 0."""
    return exceeded_limit(model_of(solver), point_at(way, line.point[3]), line.point[:3])


@kernel
def trace(solver: Solver, way: Way, x: Array) -> int:
    """`follow`, compiled into each of its callers."""
    line = solver.curve
    continuation.start(line, x)
    evaluate(solver, point_at(way, 0.0), x, solver.work.residual, solver.work.jacobian)
    if not turned(solver, way, line):
        return LOST
    step = continuation.FIRST_STEP
    for _ in range(MOST_STEPS):
        if continuation.has_folded(line):
            return exceeded_at(solver, way, line) or GRIP
        rest = continuation.way_to_go(line)
        at_end = rest <= step
        if at_end:
            continuation.predict_end(line)
        else:
            continuation.predict(line, step)
        tolerance = SOLVED if line.point[3] > NEAR_END else TOLERANCE
        kept = corrected(solver, way, line, tolerance) and line.point[3] <= 1.0
        if not kept or (at_end and branch_sign(solver.work.jacobian) <= 0.0):
            continuation.step_back(line)
            step = continuation.SHRINK * min(step, rest)
            if step < continuation.SMALLEST_STEP:
                return exceeded_at(solver, way, line) or LOST
            continue
        for i in range(3):
            x[i] = line.point[i]
        if outside_box(x):
            return exceeded_at(solver, way, line) or GRIP
        if at_end:
            return REACHED
        if not turned(solver, way, line):
            return LOST
        step = min(continuation.GROW * step, continuation.LARGEST_STEP)
    return exceeded_at(solver, way, line) or LOST


@procedure(FOLLOW)
def follow_there(memory, ends, unknowns):  # type: ignore[no-untyped-def]
    """`trace` by address; `ends` are the fields of the way's operating points."""
    e = carray(ends, 2 * POINT_SIZE)
    way = Way(OperatingPoint(e[0], e[1], e[2], e[3], e[4]), OperatingPoint(e[5], e[6], e[7], e[8], e[9]))
    return trace(carray(memory, 1, SOLVER)[0], way, carray(unknowns, 3))


@kernel
def follow(solver: Solver, way: Way, x: Array) -> int:
    """Follow the root x from the way's first operating point towards its last.

    The branch may leave the model's limits on the way and come back. It ends at its fold, or at the physical box.

    Returns
    -------
    int
        `REACHED`; or the limit exceeded where the branch ends (else `GRIP`); or `LOST`. x holds the last root found,
        within `TOLERANCE`, and `solver.curve.point[3]` the parameter there.
    """
    for i, value in enumerate(way.first):
        solver.way[i] = value
    for i, value in enumerate(way.last):
        solver.way[POINT_SIZE + i] = value
    return int(call_follow(solver.follow, solver.numbers.ctypes, solver.way.ctypes, x.ctypes))


@kernel
def settle(solver: Solver, point: OperatingPoint, x: Array) -> int:
    """Decide an operating point by following the branch from driving straight on level ground.

    Returns
    -------
    int
        `REACHED`, and x holds the answer and `solver.work` its balance; or the limit exceeded where the branch ends; or
        `LOST`.
    """
    level = OperatingPoint(0.0, 0.0, point.normal, 0.0, 0.0)
    near_no_slip(model_of(solver), 0.0, x)
    if not solve_cold(solver, level, x):
        return GRIP
    end = follow(solver, Way(level, point), x)
    if end != REACHED:
        return end
    return REACHED if solve_warm(solver, point, x) else LOST
