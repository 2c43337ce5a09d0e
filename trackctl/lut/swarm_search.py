"""PSO-LM on one operating point: a swarm over the physical box, Levenberg-Marquardt from its best particles."""

from __future__ import annotations

import math

import numpy as np
from numba import carray  # type: ignore[attr-defined]
from numpy.typing import NDArray

from trackctl.compiled import call_by_address, kernel, procedure
from trackctl.lut.cell import (
    PARTICLES,
    SEARCH,
    SLIP_SCALE,
    SOLVER,
    TOLERANCE,
    Effort,
    Solver,
    is_answer,
    model_of,
    no_slip_speed,
    point_in,
    residual_at,
    residuals,
    set_point,
    solve_from,
)
from trackctl.mechanics.limits import FASTEST_TRACK, LARGEST_SIDESLIP, SLOWEST_TRACK
from trackctl.mechanics.operating_point import OperatingPoint
from trackctl.mechanics.parameters import TrackModel
from trackctl.solvers import levenberg_marquardt as lm
from trackctl.solvers import particle_swarm as pso
from trackctl.solvers.random_stream import Stream

Array = NDArray[np.float64]

call_search = call_by_address(SEARCH)

SETTINGS = pso.Settings(iterations=10, first_inertia=0.9, last_inertia=0.3, cognitive=1.5, social=1.5)
#: Most particles that Levenberg-Marquardt starts from, best first.
STARTS = 8
#: On the coarse balance, and then on the fine one.
APPROACH, POLISH = Effort(1e-4, 20), Effort(TOLERANCE, 20)
#: Answers of a larger sideslip than this may have a rival of smaller sideslip. [rad]
SURELY_SMALLEST = math.radians(20.0)
#: The swarm flies in asinh of slip over `SLIP_SCALE` and of sideslip over this: roots lie at slips from thousandths to
#: ones.
SIDESLIP_SCALE = 0.02


@kernel
def unknowns_of(model: TrackModel, curvature: float, position: Array, x: Array) -> None:
    """Track speed ratios and sideslip of a particle."""
    for track in range(2):
        x[track] = no_slip_speed(model, curvature, track) + SLIP_SCALE * math.sinh(position[track])
    x[2] = SIDESLIP_SCALE * math.sinh(position[2])


@kernel
def set_box(solver: Solver, model: TrackModel, curvature: float) -> None:
    """The physical box in the swarm's coordinates."""
    for track in range(2):
        centre = no_slip_speed(model, curvature, track)
        solver.flock_lower[track] = math.asinh((SLOWEST_TRACK - centre) / SLIP_SCALE)
        solver.flock_upper[track] = math.asinh((FASTEST_TRACK - centre) / SLIP_SCALE)
    solver.flock_upper[2] = math.asinh(LARGEST_SIDESLIP / SIDESLIP_SCALE)
    solver.flock_lower[2] = -solver.flock_upper[2]


@kernel
def fly(solver: Solver, point: OperatingPoint, stream: Stream, x: Array) -> None:
    """Let the swarm search the coarse balance; its particles' bests are the starts."""
    model, flock, work = model_of(solver), solver.flock, solver.work
    set_point(solver, point)
    set_box(solver, model, point.curvature)
    pso.scatter(flock, solver.flock_lower, solver.flock_upper, stream)
    leader = int(np.int64(0))  # no literal: numba would compile the loop's kernels for it, too
    for iteration in range(SETTINGS.iterations):
        for i in range(PARTICLES):
            unknowns_of(model, point.curvature, flock.position[i], x)
            residuals(solver, x, work.residual)
            leader = pso.record(flock, i, lm.sum_of_squares(work.residual), leader)
        inertia = pso.inertia_at(SETTINGS, iteration)
        pso.move(flock, leader, inertia, SETTINGS, solver.flock_lower, solver.flock_upper, stream)


@kernel
def take_cheapest(cost: Array) -> int:
    """Index of the least cost, which is not given again."""
    cheapest = 0
    for i in range(cost.size):
        if cost[i] < cost[cheapest]:
            cheapest = i
    cost[cheapest] = np.inf
    return cheapest


@kernel
def fly_and_improve(solver: Solver, point: OperatingPoint, stream: Stream, x: Array) -> tuple[bool, float]:
    """`search`, compiled into each of its callers."""
    solver.coarse = True
    fly(solver, point, stream, x)
    least, smallest = np.inf, np.inf
    root = solver.root
    for _ in range(STARTS):
        unknowns_of(model_of(solver), point.curvature, solver.flock.best[take_cheapest(solver.flock.cost)], x)
        solver.coarse = True
        solve_from(solver, point, x, APPROACH)
        solver.coarse = False
        solved = solve_from(solver, point, x, POLISH)
        least = min(least, lm.largest(solver.work.residual))
        if solved and is_answer(solver, x) and abs(x[2]) < smallest:
            smallest = abs(x[2])
            for i in range(3):
                root[i] = x[i]
            if smallest < SURELY_SMALLEST:
                break
    if smallest == np.inf:
        return False, least
    for i in range(3):
        x[i] = root[i]
    return True, residual_at(solver, point, x)


@procedure(SEARCH)
def search_there(memory, stream, unknowns):  # type: ignore[no-untyped-def]
    """`fly_and_improve` by address, for the operating point that was set."""
    solver = carray(memory, 1, SOLVER)[0]
    found, solver.least = fly_and_improve(solver, point_in(solver), carray(stream, 1), carray(unknowns, 3))
    return int(found)


@kernel
def search(solver: Solver, point: OperatingPoint, stream: Stream, x: Array) -> tuple[bool, float]:
    """PSO-LM: the root on the branch that goes on from low speed, wherever it lies in the physical box.

    Returns
    -------
    tuple of bool and float
        Whether it was found (x holds it, the solver's memory its balance), and the least residual met.
    """
    set_point(solver, point)
    found = call_search(solver.search, solver.numbers.ctypes, stream.ctypes, x.ctypes)
    return bool(found), float(solver.least)
