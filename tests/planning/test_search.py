import math
from dataclasses import replace

import numpy as np
import pytest
from planning_cases import (
    RADIUS,
    RECTANGLE,
    grid_of,
    hits,
    level_limits,
    level_problem,
    plane,
    pose_error,
    route_poses,
)

from trackctl.planning.dubins import dubins_length
from trackctl.planning.ground import Cost, ground_of, motion_of, rate_and_sideslip, rate_at
from trackctl.planning.pieces import new_way
from trackctl.planning.reeds_shepp import reeds_shepp_length
from trackctl.planning.search import Problem, Settings, search
from trackctl.planning.steering_limits import SteeringLimits

EMPTY = np.zeros((200, 200), bool)
FIVE = np.array([-1.0, -0.5, 0.0, 0.5, 1.0]) / RADIUS


def forest(seed=0, size=200, trees=18):
    """Blocked squares of 1 m on 20 m by 20 m, none near two opposite corners."""
    blocked = np.zeros((size, size), bool)
    for i, j in np.random.default_rng(seed).integers(0, size - 10, (trees, 2)):
        blocked[i : i + 10, j : j + 10] = True
    blocked[:40, :40] = blocked[-40:, -40:] = False
    return blocked


def checked(problem, result):
    """The route's poses, once it is sure that they join start and goal and touch nothing."""
    poses = route_poses(result.route)
    assert pose_error(poses[0], problem.start) == 0.0
    assert pose_error(poses[-1], problem.goal) < 1e-9
    assert not hits(problem.grid, problem.footprint, poses).any()
    assert np.abs(result.route.curvature).max() <= 1.0 / RADIUS + 1e-12
    return poses


@pytest.mark.parametrize(("gears", "changes"), [((0, 0), 0), ((-1, 0), 0), ((1, 0), 1), ((0, 1), 1), ((1, 1), 2)])
def test_gears_at_the_ends_that_the_route_is_not_driven_in_have_their_price(gears, changes):
    """Five metres straight back."""
    problem = level_problem(EMPTY, (12.0, 10.0, 0.0), (7.0, 10.0, 0.0), backward=level_limits(), gears=gears)
    settings = Settings(iterations=300, gear_change=0.5)
    assert search(problem, settings).cost == pytest.approx(5.0 + 0.5 * changes, abs=1e-9)


@pytest.mark.parametrize(
    ("start", "goal"),
    [
        ((3.0, 3.0, 0.0), (17.0, 15.0, 1.0)),
        ((10.0, 10.0, 0.0), (10.0, 10.0, math.pi)),
        ((4.0, 4.0, 1.0), (6.0, 5.0, 2.5)),
    ],
)
def test_an_empty_map_has_dubins_way(start, goal):
    problem = level_problem(EMPTY, start, goal)
    result = search(problem, Settings(iterations=500))
    assert result.cost == pytest.approx(dubins_length(*start, *goal, RADIUS), abs=1e-9)
    assert np.abs(result.route.length).sum() == pytest.approx(result.cost, abs=1e-9)
    checked(problem, result)


def test_an_empty_map_has_reeds_and_shepps_way_backwards_too():
    start, goal = (10.0, 10.0, 0.0), (10.5, 11.5, 0.2)
    problem = level_problem(EMPTY, start, goal, backward=level_limits())
    x, y = (goal[0] - start[0]) / RADIUS, (goal[1] - start[1]) / RADIUS
    shortest = RADIUS * reeds_shepp_length(x, y, 0.2, new_way())
    costs = []
    for price in (0.0, 1.0, 100.0):
        result = search(problem, Settings(iterations=1500, gear_change=price))
        checked(problem, result)
        gears = np.sign(result.route.length)
        assert result.cost == pytest.approx(np.abs(result.route.length).sum() + price * (np.diff(gears) != 0.0).sum())
        costs.append(result.cost)
    assert costs[0] == pytest.approx(shortest, abs=1e-9)
    assert costs[0] < costs[1] < costs[2] <= dubins_length(*start, *goal, RADIUS) + 1e-9


def test_turning_on_the_spot_costs_its_time():
    problem = level_problem(EMPTY, (5.0, 5.0, 0.0), (5.0, 12.0, 0.5 * math.pi), pivot_speed=2.0)
    result = search(problem, Settings(iterations=200, gear_change=0.1))
    assert result.cost == pytest.approx(7.0 + 0.25 * math.pi + 0.1, abs=1e-9)
    assert np.abs(result.route.pivot).sum() == pytest.approx(0.5 * math.pi, abs=1e-9)
    assert pose_error(route_poses(result.route)[-1], problem.goal) < 1e-9


