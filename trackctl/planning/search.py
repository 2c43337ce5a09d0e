"""Search for a way from start to goal: a tree of arcs and straights in trajectory parameter space, made better in time.

All of it runs in compiled kernels; the clock is looked at only between them, so that a seed and a number of
iterations give one and the same route.
"""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import compile_for
from trackctl.planning.anytime import BATCH, Anytime
from trackctl.planning.collision import NOWHERE, Obstacles, obstacles_of, touched_cell
from trackctl.planning.collision_grid import CollisionGrid
from trackctl.planning.connection import ALL_WORDS
from trackctl.planning.footprint import footprint_of
from trackctl.planning.ground import Cost, Ground, cost_of_a_second, gear_motion, ground_of, rate_at, straight_tangent
from trackctl.planning.pieces import Task
from trackctl.planning.polish import new_path, polish
from trackctl.planning.random_numbers import stream_of
from trackctl.planning.reachability import centred_disc, disc_way
from trackctl.planning.route import Route
from trackctl.planning.simplification import simplified, simplify
from trackctl.planning.slope_field import SlopeField, plane_slope
from trackctl.planning.steering_limits import SteeringLimits
from trackctl.planning.target import End, Target, is_exact, nearest_end, new_end

Array = NDArray[np.float64]
Pose = tuple[float, float, float]

#: Iterations without a route before it is asked whether there can be one: longer than most searches take.
DOUBT = 256
#: Turning radii that connections try, in smallest radii.
RADII = (1.0, 1.25, 1.6, 2.0, 2.5, 3.5, 5.0)


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """What to find a way for.

    Attributes
    ----------
    grid, field
        Blocked cells and slope of the map.
    footprint
        Polygon about the mass centre, shape (n, 2). [m]
    start, goal
        x, y [m] and yaw of the body [rad], both driven straight.
    forward, backward
        Limits in either gear; None: forward only. Backwards too, curvature is yaw change per metre travelled
        forwards, the tangent is the reverse of the direction of travel, and direction that of the tangent.
    clearance
        To keep between footprint and blocked cells. [m]
    gears
        That the vehicle arrives at the start and goes on from the goal in: 1 forwards, -1 backwards, 0 either.
    pivot_speed
        Rate of a turn on the spot on level ground; 0: cannot. [rad/s]
    goal_tolerance
        Of the position [m] and yaw [rad] of the goal; zeros: it is met exactly.
    goal_lead
        Straight to the goal that is left to be driven after the route, in its last gear: negative backwards. [m]
    """

    grid: CollisionGrid
    field: SlopeField
    footprint: Array
    start: Pose
    goal: Pose
    forward: SteeringLimits
    backward: SteeringLimits | None = None
    clearance: float = 0.0
    gears: tuple[int, int] = (0, 0)
    pivot_speed: float = 0.0
    goal_tolerance: tuple[float, float] = (0.0, 0.0)
    goal_lead: float = 0.0


@dataclass(frozen=True, slots=True)
class Settings:
    """How to search.

    Attributes
    ----------
    seed
        Of the random numbers.
    time_limit
        Where there is no number of iterations. [s]
    iterations
        In place of a time limit.
    cost
        What to minimise.
    gear_change
        The time it takes, which under other costs is worth what as much time of driving costs on average. [s]
    """

    seed: int = 0
    time_limit: float = 1.0
    iterations: int | None = None
    cost: Cost = Cost.TIME
    gear_change: float = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class Improvement:
    """A route better than those before.

    Attributes
    ----------
    elapsed
        Since the start of the search. [s]
    iteration
        That found it.
    cost
        In the units of the settings' cost.
    route
        From start to goal, but for the lead.
    goal
        x, y [m] and yaw [rad] of the body that it leads to, within the tolerance.
    """

    elapsed: float
    iteration: int
    cost: float
    route: Route
    goal: Pose


@dataclass(frozen=True, slots=True, eq=False)
class SearchResult:
    """What came of a search.

    Attributes
    ----------
    improvements
        Routes found, each better than the one before.
    reason
        Why there is none, as a sentence; empty where there is one.
    elapsed
        [s]
    iterations, nodes
        Done, and in the tree.
    """

    improvements: tuple[Improvement, ...]
    reason: str
    elapsed: float
    iterations: int
    nodes: int

    @property
    def route(self) -> Route | None:
        """The best."""
        return self.improvements[-1].route if self.improvements else None

    @property
    def cost(self) -> float:
        """Of the best route, infinite without one."""
        return self.improvements[-1].cost if self.improvements else math.inf

    @property
    def first_solution(self) -> float | None:
        """When the first route was found. [s]"""
        return self.improvements[0].elapsed if self.improvements else None


def search(problem: Problem, settings: Settings) -> SearchResult:
    """Find a way, and better ones as long as time or iterations last."""
    load_kernels()
    found = Search(problem, settings)
    found.go_on(settings.iterations, None if settings.iterations is not None else settings.time_limit)
    return found.result()


