"""Particle swarm: it stays in the box, remembers the best, can be repeated, and finds the deepest of many valleys."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from trackctl.solvers import levenberg_marquardt as lm
from trackctl.solvers import particle_swarm as pso
from trackctl.solvers.random_stream import stream
from trackctl.solvers.workspace import workspace

Array = NDArray[np.float64]

SETTINGS = pso.Settings(iterations=60, first_inertia=0.9, last_inertia=0.3, cognitive=1.5, social=1.5)
LOWER, UPPER = np.array([-5.12, -4.0, -5.12]), np.array([5.12, 5.12, 3.0])
PARTICLES = 30


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """What a swarm did: every position, the leader's cost after each iteration, and where it ended."""

    positions: Array
    best_costs: list[float]
    flock: pso.Swarm
    leader: int


def fly(cost: Callable[[Array], float], seed: int, index: int = 0, settings: pso.Settings = SETTINGS) -> Flight:
    """The loop of the module's description."""
    flock = np.zeros(1, pso.swarm(PARTICLES, 3))[0]
    draws = stream(seed, index)
    pso.scatter(flock, LOWER, UPPER, draws)
    positions, best_costs, leader = [], [], 0
    for iteration in range(settings.iterations):
        positions.append(flock["position"].copy())
        for i in range(PARTICLES):
            leader = pso.record(flock, i, cost(flock["position"][i]), leader)
        best_costs.append(float(flock["cost"][leader]))
        pso.move(flock, leader, pso.inertia_at(settings, iteration), settings, LOWER, UPPER, draws)
    return Flight(np.array(positions), best_costs, flock, leader)


def sphere(x: Array) -> float:
    return float(np.sum((x - 1.0) ** 2))


def rastrigin(x: Array) -> float:
    return float(10.0 * x.size + np.sum(x**2 - 10.0 * np.cos(2.0 * math.pi * x)))


def rastrigin_gradient(x: Array) -> Array:
    return 2.0 * x + 20.0 * math.pi * np.sin(2.0 * math.pi * x)


def polished(x: Array) -> Array:
    """Nearest zero of Rastrigin's gradient, by Levenberg-Marquardt."""
    x, work, damping = x.copy(), np.zeros(1, workspace(3))[0], 0.0

    def evaluate(at: Array, prefix: str) -> None:
        work[f"{prefix}residual"][:] = rastrigin_gradient(at)
        work[f"{prefix}jacobian"][:] = np.diag(2.0 + 40.0 * math.pi**2 * np.cos(2.0 * math.pi * at))

    evaluate(x, "")
    while not lm.is_solved(work, 1e-10) and damping < lm.LARGEST_DAMPING:
        if lm.propose(x, damping, LOWER, UPPER, work):
            evaluate(work["trial"], "trial_")
            damping = lm.judge(x, damping, work)
        else:
            damping = lm.more_damping(damping)
    return x


@pytest.mark.parametrize(
    "cost", [sphere, rastrigin, lambda x: -float(np.sum(x))], ids=["sphere", "Rastrigin", "corner"]
)
def test_particles_stay_in_the_box(cost: Callable[[Array], float]) -> None:
    positions = fly(cost, 1).positions
    assert (positions >= LOWER).all()
    assert (positions <= UPPER).all()


def test_particles_start_stratified_and_at_rest() -> None:
    flock = np.zeros(1, pso.swarm(PARTICLES, 3))[0]
    pso.scatter(flock, LOWER, UPPER, stream(4, 0))
    strata = np.floor((flock["position"] - LOWER) / (UPPER - LOWER) * PARTICLES)
    for column in strata.T:
        assert sorted(column) == list(range(PARTICLES))
    assert not flock["velocity"].any()
    assert np.isinf(flock["cost"]).all()


def test_strata_are_dealt_anew_in_every_dimension_and_stream() -> None:
    def order(index: int) -> NDArray[np.intp]:
        flock = np.zeros(1, pso.swarm(PARTICLES, 3))[0]
        pso.scatter(flock, LOWER, UPPER, stream(4, index))
        return np.argsort(flock["position"], axis=0)

    one, other = order(0), order(1)
    assert not np.array_equal(one[:, 0], one[:, 1])
    assert not np.array_equal(one, other)


def test_best_cost_never_rises_and_is_the_best_seen() -> None:
    flight = fly(rastrigin, 2)
    assert all(later <= earlier for earlier, later in pairwise(flight.best_costs))
    seen = np.array([[rastrigin(x) for x in swarm] for swarm in flight.positions])
    np.testing.assert_array_equal(flight.flock["cost"], seen.min(axis=0))
    assert flight.best_costs[-1] == seen.min() == rastrigin(flight.flock["best"][flight.leader])


def test_a_stream_gives_the_same_flight_again_and_another_one_another() -> None:
    flight, again, other = fly(rastrigin, 5, 1), fly(rastrigin, 5, 1), fly(rastrigin, 5, 2)
    np.testing.assert_array_equal(flight.positions, again.positions)
    assert not np.array_equal(flight.positions, other.positions)


def test_a_particle_that_meets_the_box_stops_there() -> None:
    flock = np.zeros(1, pso.swarm(PARTICLES, 3))[0]
    pso.scatter(flock, LOWER, UPPER, stream(0, 0))
    flock["best"][:] = flock["position"]
    flock["velocity"][:] = 100.0
    pso.move(flock, 0, 1.0, SETTINGS, LOWER, UPPER, stream(0, 1))
    np.testing.assert_array_equal(flock["position"], np.tile(UPPER, (PARTICLES, 1)))
    assert flock["velocity"].max() <= (UPPER - LOWER).max()


def test_nan_is_never_the_best() -> None:
    flock = np.zeros(1, pso.swarm(PARTICLES, 3))[0]
    pso.scatter(flock, LOWER, UPPER, stream(0, 0))
    assert pso.record(flock, 3, math.nan, 0) == 0
    assert math.isinf(flock["cost"][3])
    assert pso.record(flock, 3, 1.0, 0) == 3


def test_inertia_falls_linearly_from_first_to_last() -> None:
    inertias = [pso.inertia_at(SETTINGS, k) for k in range(SETTINGS.iterations)]
    assert inertias[0] == 0.9
    assert inertias[-1] == pytest.approx(0.3, rel=1e-15)
    np.testing.assert_allclose(np.diff(inertias), -0.6 / (SETTINGS.iterations - 1), rtol=1e-10)
    assert pso.inertia_at(SETTINGS._replace(iterations=1), 0) == 0.9


def test_a_bowl_is_searched_to_its_bottom() -> None:
    flight = fly(sphere, 0)
    assert flight.best_costs[-1] < 1e-6 * flight.best_costs[0]


def test_global_valley_is_found_by_most_seeds_and_its_bottom_by_polishing() -> None:
    ends = [fly(rastrigin, seed) for seed in range(50)]
    bottoms = [polished(flight.flock["best"][flight.leader]) for flight in ends]
    # Hundreds of valleys: to find the deepest with half of the seeds is far from chance.
    found = sum(bool(np.abs(x).max() < 1e-9) for x in bottoms)
    assert found >= 25
