import math

import numpy as np
import pytest
from planning_cases import RADIUS, hits, level_limits, level_problem, pose_error, route_poses

from trackctl.planning.route import Route
from trackctl.planning.search import Search, Settings, search, task_of
from trackctl.planning.simplification import MOST_LOSS, simplified

EMPTY = np.zeros((200, 200), bool)


def test_a_way_in_many_pieces_becomes_a_turn_a_straight_and_a_turn():
    """Turns in slightly changing radii: a connection of three pieces is all but as short."""
    turn = np.linspace(0.98, 1.0, 8) / RADIUS
    curvature = np.concatenate((turn, np.zeros(4), -turn))
    route = Route(
        (3.0, 3.0, 0.0), curvature, np.concatenate((np.full(8, 0.2), np.full(4, 1.5), np.full(8, 0.25))), 0 * curvature
    )
    goal = route_poses(route)[-1]
    problem = level_problem(EMPTY, route.start, tuple(goal))
    found, cost = simplified(task_of(problem, Settings()), route)
    assert found.length.size == 3
    assert pose_error(route_poses(found)[-1], goal) < 1e-9
    assert np.abs(found.length).sum() == pytest.approx(cost)
    assert cost <= (1.0 + MOST_LOSS) * route.length.sum()


def forest(seed):
    blocked = np.zeros((200, 200), bool)
    for i, j in np.random.default_rng(seed).integers(0, 190, (18, 2)):
        blocked[i : i + 10, j : j + 10] = True
    blocked[:40, :40] = blocked[-40:, -40:] = False
    return blocked


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_polished_way_keeps_its_ends_its_clearance_and_nearly_its_cost(seed, backwards):
    more = {"backward": level_limits()} if backwards else {}
    problem = level_problem(forest(seed), (2.0, 2.0, 0.5 * math.pi), (18.0, 18.0, 0.0), **more)
    polished = search(problem, Settings(iterations=1500))
    task = task_of(problem, Settings())
    found, cost = simplified(task, polished.route)
    assert found.length.size < polished.route.length.size
    assert cost <= (1.0 + MOST_LOSS) * polished.cost
    poses = route_poses(found)
    assert pose_error(poses[-1], problem.goal) < 1e-9
    assert not hits(problem.grid, problem.footprint, poses).any()
    again, same = simplified(task, polished.route)
    assert same == cost
    assert np.array_equal(again.length, found.length)


def test_what_has_few_pieces_is_left_alone():
    problem = level_problem(EMPTY, (3.0, 3.0, 0.0), (17.0, 15.0, 1.0))
    route = search(problem, Settings(iterations=300)).route
    found, _ = simplified(task_of(problem, Settings()), route)
    assert np.array_equal(found.length, route.length)
    assert np.array_equal(found.curvature, route.curvature)


def test_what_turns_on_the_spot_is_left_alone():
    problem = level_problem(EMPTY, (10.0, 10.0, 0.0), (10.0, 10.0, 2.0), pivot_speed=1.0)
    found = Search(problem, Settings())
    found.go_on(100, None)
    best = found.improvements[-1]
    assert best.route.pivot.any()
    assert found.with_fewer_pieces(best) is best
