"""PSO-LM on one operating point: a swarm over the physical box, Levenberg-Marquardt from its best particles."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.lut.cell import TOLERANCE, Solver, evaluate, is_answer, residual_at, solve_from
from trackctl.mechanics.limits import FASTEST_TRACK, LARGEST_SIDESLIP, SLOWEST_TRACK
from trackctl.mechanics.operating_point import OperatingPoint
from trackctl.mechanics.parameters import TrackModel
from trackctl.mechanics.quadrature import Rule
from trackctl.solvers import levenberg_marquardt as lm
from trackctl.solvers import particle_swarm as pso
from trackctl.solvers.random_stream import Stream

Array = NDArray[np.float64]

SETTINGS = pso.Settings(iterations=10, first_inertia=0.9, last_inertia=0.3, cognitive=1.5, social=1.5)
PARTICLES = 16
#: Most particles that Levenberg-Marquardt starts from, best first.
STARTS = 8
#: Stop on the coarse balance, and most evaluations on either.
APPROACH, MOST_EVALUATIONS = 1e-4, 20
#: The swarm flies in asinh of slip and sideslip over these scales: roots lie at slips from thousandths to ones.
SLIP_SCALE = 0.01
SIDESLIP_SCALE = 0.02


class Searcher(NamedTuple):
    """What a thread needs for a search.

    Attributes
    ----------
    fine, coarse
        Solvers with the full quadrature, and with a coarse one for the swarm.
    flock
        The swarm.
    lower, upper, start
        Box of the swarm's coordinates, and unknowns of a particle, shape (3,).
    """

    fine: Solver
    coarse: Solver
    flock: pso.Swarm
    lower: Array
    upper: Array
    start: Array


@kernel
def searcher(fine: Solver, coarse_rule: Rule) -> Searcher:
    """A thread's searcher; both solvers share their scratch memory."""
    coarse = Solver(fine.model, coarse_rule, fine.lower, fine.upper, fine.work, fine.traction)
    return Searcher(fine, coarse, pso.swarm(PARTICLES, 3), np.empty(3), np.empty(3), np.empty(3))


@kernel
def no_slip_speed(model: TrackModel, curvature: float, track: int) -> float:
    """Speed ratio of a track (0 left, 1 right) that does not slip, kept in the physical box."""
    arm = (0.5 - track) * model.gauge - model.cog_left
    return min(max(1.0 - curvature * arm, 2.0 * SLOWEST_TRACK), 0.5 * FASTEST_TRACK)


@kernel
def no_slip(model: TrackModel, curvature: float, x: Array) -> None:
    """Track speed ratios without slip, and no sideslip, into x."""
    x[0] = no_slip_speed(model, curvature, 0)
    x[1] = no_slip_speed(model, curvature, 1)
    x[2] = 0.0


@kernel
def unknowns_of(model: TrackModel, curvature: float, position: Array, x: Array) -> None:
    """Track speed ratios and sideslip of a particle."""
    for track in range(2):
        x[track] = no_slip_speed(model, curvature, track) + SLIP_SCALE * math.sinh(position[track])
    x[2] = SIDESLIP_SCALE * math.sinh(position[2])


@kernel
def set_box(searcher: Searcher, curvature: float) -> None:
    """The physical box in the swarm's coordinates."""
    for track in range(2):
        centre = no_slip_speed(searcher.fine.model, curvature, track)
        searcher.lower[track] = math.asinh((SLOWEST_TRACK - centre) / SLIP_SCALE)
        searcher.upper[track] = math.asinh((FASTEST_TRACK - centre) / SLIP_SCALE)
    searcher.upper[2] = math.asinh(LARGEST_SIDESLIP / SIDESLIP_SCALE)
    searcher.lower[2] = -searcher.upper[2]


@kernel
def fly(searcher: Searcher, point: OperatingPoint, stream: Stream) -> None:
    """Let the swarm search the coarse balance; its particles' bests are the starts."""
    flock, work = searcher.flock, searcher.coarse.work
    set_box(searcher, point.curvature)
    pso.scatter(flock, searcher.lower, searcher.upper, stream)
    leader = 0
    for iteration in range(SETTINGS.iterations):
        for i in range(PARTICLES):
            unknowns_of(searcher.fine.model, point.curvature, flock.position[i], searcher.start)
            evaluate(searcher.coarse, point, searcher.start, work.residual, work.jacobian)
            leader = pso.record(flock, i, lm.sum_of_squares(work.residual), leader)
        inertia = pso.inertia_at(SETTINGS, iteration)
        pso.move(flock, leader, inertia, SETTINGS, searcher.lower, searcher.upper, stream)


@kernel
def search(searcher: Searcher, point: OperatingPoint, stream: Stream, x: Array) -> tuple[bool, float]:
    """PSO-LM: the root on the branch that goes on from low speed, wherever it lies in the physical box.

    Returns
    -------
    tuple of bool and float
        Whether it was found (x holds it, the solver's memory its balance), and the least residual met.
    """
    fly(searcher, point, stream)
    least = np.inf
    order = np.argsort(searcher.flock.cost)
    for k in range(STARTS):
        unknowns_of(searcher.fine.model, point.curvature, searcher.flock.best[order[k]], x)
        solve_from(searcher.coarse, point, x, APPROACH, MOST_EVALUATIONS)
        solved, _ = solve_from(searcher.fine, point, x, TOLERANCE, MOST_EVALUATIONS)
        least = min(least, lm.largest(searcher.fine.work.residual))
        if solved and is_answer(searcher.fine, x):
            return True, residual_at(searcher.fine, point, x)
    return False, least