def test_a_stop_costs_as_much_as_driving_for_its_time():
    """Speed 2 m/s: under the length as cost, a stop of 3 s is worth 6 m."""
    limits = level_limits(speed=2.0)
    ends = (10.0, 10.0, 0.0), (6.0, 10.0, 0.0)
    for cost, price, second in ((Cost.TIME, 0.2, 1.0), (Cost.LENGTH, 0.2, 2.0)):
        problem = Problem(grid_of(EMPTY), plane(), RECTANGLE, *ends, limits, limits, pivot_speed=100.0)
        result = search(problem, Settings(iterations=500, gear_change=price, cost=cost))
        assert result.cost == pytest.approx(4.0 * (0.5 if cost is Cost.TIME else 1.0), abs=1e-9)  # straight back
        turned = search(replace(problem, backward=None), Settings(iterations=500, gear_change=price, cost=cost))
        turns = 2.0 * second * (price + 0.01 * math.pi)
        assert turned.cost == pytest.approx(result.cost + turns, abs=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_a_forest_is_crossed_without_touching(seed):
    problem = level_problem(forest(seed), (2.0, 2.0, 0.8), (18.0, 18.0, 0.8))
    result = search(problem, Settings(seed=seed, iterations=3000))
    checked(problem, result)
    costs = [improvement.cost for improvement in result.improvements]
    assert costs == sorted(costs, reverse=True)
    assert costs[-1] < 1.1 * math.hypot(16.0, 16.0)
    assert result.first_solution <= result.improvements[-1].elapsed <= result.elapsed


def test_a_gap_just_wider_than_the_vehicle_is_found_and_a_narrower_one_ruled_out():
    blocked = EMPTY.copy()
    blocked[:, 100] = True
    blocked[95:104, 100] = False  # 0.9 m
    problem = level_problem(blocked, (3.0, 3.0, 0.0), (17.0, 17.0, 0.0))
    checked(problem, search(problem, Settings(iterations=20_000)))
    blocked[95:98, 100] = True  # 0.6 m
    result = search(level_problem(blocked, (3.0, 3.0, 0.0), (17.0, 17.0, 0.0)), Settings(iterations=20_000))
    assert result.route is None
    assert "close off" in result.reason
    assert result.iterations < 2000


def test_cells_that_touch_at_their_corners_close_off():
    blocked = np.zeros((10, 10), bool)
    blocked[:5, 5] = blocked[5:, 4] = True
    result = search(level_problem(blocked, (5.0, 10.0, 0.0), (15.0, 10.0, 0.0), 2.0), Settings(iterations=2000))
    assert "close off" in result.reason
    blocked[4, 5] = False
    checked(
        problem := level_problem(blocked, (5.0, 9.0, 0.0), (15.0, 9.0, 0.0), 2.0),
        search(problem, Settings(iterations=500)),
    )


@pytest.mark.parametrize("seed", range(3))
def test_a_long_winding_way_is_grown_along_its_guide(seed):
    """Through six walls with gaps of 3 m at alternating ends; drawn anywhere, points take more than 25,000 tries."""
    blocked = np.zeros((300, 300), bool)
    for k, column in enumerate(range(45, 300, 50)):
        blocked[:, column : column + 5] = True
        blocked[slice(10, 40) if k % 2 else slice(260, 290), column : column + 5] = False
    problem = level_problem(blocked, (2.0, 2.0, 1.5), (28.0, 15.0, -1.5))
    checked(problem, search(problem, Settings(seed=seed, iterations=8000)))


def test_one_seed_and_number_of_iterations_give_one_route():
    problem = level_problem(forest(1), (2.0, 2.0, 0.8), (18.0, 18.0, 0.8))
    first, again, other = (search(problem, Settings(seed=seed, iterations=2000)) for seed in (5, 5, 6))
    assert [part.tobytes() for part in (first.route.curvature, first.route.length)] == [
        part.tobytes() for part in (again.route.curvature, again.route.length)
    ]
    assert first.route.length.tobytes() != other.route.length.tobytes()
    assert (first.iterations, first.nodes) == (again.iterations, again.nodes) == (2000, first.nodes)


def test_a_longer_search_goes_on_from_a_shorter_one():
    problem = level_problem(forest(1), (2.0, 2.0, 0.8), (18.0, 18.0, 0.8))
    short, long = (search(problem, Settings(iterations=count)) for count in (640, 1920))
    costs = [[(each.iteration, each.cost) for each in result.improvements] for result in (short, long)]
    # The last step of the shorter one may have been cut.
    assert len(costs[0]) > 3
    assert costs[1][: len(costs[0]) - 1] == costs[0][:-1]


@pytest.mark.parametrize(
    ("start", "goal", "words"),
    [
        ((8.05, 8.05, 0.0), (17.0, 17.0, 0.0), "start: the footprint touches the blocked cell in row 80, column 80"),
        ((3.0, 3.0, 0.0), (0.2, 17.0, 0.0), "goal: the footprint reaches outside the map"),
    ],
)
def test_blocked_ends_are_named(start, goal, words):
    blocked = EMPTY.copy()
    blocked[80, 80] = True
    result = search(level_problem(blocked, start, goal), Settings(iterations=100))
    assert result.route is None
    assert words in result.reason
    assert (result.cost, result.iterations, result.first_solution) == (math.inf, 0, None)


def test_a_slope_too_steep_is_named():
    limits = level_limits()
    problem = Problem(grid_of(EMPTY), plane(0.3), RECTANGLE, (3.0, 3.0, 0.0), (9.0, 9.0, 0.0), limits)
    assert "start: the vehicle cannot drive straight there" in search(problem, Settings(iterations=10)).reason


def slope_limits(slope, hard_curvature, hard_speed, sideslip=0.05, curvature=FIVE):
    """Limits on one slope where tight turns with gravity away from the turning centre are hard."""
    direction = np.arange(36) * math.radians(10.0)
    outwards = -np.sign(curvature)[:, None] * np.sin(direction)  # left turns are easy where 0 < direction < pi
    hard = (outwards > 1e-9) & (np.abs(curvature)[:, None] > hard_curvature)
    speed = np.where(hard, hard_speed, 1.0)[None]
    ones = np.ones_like(speed)
    side = -sideslip * np.sin(direction) * ones
    return SteeringLimits(np.array([slope]), curvature, direction, speed, side, 0.1 * ones, 100.0 * ones)


def test_only_what_is_feasible_is_driven():
    slope, uphill = 0.2, 0.5 * math.pi
    limits = slope_limits(slope, hard_curvature=0.6 / RADIUS, hard_speed=0.0)
    problem = Problem(grid_of(EMPTY), plane(slope, uphill), RECTANGLE, (4.0, 4.0, 0.0), (16.0, 9.0, math.pi), limits)
    result = search(problem, Settings(iterations=3000))
    motion = motion_of(limits, Cost.TIME)
    tangent = result.route.start[2]
    for curvature, length in zip(result.route.curvature, result.route.length, strict=True):
        for share in np.linspace(0.05, 0.95, 19):
            assert math.isfinite(
                rate_and_sideslip(motion, slope, curvature, tangent + share * curvature * length - uphill)[0]
            )
        tangent += curvature * length


def test_start_and_goal_are_body_poses_and_the_footprint_lies_across_its_path():
    slope, uphill = 0.2, 0.5 * math.pi
    limits = slope_limits(slope, hard_curvature=9.0, hard_speed=1.0, sideslip=0.1)
    problem = Problem(grid_of(EMPTY), plane(slope, uphill), RECTANGLE, (4.0, 9.0, 0.0), (16.0, 9.0, 0.2), limits)
    route = search(problem, Settings(iterations=500)).route
    end = route_poses(route)[-1]
    for tangent, yaw in ((route.start[2], 0.0), (end[2], 0.2)):
        expected = -0.1 * math.sin(tangent - uphill)
        assert tangent - yaw == pytest.approx(expected, abs=4e-4)  # linear between nodes 10 deg apart
    np.testing.assert_allclose(end[:2], (16.0, 9.0), atol=1e-9)


def test_hard_turns_are_driven_wide_because_of_their_cost():
    """From up-slope to down-slope gravity points to the turning centre, the other way round away from it."""
    curvature = np.array([-1.0, -0.6, -0.5, 0.0, 0.5, 0.6, 1.0]) / RADIUS
    limits = slope_limits(0.2, hard_curvature=0.55 / RADIUS, hard_speed=0.2, sideslip=0.0, curvature=curvature)
    costs = []
    for sense in (1.0, -1.0):
        start, goal = (7.0, 10.0, sense * 0.5 * math.pi), (7.0 + 4.0 * RADIUS, 10.0, -sense * 0.5 * math.pi)
        problem = Problem(grid_of(EMPTY), plane(0.2), RECTANGLE, start, goal, limits)
        costs.append(search(problem, Settings(iterations=6000)).cost)
    tight, wide = math.pi * RADIUS + 2.0 * RADIUS, math.pi * 2.0 * RADIUS
    assert costs == pytest.approx([tight, wide], rel=0.01)


def test_costs_add_up_along_the_path():
    slope = 0.2
    limits = slope_limits(slope, hard_curvature=9.0, hard_speed=1.0, sideslip=0.0)
    limits = limits._replace(speed=limits.speed * (1.5 + np.cos(limits.direction)))
    rates = {
        Cost.TIME: lambda phi: 1.0 / (1.5 + math.cos(phi)),
        Cost.LENGTH: lambda phi: 1.0,
        Cost.ENERGY: lambda phi: 100.0 * 1.001,
        Cost.SLIP: lambda phi: 0.1 * 1.001,
    }
    for cost, rate in rates.items():
        ground = ground_of(plane(slope), limits, None, cost)
        for tangent in (0.0, 0.4, 2.0):
            phi = tangent - 0.5 * math.pi
            found = rate_at(ground, ground.forward, 3.0, 4.0, tangent, 0.1)[0]
            assert found == pytest.approx(rate(phi), rel=0.02)  # linear between nodes 10 deg apart
