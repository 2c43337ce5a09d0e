"""The search for a way beside OMPL's planners from the PyPI wheel, in one run, routes checked again from outside.

Run from the repository: ``python benchmarks/plan.py --data FOLDER`` (needs the ``bench`` extra). The folder holds
cases: a ROS map and a JSON file with `start`, `goal` and `vehicle` of the same name.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from ompl import base, geometric, util  # type: ignore[import-untyped]
from tables import print_machine

from trackctl.compiled import kernel
from trackctl.files.map_file import read_planning_map
from trackctl.lut.axes import Array
from trackctl.planning.collision_grid import CollisionGrid
from trackctl.planning.footprint import footprint_of
from trackctl.planning.planning_map import collision_grid, slope_field
from trackctl.planning.search import Problem, Settings, load_kernels, search
from trackctl.planning.slope_field import plane_slope
from trackctl.planning.steering_limits import SteeringLimits

STEP = 0.02
#: Turned by more than this over what a circle turns is too sharp; less is rounding.
CURVATURE_SLACK = 1.001


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """A map, a vehicle and two poses."""

    name: str
    grid: CollisionGrid
    polygon: Array
    radius: float
    start: tuple[float, float, float]
    goal: tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """A planner's answer: when first, how long a way, and its poses every `STEP`; no poses without a way."""

    first: float
    length: float
    poses: Array


def read_case(folder: Path, name: str) -> Case:
    """A map and the JSON beside it."""
    case = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
    planning_map = read_planning_map(str(folder / f"{name}.yaml"))
    polygon = np.array(case["vehicle"]["polygon"])
    grid = collision_grid(planning_map, slope_field(planning_map, footprint_of(polygon)))
    return Case(name, grid, polygon, case["vehicle"]["min_turn_radius"], tuple(case["start"]), tuple(case["goal"]))


@kernel
def touches(blocked: Any, distance: Array, resolution: float, half: Array, x: float, y: float, yaw: float) -> bool:
    """Whether the centre of a blocked cell lies in a rectangle: by the distance transform, or cell by cell."""
    n_rows, n_columns = blocked.shape
    row, column = int(y // resolution), int(x // resolution)
    if not (0 <= row < n_rows and 0 <= column < n_columns):
        return True
    reach = math.hypot(half[0], half[1])
    if distance[row, column] > reach + resolution:
        return False
    cells = int(reach / resolution) + 1
    cos_yaw, sin_yaw = math.cos(yaw), math.sin(yaw)
    for i in range(row - cells, row + cells + 1):
        for j in range(column - cells, column + cells + 1):
            dx, dy = (j + 0.5) * resolution - x, (i + 0.5) * resolution - y
            inside = abs(cos_yaw * dx + sin_yaw * dy) < half[0] and abs(cos_yaw * dy - sin_yaw * dx) < half[1]
            if inside and (not (0 <= i < n_rows and 0 <= j < n_columns) or blocked[i, j]):
                return True
    return False


def is_good(case: Case, run: Run) -> bool:
    """Whether a way joins start and goal, touches nothing and never turns more tightly than the vehicle can."""
    if not run.poses.size:
        return False
    ends = np.abs(run.poses[[0, -1]] - np.array((case.start, case.goal)))
    ends[:, 2] = np.abs(np.remainder(ends[:, 2] + math.pi, 2.0 * math.pi) - math.pi)
    moved = np.hypot(*np.diff(run.poses[:, :2], axis=0).T)
    turned = np.abs(np.remainder(np.diff(run.poses[:, 2]) + math.pi, 2.0 * math.pi) - math.pi)
    sharp = turned > CURVATURE_SLACK * moved / case.radius + 1e-6
    checker = checker_of(case)
    return bool(ends.max() < 1e-6) and not sharp.any() and not any(checker(*pose) for pose in run.poses.tolist())


def checker_of(case: Case) -> Callable[[float, float, float], bool]:
    grid, half = case.grid, case.polygon.max(axis=0)
    blocked, distance = np.ascontiguousarray(grid.blocked), np.ascontiguousarray(grid.distance)
    return lambda x, y, yaw: bool(touches(blocked, distance, grid.resolution, half, x, y, yaw))


def our_run(case: Case, seed: int, seconds: float) -> Run:
    """Ours: arcs and straights sampled."""
    result = search(problem_of(case), Settings(seed=seed, time_limit=seconds))
    if result.route is None or result.first_solution is None:
        return Run(math.inf, math.inf, np.empty((0, 3)))
    route = result.route
    poses = [np.array(route.start)]
    for curvature, length in zip(route.curvature, route.length, strict=True):
        x, y, tangent = poses[-1]
        for at in np.linspace(0.0, length, math.ceil(abs(length) / STEP) + 1)[1:]:
            half = 0.5 * curvature * at
            chord = at * np.sinc(half / math.pi)
            ahead = (chord * math.cos(tangent + half), chord * math.sin(tangent + half), 2.0 * half)
            poses.append(np.array((x, y, tangent)) + ahead)
    return Run(result.first_solution, float(np.abs(route.length).sum()), np.array(poses))


def problem_of(case: Case) -> Problem:
    ones = np.ones((1, 3, 1))
    curvature = np.array([-1.0, 0.0, 1.0]) / case.radius
    limits = SteeringLimits(np.zeros(1), curvature, np.zeros(1), ones, 0.0 * ones, 0.0 * ones, ones)
    return Problem(case.grid, plane_slope(0.0, 0.0), case.polygon, case.start, case.goal, limits)


def ompl_run(case: Case, planner: str, seconds: float) -> Run:
    """OMPL's: solved to the first way, then on for the rest of the time where the planner improves."""
    space = base.DubinsStateSpace(case.radius)
    height, width = case.grid.blocked.shape
    bounds = base.RealVectorBounds(2)
    for axis, cells in enumerate((width, height)):
        bounds.setLow(axis, 0.0)
        bounds.setHigh(axis, cells * case.grid.resolution)
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)
    checker = checker_of(case)
    setup.setStateValidityChecker(lambda state: not checker(state.getX(), state.getY(), state.getYaw()))
    information = setup.getSpaceInformation()
    information.setStateValidityCheckingResolution(STEP / space.getMaximumExtent())
    setup.setStartAndGoalStates(state_of(space, case.start), state_of(space, case.goal), 1e-9)
    setup.setPlanner(getattr(geometric, planner)(information))
    begin = perf_counter()
    first = None
    while perf_counter() - begin < seconds:
        solved = setup.solve(min(0.02 if first is None else seconds, seconds - (perf_counter() - begin)))
        if first is None and solved and setup.haveExactSolutionPath():
            first = perf_counter() - begin
            if planner == "RRT":
                break
    if first is None:
        return Run(math.inf, math.inf, np.empty((0, 3)))
    path = setup.getSolutionPath()
    length = path.length()
    path.interpolate(math.ceil(length / STEP) + 1)
    states = (path.getState(i) for i in range(path.getStateCount()))
    return Run(first, length, np.array([(state.getX(), state.getY(), state.getYaw()) for state in states]))