def stopwatch(clock: Callable[[], float] = time.perf_counter) -> Callable[[], float]:
    """What tells the seconds since now."""
    begin = clock()
    return lambda: clock() - begin


class Search:
    """A search that can be left and gone on with; that is all the same to what it finds.

    Attributes
    ----------
    problem
        Searched for a way.
    improvements
        Routes found so far, each better than the one before.
    reason
        Why there is no route, as a sentence, once that is sure; else empty.
    """

    def __init__(self, problem: Problem, settings: Settings, elapsed: Callable[[], float] | None = None) -> None:
        """Begin with a problem.

        Parameters
        ----------
        problem
            Map, vehicle, start and goal.
        settings
            How to search; how long is up to `go_on`.
        elapsed
            Tells the seconds that improvements are noted with; None: since now.
        """
        self._elapsed = elapsed or stopwatch()
        self.problem, self._task = problem, task_of(problem, settings)
        self.improvements: list[Improvement] = []
        target = target_of(problem)
        self._end, goal_reason = surest_end(self._task, target)
        self.reason = _reason_at(self._task, "start", problem.start, problem.gears[0]) or goal_reason
        start = tangent_pose(self._task.ground, problem.start, problem.gears[0])
        self._state = Anytime(self._task, start, target, self._end, settings.seed)
        self._doubted = True

    @property
    def iterations(self) -> int:
        """Done so far."""
        return self._state.iterations

    def go_on(
        self, iterations: int | None, until: float | None, after_step: Callable[[int], None] | None = None
    ) -> None:
        """Go on for some iterations and up to a time, as long as there may be a route; for a step at least.

        Parameters
        ----------
        iterations
            None for any number.
        until
            In what `elapsed` tells, looked at after each step; None: whenever. [s]
        after_step
            Told the iterations of each step.
        """
        left = math.inf if iterations is None else iterations
        while left > 0 and not self.reason:
            done = self._step(left)
            left -= done
            if after_step is not None:
                after_step(done)
            if until is not None and self._elapsed() >= until:
                break

    def _step(self, most: float) -> int:
        """A few iterations, and doubt once there are many without a route; their number."""
        state, before = self._state, self._state.iterations
        if state.step(int(min(BATCH, most))):
            found = self._elapsed(), state.iterations, state.cost, state.route(), state.goal()
            self.improvements.append(Improvement(*found))
        elif self._doubted and not self.improvements and state.iterations >= DOUBT:
            self._doubted = False
            self.follow_guide()
        return state.iterations - before

    def follow_guide(self) -> None:
        """Grow trees by the way of the widest of some discs; where not even the smallest has one, give up."""
        task = self._task
        widths = sorted((float(task.radii[0]), task.obstacles.footprint.reach, task.inner_radius), reverse=True)
        guides = (self._guide(radius) for radius in widths if radius >= task.inner_radius)
        guide = next((each for each in guides if each.size), np.empty((0, 2)))
        self.reason = "" if guide.size else _separation(self.problem, task)
        self._state.follow(guide)

    def with_fewer_pieces(self, found: Improvement) -> Improvement:
        """A route of this search with fewer pieces, if it is driven without turns on the spot; else the same."""
        if np.any(found.route.pivot != 0.0):
            return found
        route, cost = simplified(self._task, found.route)
        return replace(found, route=route, cost=cost) if route.length.size < found.route.length.size else found

    def result(self) -> SearchResult:
        """What has come of it so far."""
        reason = self._reason_so_far()
        return SearchResult(
            tuple(self.improvements), reason, self._elapsed(), self._state.iterations, self._state.nodes
        )

    def _reason_so_far(self) -> str:
        if self.reason or self.improvements:
            return self.reason
        if not self._guide(self._task.inner_radius).size:
            return _separation(self.problem, self._task)
        return f"goal not reached: no connection in {self.iterations} iterations"

    def _guide(self, radius: float) -> Array:
        """Way of a disc of some radius [m], shape (n, 2); empty if it has none."""
        start, goal = self.problem.start, self._end.route
        place, reach = (float(goal[0]), float(goal[1])), self._state.slack
        return disc_way(self._task.obstacles, (start[0], start[1]), place, reach, radius)


def empty_room() -> Problem:
    """A way across a small empty room, for what any problem would do."""
    grid = CollisionGrid(np.zeros((20, 20), np.bool_), np.full((20, 20), 10.0), 1.0, 0.0, 0.0, 1.0, 0.0)
    ones = np.ones((1, 3, 1))
    limits = SteeringLimits(np.zeros(1), np.array([-1.0, 0.0, 1.0]), np.zeros(1), ones, 0.0 * ones, ones, ones)
    triangle = np.array([[0.2, 0.0], [-0.1, 0.1], [-0.1, -0.1]])
    return Problem(grid, plane_slope(0.0, 0.0), triangle, (5.0, 5.0, 0.0), (9.0, 9.0, 1.0), limits)


