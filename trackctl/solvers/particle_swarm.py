"""Particle swarm in a box: global search whose inertia falls, so that it ends as a local one.

The parts of the method, for a loop that evaluates the cost itself (see `levenberg_marquardt`)::

    scatter(flock, lower, upper, stream)
    for iteration in range(settings.iterations):
        for i in range(particles):
            leader = record(flock, i, cost(flock.position[i]), leader)
        move(flock, leader, inertia_at(settings, iteration), settings, lower, upper, stream)

References
----------
.. [1] Kennedy, Eberhart, Particle swarm optimization, 1995, doi 10.1109/ICNN.1995.488968.
.. [2] Shi, Eberhart, A modified particle swarm optimizer (inertia weight), 1998, doi 10.1109/ICEC.1998.699146.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.solvers.random_stream import Stream, uniform

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
def record(flock: Swarm, particle: int, cost: float, leader: int) -> int:
    """Note what a particle's position costs; the particle that now leads the swarm."""
    if cost < flock.cost[particle]:
        flock.cost[particle] = cost
        flock.best[particle] = flock.position[particle]
        if cost < flock.cost[leader]:
            return particle
    return leader


@kernel
def inertia_at(settings: Settings, iteration: int) -> float:
    """Inertia of a move, falling linearly over the iterations."""
    share = iteration / max(settings.iterations - 1, 1)
    return settings.first_inertia + share * (settings.last_inertia - settings.first_inertia)
