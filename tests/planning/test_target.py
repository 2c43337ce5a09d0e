"""Ends within a tolerance of the goal: closed forms in an empty room, walls about the goal, leads and sideslip."""

import math

import numpy as np
import pytest
from planning_cases import RADIUS, RECTANGLE, grid_of, hits, level_limits, level_problem, plane, route_poses

from trackctl.planning.dubins import dubins_length
from trackctl.planning.families import distance_to_point
from trackctl.planning.search import Problem, Settings, search, target_of
from trackctl.planning.steering_limits import SteeringLimits
from trackctl.planning.target import poses_within

EMPTY = np.zeros((120, 120), bool)
START = (2.0, 6.0, 0.0)
SETTINGS = Settings(iterations=1500)


def walled(first=80, last=120):
    blocked = EMPTY.copy()
    blocked[:, first:last] = True
    return blocked


def best(problem, settings=SETTINGS):
    """The best improvement, once it is sure that it ends where it says, within the tolerance, and touches nothing."""
    found = search(problem, settings).improvements[-1]
    poses, (x, y, yaw), lead = route_poses(found.route), found.goal, problem.goal_lead
    assert poses[-1][:2] == pytest.approx((x - lead * math.cos(yaw), y - lead * math.sin(yaw)), abs=1e-9)
    assert math.remainder(poses[-1][2] - yaw, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert math.dist((x, y), problem.goal[:2]) <= problem.goal_tolerance[0]
    assert abs(math.remainder(yaw - problem.goal[2], 2.0 * math.pi)) <= problem.goal_tolerance[1]
    assert not hits(problem.grid, problem.footprint, [*poses, found.goal]).any()
    return found


@pytest.mark.parametrize(("distance", "turn"), [(1.0, 0.0), (0.3, 0.2), (0.0, math.pi)])
def test_straight_ahead_the_way_is_shorter_by_the_tolerance(distance, turn):
    """Turned round, and off by a distance: where any yaw will do, the goal behind a wrong yaw is just ahead."""
    wrong = math.pi if turn == math.pi else 0.0
    problem = level_problem(EMPTY, START, (9.0, 6.0, wrong), goal_tolerance=(distance, turn))
    assert best(problem).cost == pytest.approx(7.0 - distance, rel=1e-3)


def test_any_yaw_makes_it_a_way_to_a_point():
    problem = level_problem(EMPTY, (6.0, 6.0, 0.0), (7.0, 9.5, -2.5), goal_tolerance=(0.0, math.pi))
    shortest = distance_to_point(6.0, 6.0, 0.0, 7.0, 9.5, RADIUS)
    assert best(problem, Settings(iterations=6000)).cost == pytest.approx(shortest, rel=1e-3)
    assert shortest < 0.7 * dubins_length(*problem.start, *problem.goal, RADIUS)


@pytest.mark.parametrize("seed", range(3))
def test_a_tolerance_never_costs(seed):
    blocked = walled(55, 65)
    blocked[70:90, 55:65] = False
    settings = Settings(seed=seed, iterations=6000)
    costs = [
        best(level_problem(blocked, START, (10.0, 3.0, 0.5), goal_tolerance=tolerance), settings).cost
        for tolerance in ((0.0, 0.0), (0.1, 0.1), (0.5, 0.5), (1.0, math.pi))
    ]
    assert costs == sorted(costs, reverse=True)


def test_a_goal_in_a_wall_ends_clear_of_it():
    goal = (7.6, 6.0, 0.0)  # the footprint reaches 0.1 m into the wall
    assert "goal: the footprint touches" in search(level_problem(walled(), START, goal), SETTINGS).reason
    assert (
        "goal: the footprint touches"
        in search(level_problem(walled(), START, goal, goal_tolerance=(0.09, 0.0)), SETTINGS).reason
    )
    for lead in (0.0, 0.4):
        best(level_problem(walled(), START, goal, goal_tolerance=(0.3, 0.0), goal_lead=lead))


def test_a_goal_that_is_reached_backwards_is_led_in_from_its_other_side():
    """Forwards it would be from inside the wall."""
    start, goal = (2.0, 6.0, math.pi), (7.6, 6.0, math.pi)
    ends = {"goal_tolerance": (0.3, 0.0), "backward": level_limits()}
    found = best(level_problem(walled(), start, goal, gears=(-1, -1), goal_lead=-0.4, **ends))
    assert (found.route.length < 0.0).all()
    assert search(level_problem(walled(), start, goal, gears=(1, 1), goal_lead=0.4, **ends), SETTINGS).route is None


def test_a_goal_that_walls_close_off_is_met_beside_them():
    blocked = EMPTY.copy()
    blocked[40:80, 60:62] = blocked[40:80, 98:100] = blocked[40:42, 60:100] = blocked[78:80, 60:100] = True
    goal = (8.0, 6.0, 0.0)
    assert "close off" in search(level_problem(blocked, START, goal), SETTINGS).reason
    assert "close off" in search(level_problem(blocked, START, goal, goal_tolerance=(0.5, 3.0)), SETTINGS).reason
    best(level_problem(blocked, START, goal, goal_tolerance=(2.8, 0.5)), Settings(iterations=4000))


def test_no_tolerance_is_the_exact_goal_byte_for_byte():
    problem = level_problem(walled(55, 65), START, (4.0, 10.0, 2.0))
    zeros = level_problem(walled(55, 65), START, (4.0, 10.0, 2.0), goal_tolerance=(0.0, 0.0))
    first, second = (search(each, SETTINGS).improvements[-1] for each in (problem, zeros))
    assert first.route.length.tobytes() == second.route.length.tobytes()
    assert first.goal == second.goal == problem.goal


def test_one_seed_gives_one_end():
    problem = level_problem(EMPTY, START, (9.0, 8.0, 1.0), goal_tolerance=(0.5, 0.5))
    ends = [search(problem, Settings(seed=seed, iterations=800)).improvements[-1].goal for seed in (3, 3, 4)]
    assert ends[0] == ends[1] != ends[2]


def test_the_tolerance_is_of_the_body_not_of_its_path():
    """With a sideslip of 0.1 rad across the slope, and a lead: the route ends where straight driving leads on."""
    ones = np.ones((1, 3, 36))
    direction = np.arange(36) * math.radians(10.0)
    curvature = np.array([-1.0, 0.0, 1.0]) / RADIUS
    limits = SteeringLimits(np.array([0.2]), curvature, direction, ones, -0.1 * np.sin(direction) * ones, ones, ones)
    goal, tolerance, lead = (9.0, 6.0, 0.3), (0.2, 0.25), 0.5
    problem = Problem(
        grid_of(EMPTY), plane(0.2), RECTANGLE, START, goal, limits, goal_tolerance=tolerance, goal_lead=lead
    )
    found = search(problem, SETTINGS).improvements[-1]
    x, y, tangent = route_poses(found.route)[-1]
    end_x, end_y, yaw = found.goal
    assert tangent - yaw == pytest.approx(-0.1 * math.sin(tangent - 0.5 * math.pi), abs=4e-4)
    assert (x + lead * math.cos(tangent), y + lead * math.sin(tangent)) == pytest.approx((end_x, end_y), abs=1e-9)
    assert math.dist((end_x, end_y), goal[:2]) <= tolerance[0]
    assert 0.2 < goal[2] - yaw <= tolerance[1]  # nearly straight ahead is cheapest


def test_poses_within_a_tolerance_start_at_the_goal_and_reach_its_rim():
    target = target_of(level_problem(EMPTY, START, (9.0, 6.0, 0.3), goal_tolerance=(0.5, 0.2)))
    poses = poses_within(target)
    away, turned = np.hypot(poses[:, 0] - 9.0, poses[:, 1] - 6.0), np.abs(poses[:, 2] - 0.3)
    assert poses[0] == pytest.approx((9.0, 6.0, 0.3))
    assert away.max() == pytest.approx(0.5, abs=1e-8)
    assert turned.max() == pytest.approx(0.2, abs=1e-5)
    assert away.max() <= 0.5
    assert turned.max() <= 0.2
    assert (np.diff(away / 0.5 + turned / 0.2) > -1e-5).all()
    assert len({tuple(pose) for pose in poses}) == len(poses)
