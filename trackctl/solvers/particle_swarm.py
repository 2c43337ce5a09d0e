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

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.solvers.random_stream import Stream, uniform

Array = NDArray[np.float64]


#: A record of the type `swarm(m, n)`.
Swarm = Any


def swarm(particles: int, dimensions: int) -> np.dtype[np.void]:
    """Memory of a swarm: each particle's position, velocity, the best place it has been at, and the cost there."""
    each = (particles, dimensions)
    return np.dtype(
        [
            ("position", np.float64, each),
            ("velocity", np.float64, each),
            ("best", np.float64, each),
            ("cost", np.float64, (particles,)),
        ],
        align=True,
    )


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
def scatter(flock: Swarm, lower: Array, upper: Array, stream: Stream) -> None:
    """Place the particles in the box, stratified in each dimension, at rest."""
    particles, dimensions = flock.position.shape
    for j in range(dimensions):
        # A random permutation of the strata: a Latin hypercube.
        for i in range(particles):
            flock.velocity[i, j] = i
        for i in range(particles - 1, 0, -1):
            k = int(uniform(stream) * (i + 1))
            kept = flock.velocity[i, j]
            flock.velocity[i, j] = flock.velocity[k, j]
            flock.velocity[k, j] = kept
        for i in range(particles):
            share = (flock.velocity[i, j] + uniform(stream)) / particles
            flock.position[i, j] = lower[j] + share * (upper[j] - lower[j])
            flock.velocity[i, j] = 0.0
    for i in range(particles):
        flock.cost[i] = np.inf


@kernel
def move(
    flock: Swarm, leader: int, inertia: float, settings: Settings, lower: Array, upper: Array, stream: Stream
) -> None:
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
        for j in range(flock.best.shape[1]):
            flock.best[particle, j] = flock.position[particle, j]
        if cost < flock.cost[leader]:
            return particle
    return leader


@inlined
def inertia_at(settings: Settings, iteration: int) -> float:
    """Inertia of a move, falling linearly over the iterations."""
    share = iteration / max(settings.iterations - 1, 1)
    return settings.first_inertia + share * (settings.last_inertia - settings.first_inertia)