def compile_polishing() -> None:
    """Compile `polish`, or load it."""
    room = empty_room()
    compile_for(polish, task_of(room, Settings()), new_path(), stream_of(0), target_of(room), 1)


def compile_simplification() -> None:
    """Compile `simplify`, or load it."""
    compile_for(simplify, task_of(empty_room(), Settings()), new_path(), np.ones(1), 1.0)


def compile_growth() -> None:
    """Compile what finds a first way, or load it, by crossing an empty room."""
    found = Search(empty_room(), Settings())
    found.follow_guide()
    found.go_on(1, None)


@functools.cache
def load_kernels() -> None:
    """Compile the kernels of a search, or load them, by crossing an empty room: no clock should count that."""
    found = Search(empty_room(), Settings())
    found.follow_guide()
    found.go_on(2, None)
    found.with_fewer_pieces(found.improvements[-1])


def task_of(problem: Problem, settings: Settings) -> Task:
    """Map and costs as the kernels read them."""
    obstacles = obstacles_of(problem.grid, footprint_of(problem.footprint), problem.clearance)
    ground = ground_of(problem.field, problem.forward, problem.backward, settings.cost)
    sharpest = float(np.abs(problem.forward.curvature[(problem.forward.speed > 0.0).any(axis=(0, 2))]).max(initial=0.0))
    radii = np.array(RADII) / max(sharpest, 1e-6)
    can_pivot = ground.is_level and problem.pivot_speed > 0.0
    second = cost_of_a_second(problem.forward, settings.cost)
    pivot_rate = second / problem.pivot_speed if can_pivot else math.inf
    inner = centred_disc(obstacles.footprint)
    return Task(
        obstacles=obstacles,
        ground=ground,
        radii=radii,
        gear_change=settings.gear_change * second,
        pivot_rate=pivot_rate,
        can_reverse=problem.backward is not None,
        first_gear=problem.gears[0],
        last_gear=problem.gears[1],
        inner_radius=inner,
        least_rate=min(ground.forward.least_rate, ground.backward.least_rate),
        estimates=np.empty(ALL_WORDS),
    )


def target_of(problem: Problem) -> Target:
    """The goal and its tolerance as the kernels read them."""
    return Target(*map(float, (*problem.goal, *problem.goal_tolerance, problem.goal_lead)))


def tangent_pose(ground: Ground, pose: Pose, gear: int) -> Pose:
    """The pose with the tangent of straight driving in a gear in place of the body's yaw."""
    x, y, yaw = map(float, pose)
    return x, y, float(straight_tangent(ground, gear_motion(ground, gear), x, y, yaw))


def surest_end(task: Task, target: Target) -> tuple[End, str]:
    """The goal itself or, where that will not do, an end close to it; and why neither will do."""
    x, y, yaw = target.x, target.y, target.yaw
    if target.lead:
        tangent = tangent_pose(task.ground, (x, y, yaw), task.last_gear)[2]
        x, y = x - target.lead * math.cos(tangent), y - target.lead * math.sin(tangent)
    reason = _reason_at(task, "goal", (x, y, yaw), task.last_gear)
    if reason and not is_exact(target) and (near := nearest_end(task, target)) is not None:
        return near, ""
    return new_end(tangent_pose(task.ground, (x, y, yaw), task.last_gear), (target.x, target.y, target.yaw)), reason


def _reason_at(task: Task, name: str, pose: Pose, gear: int) -> str:
    """Why nothing can be driven from or to a pose; empty if nothing is known."""
    reason = _blocked(task.obstacles, pose) or _undrivable(task.ground, pose, gear)
    return f"{name}: {reason}" if reason else ""


def _separation(problem: Problem, task: Task) -> str:
    """Why not even a disc gets from start to goal."""
    room = f" with {problem.clearance:g} m of clearance" if problem.clearance else ""
    return f"goal not reachable: obstacles close off the start even for a disc of {task.inner_radius:g} m radius{room}"


def _blocked(obstacles: Obstacles, pose: Pose) -> str:
    row, column = touched_cell(obstacles, *map(float, pose))
    if row == NOWHERE:
        return ""
    n_rows, n_columns = obstacles.distance.shape
    if not (0 <= row < n_rows and 0 <= column < n_columns):
        return "the footprint reaches outside the map"
    across, up = (column + 0.5) * obstacles.resolution, (row + 0.5) * obstacles.resolution
    x = obstacles.x + obstacles.cos_yaw * across - obstacles.sin_yaw * up
    y = obstacles.y + obstacles.sin_yaw * across + obstacles.cos_yaw * up
    return f"the footprint touches the blocked cell in row {row}, column {column} (x {x:.3f} m, y {y:.3f} m)"


def _undrivable(ground: Ground, pose: Pose, gear: int) -> str:
    x, y, tangent = tangent_pose(ground, pose, gear)
    if math.isfinite(rate_at(ground, gear_motion(ground, gear), x, y, tangent, 0.0)[0]):
        return ""
    return "the vehicle cannot drive straight there: no feasible speed on this slope in this direction"
