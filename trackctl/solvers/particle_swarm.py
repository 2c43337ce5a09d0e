"""Particle swarm in a box: global search whose inertia falls, so that it ends as a local one.

References
----------
.. [1] Kennedy, Eberhart, Particle swarm optimization, 1995, doi 10.1109/ICNN.1995.488968.
.. [2] Shi, Eberhart, A modified particle swarm optimizer (inertia weight), 1998, doi 10.1109/ICEC.1998.699146.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.solvers.levenberg_marquardt import sum_of_squares
from trackctl.solvers.random_stream import Stream, uniform
from trackctl.solvers.workspace import Workspace

Array = NDArray[np.float64]


class Swarm(NamedTuple):
    """State of a swarm of m particles in n dimensions.

    Attributes
    ----------
    position, velocity, best
        Of each particle, shape (m, n); `best` is where it was at its least cost.
    cost
        Least cost of each particle, shape (m,).
    """

    position: Array
    velocity: Array
    best: Array
    cost: Array


class Settings(NamedTuple):
    """How a swarm moves.

    Attributes
    ----------
    iterations
        Number of moves of the whole swarm.
    first_inertia, last_inertia
        Share of the velocity kept, falling linearly from global to local search.
    cognitive, social
        Pull towards the particle's and the swarm's best.
    """

    iterations: int
    first_inertia: float
    last_inertia: float
    cognitive: float
    social: float


@kernel
def swarm(particles: int, dimensions: int) -> Swarm:
    """Memory of a swarm."""
    return Swarm(
        np.empty((particles, dimensions)),
        np.empty((particles, dimensions)),
        np.empty((particles, dimensions)),
        np.empty(particles),
    )


@kernel
def scatter(flock: Swarm, lower: Array, upper: Array, stream: Stream) -> None:
    """Place the particles in the box, stratified in each dimension, at rest."""
    particles, dimensions = flock.position.shape
    for j in range(dimensions):
        # A random permutation of the strata: a Latin hypercube.
        for i in range(particles):
            flock.velocity[i, j] = i
        for i in range(particles - 1, 0, -1):
            k = int(uniform(stream) * (i + 1))
            flock.velocity[i, j], flock.velocity[k, j] = flock.velocity[k, j], flock.velocity[i, j]
        for i in range(particles):
            share = (flock.velocity[i, j] + uniform(stream)) / particles
            flock.position[i, j] = lower[j] + share * (upper[j] - lower[j])
            flock.velocity[i, j] = 0.0
    flock.cost[:] = np.inf


@kernel
def move(flock: Swarm, leader: int, inertia: float, settings: Settings, lower: Array, upper: Array, stream: Stream) -> None:
    """Move every particle once; one that meets the box stops there."""
    particles, dimensions = flock.position.shape
    for i in range(particles):
        for j in range(dimensions):
            here = flock.position[i, j]
            velocity = (
                inertia * flock.velocity[i, j]
                + settings.cognitive * uniform(stream) * (flock.best[i, j] - here)
                + settings.social * uniform(stream) * (flock.best[leader, j] - here)
            )
            there = min(max(here + velocity, lower[j]), upper[j])
            flock.velocity[i, j] = there - here
            flock.position[i, j] = there


@kernel
def particle_swarm(
    evaluate: Any,
    problem: Any,
    lower: Array,
    upper: Array,
    settings: Settings,
    stream: Stream,
    flock: Swarm,
    work: Workspace,
) -> int:
    """Search the box for the least sum of squares of `evaluate(problem, x, residual, jacobian)`.

    Returns
    -------
    int
        The particle whose best is the swarm's; every particle's best stays in `flock` as a start for a local solver.
    """
    scatter(flock, lower, upper, stream)
    leader = 0
    for iteration in range(settings.iterations + 1):
        for i in range(flock.cost.size):
            evaluate(problem, flock.position[i], work.residual, work.jacobian)
            cost = sum_of_squares(work.residual)
            if cost < flock.cost[i]:
                flock.cost[i] = cost
                flock.best[i] = flock.position[i]
                if cost < flock.cost[leader]:
                    leader = i
        if iteration < settings.iterations:
            share = iteration / max(settings.iterations - 1, 1)
            inertia = settings.first_inertia + share * (settings.last_inertia - settings.first_inertia)
            move(flock, leader, inertia, settings, lower, upper, stream)
    return leader
