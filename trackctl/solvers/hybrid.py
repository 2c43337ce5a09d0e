"""PSO-LM: a swarm finds where to start, Levenberg-Marquardt solves from there; several starts give several roots."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.solvers import levenberg_marquardt as lm
from trackctl.solvers import particle_swarm as pso
from trackctl.solvers.levenberg_marquardt import levenberg_marquardt
from trackctl.solvers.particle_swarm import particle_swarm
from trackctl.solvers.random_stream import Stream
from trackctl.solvers.workspace import Workspace

Array = NDArray[np.float64]

#: Roots nearer to each other than this are one. [-, rad]
SAME_ROOT = 1e-6


class Settings(NamedTuple):
    """Of both parts.

    Attributes
    ----------
    swarm
        How the swarm moves.
    approach
        Stop of the solver on the swarm's (coarser) problem.
    polish
        Stop of the solver on the problem itself.
    starts
        Most particles that the solver starts from, best first.
    """

    swarm: pso.Settings
    approach: lm.Settings
    polish: lm.Settings
    starts: int


@kernel
def is_new(roots: Array, found: int, x: Array) -> bool:
    """Whether x differs from the first `found` rows."""
    for k in range(found):
        if np.max(np.abs(roots[k] - x)) < SAME_ROOT:
            return False
    return True


@kernel
def swarm_roots(
    evaluate: Any,
    coarse: Any,
    problem: Any,
    lower: Array,
    upper: Array,
    settings: Settings,
    stream: Stream,
    flock: pso.Swarm,
    work: Workspace,
    roots: Array,
) -> tuple[int, float]:
    """Roots of `problem` in a box, from a swarm on a coarser version of it.

    Parameters
    ----------
    evaluate
        Kernel `evaluate(problem, x, residual, jacobian)`.
    coarse, problem
        What the swarm searches, and what is solved.
    lower, upper
        Box, shape (n,).
    settings, stream, flock, work
        Of the swarm and the solver.
    roots
        Receives the distinct roots, shape (most roots, n).

    Returns
    -------
    tuple of int and float
        Number of roots found, and the least largest residual reached.
    """
    particle_swarm(evaluate, coarse, lower, upper, settings.swarm, stream, flock, work)
    order = np.argsort(flock.cost)
    x = np.empty(lower.size)
    found, best = 0, np.inf
    for k in range(min(settings.starts, order.size)):
        x[:] = flock.best[order[k]]
        levenberg_marquardt(evaluate, coarse, lower, upper, x, settings.approach, work)
        if found > 0 and not is_new(roots, found, x):
            continue
        solved, _ = levenberg_marquardt(evaluate, problem, lower, upper, x, settings.polish, work)
        best = min(best, lm.largest(work.residual))
        if solved and is_new(roots, found, x):
            roots[found] = x
            found += 1
            if found == roots.shape[0]:
                break
    return found, best