def state_of(space: Any, pose: tuple[float, float, float]) -> Any:
    state = space.allocState()
    state.setXY(pose[0], pose[1])
    state.setYaw(pose[2])
    return state


def rows(case: Case, seeds: int, seconds: float) -> Iterator[tuple[str, int, float, float, float]]:
    """Planner, ways that hold, median and 90th percentile of the first's time, median length."""
    planners: dict[str, Callable[[int], Run]] = {
        "trackctl": lambda seed: our_run(case, seed, seconds),
        "OMPL wheel, RRT": lambda _: ompl_run(case, "RRT", seconds),
        "OMPL wheel, BIT*": lambda _: ompl_run(case, "BITstar", seconds),
    }
    runs: dict[str, list[Run]] = {name: [] for name in planners}
    for seed in range(seeds):
        for name, plan in planners.items():
            runs[name].append(plan(seed))
    for name, found in runs.items():
        good = [run for run in found if is_good(case, run)]
        first, length = np.array([(run.first, run.length) for run in good or [Run(math.inf, math.inf, np.empty(0))]]).T
        yield name, len(good), float(np.median(first)), float(np.quantile(first, 0.9)), float(np.median(length))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True, help="folder of the cases")
    parser.add_argument("--cases", nargs="+", default=["open10", "real_depot"])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=2.0)
    arguments = parser.parse_args()
    print_machine()
    util.setLogLevel(util.LogLevel.LOG_ERROR)
    util.RNG.setSeed(1)  # OMPL's streams are seeded once a process
    load_kernels()
    for name in arguments.cases:
        case = read_case(arguments.data, name)
        print(f"\n{name}: {arguments.seeds} seeds, {arguments.seconds:g} s each, forwards only")
        print(f"{'planner':<20}{'solved':>8}{'first s':>10}{'p90 s':>9}{'length m':>11}")
        for planner, solved, median, p90, length in rows(case, arguments.seeds, arguments.seconds):
            print(f"{planner:<20}{solved:>8}{median:>10.4f}{p90:>9.4f}{length:>11.3f}")


if __name__ == "__main__":
    main()
