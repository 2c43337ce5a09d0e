"""`plan`: from a map to a trajectory with sprocket rates that the vehicle drives."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from trackctl.errors import NoAnswerError, UsageError
from trackctl.lut.table import Table
from trackctl.planning.blocked_cell import describe_cell
from trackctl.planning.clearance import least_clearance
from trackctl.planning.collision import NOWHERE, Obstacles, obstacles_of, touched_cell
from trackctl.planning.collision_grid import CollisionGrid
from trackctl.planning.footprint import footprint_of
from trackctl.planning.ground import Cost
from trackctl.planning.planning_map import PlanningMap, collision_grid, grid_frame, overridden, slope_field
from trackctl.planning.search import Problem, Settings
from trackctl.planning.slope_field import SlopeField
from trackctl.planning.steering_limits import SteeringLimits
from trackctl.planning.surface_line import is_plane
from trackctl.planning.table_limits import driven_backwards, is_feasible_somewhere, searched, table_limits
from trackctl.planning.target import Target, is_clear_somewhere, is_exact
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.simulation.motion import compile_simulation
from trackctl.workflows.plan_attempts import DrivenPlan, driven_plan, slope_range
from trackctl.workflows.plan_choices import PlanCost
from trackctl.workflows.plan_drive import no_slip_twin
from trackctl.workflows.plan_kernels import load_plan_kernels
from trackctl.workflows.plan_model import drive_model, turned_round
from trackctl.workflows.plan_proof import ProvedPlan, proved_plan
from trackctl.workflows.plan_rows import Rows, rows_of
from trackctl.workflows.plan_table import cached_table, slope_nodes, users_table
from trackctl.workflows.plan_verification import Verification, verify

Array = NDArray[np.float64]
Pose = tuple[float, float, float]
Progress = Callable[[float, float], None]

#: Least radius of a plan where the profile has none, over the contact length.
LEAST_RADIUS = 1.5
#: Keys of a summary, and those that a simulation adds.
FIGURES = (
    *("first_solution_s", "planning_s", "length_m", "duration_s", "cost", "nodes"),
    *("min_clearance_m", "goal_distance_m", "goal_yaw_error_rad"),
)
VERIFIED = ("max_deviation_m", "no_slip_max_deviation_m", "collision", "simulated_min_clearance_m")
#: Said where turns on the spot are asked for and cannot be.
NO_TURNS = (
    "no turns on the spot: they take level ground, a mass centre over the centre of the contact, a profile without "
    "min_turn_radius_m, and its max_track_force_n to turn against friction"
)
#: Poses so near are one. [m], [rad]
SAME_POSE = 1e-3


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PlanRequest:
    """What to plan.

    Attributes
    ----------
    planning_map
        With start and goal.
    vehicle, terrain, gravity
        [m/s2]
    lut
        Table to read, None for one from the user's cache folder.
    search
        Seed, time or iterations, and cost.
    most_speed
        None for the vehicle's. [m/s]
    clearance
        To keep. [m]
    reverse
        Whether to drive backwards, too.
    pivot
        Whether to turn on the spot where that is cheaper; None: only where there is no other way.
    allow_unknown
        Whether unknown cells may be driven on.
    verify
        Whether to simulate the plan.
    jobs
        Threads of a table that is compiled.
    """

    planning_map: PlanningMap
    vehicle: VehicleProfile
    terrain: TerrainProfile
    gravity: float
    lut: Path | None = None
    search: Settings = field(default_factory=Settings)
    most_speed: float | None = None
    clearance: float = 0.0
    reverse: bool = False
    pivot: bool | None = None
    allow_unknown: bool = False
    verify: bool = False
    jobs: int = 1


@dataclass(frozen=True, slots=True, eq=False)
class PlanResult:
    """A plan and what there is to say about it.

    Attributes
    ----------
    rows
        The plan.
    first_solution, planning
        Wall times from the start of the search. [s]
    cost
        Duration [s] or length [m] of the plan; of work [J] and slip [m] that of the route, blends and stops left aside.
    nodes
        Of the tree.
    min_clearance
        Least distance of the footprint from blocked cells. [m]
    goal_distance, goal_yaw_error
        How far from the goal it ends, and turned by how much either way. [m], [rad]
    grid, outline
        Blocked cells, and the footprint about the mass centre, shape (n, 2). [m]
    verification, no_slip
        Of the plan and of commands that would drive it without slip, where asked for.
    notes
        What the user should know of the plan, as sentences; those of its map left aside.
    """

    rows: Rows
    first_solution: float
    planning: float
    cost: float
    nodes: int
    min_clearance: float
    goal_distance: float
    goal_yaw_error: float
    grid: CollisionGrid
    outline: Array
    verification: Verification | None
    no_slip: Verification | None
    notes: tuple[str, ...]


def search_settings(seed: int, time_limit: float, iterations: int | None, cost: PlanCost) -> Settings:
    """How to search, for so many seconds or iterations."""
    return Settings(seed=seed, time_limit=time_limit, iterations=iterations, cost=Cost(cost.value))


def changed_map(planning_map: PlanningMap, notes: tuple[str, ...], **given: object) -> PlanningMap:
    """A map with values given in place of its own, and further notes; see `overridden`."""
    return overridden(planning_map, notes=planning_map.notes + notes, **given)


def sharpest_curvature(vehicle: VehicleProfile) -> float:
    """Largest curvature of a plan. [1/m]"""
    return 1.0 / (vehicle.min_turn_radius or LEAST_RADIUS * vehicle.contact_length)


def most_speed(request: PlanRequest) -> float:
    """Upper bound of the speed. [m/s]"""
    return min(request.most_speed or math.inf, request.vehicle.max_speed)


def steering(
    request: PlanRequest, field: SlopeField, progress: Callable[[int, int], None]
) -> tuple[SteeringLimits, SteeringLimits | None]:
    """Limits of steering in both gears, from tables.

    A vehicle whose mass centre is over the contact centre is the same turned round; any other needs a table of its own
    to drive backwards.
    """
    vehicle, sharpest, most = request.vehicle, sharpest_curvature(request.vehicle), most_speed(request)
    low, high = slope_range(field)

    def own(carrier: VehicleProfile) -> Table:
        nodes = slope_nodes(low, high)
        return cached_table(carrier, request.terrain, request.gravity, nodes, sharpest, progress, request.jobs)

    if request.lut is None:
        table = own(vehicle)
    else:
        table = users_table(request.lut, vehicle, request.terrain, request.gravity, (low, high))
        widest = float(np.abs(table.axes.curvature).max())
        sharpest = min(sharpest, widest)
    forward = table_limits(table, vehicle, sharpest, most)
    if not request.reverse:
        return forward, None
    if vehicle.cog_forward == vehicle.cog_left == 0.0:
        return forward, driven_backwards(forward)
    return forward, driven_backwards(table_limits(own(turned_round(vehicle)), turned_round(vehicle), sharpest, most))


def plan(
    request: PlanRequest,
    compiling: Callable[[int, int], None] = lambda done, total: None,
    searching: Progress = lambda done, total: None,
) -> PlanResult:
    """Plan what a request asks for.

    Parameters
    ----------
    request
        What to plan.
    compiling
        Told the columns of the table that are done, and all.
    searching
        Told how far the search is.

    Raises
    ------
    NoAnswerError
        If there is no plan, with the reason.
    MapError, UsageError
        If start or goal lie outside the map, or the map or the table is not fit.
    """
    start, goal = poses_of(request)
    check_apart(start, goal)
    ground = slope_field(request.planning_map, request.vehicle.footprint)
    grid = collision_grid(request.planning_map, ground, allow_unknown=request.allow_unknown)
    outline = np.array(request.vehicle.footprint) - (request.vehicle.cog_forward, request.vehicle.cog_left)
    exact = obstacles_of(grid, footprint_of(outline))
    roomy = obstacles_of(grid, footprint_of(outline), request.clearance)
    check_pose(request, roomy, "start", start)
    tolerance = request.planning_map.goal_tolerance or (0.0, 0.0)
    check_goal(request, roomy, Target(*goal, *tolerance, 0.0))
    forward, backward = steering(request, ground, compiling)
    if not is_feasible_somewhere(forward):
        raise NoAnswerError(infeasible_ground(request, ground))
    model = drive_model(
        request.vehicle, request.terrain, request.gravity, ground, roomy, (forward, backward), most_speed(request)
    )
    problem = Problem(
        grid,
        ground,
        outline,
        start,
        goal,
        searched(forward),
        None if backward is None else searched(backward),
        request.clearance,
        goal_tolerance=tolerance,
    )
    # What is to be compiled or loaded is no part of the time that a search may take.
    if model.spot is not None and (request.pivot or request.verify):
        compile_simulation(model.ahead.model)
    load_plan_kernels(model, problem)

    def find(problem: Problem) -> DrivenPlan:
        return driven_plan(model, problem, request.search, searching, request.pivot)

    def simulated(driven: DrivenPlan) -> tuple[Verification, Verification]:
        setting = request.vehicle, request.terrain, request.gravity, exact
        twin = rows_of(model, [no_slip_twin(model, each) for each in driven.lines])
        with ThreadPoolExecutor(request.jobs) as pool:
            with_slip, without = pool.map(lambda rows: verify(rows, *setting), (driven.rows, twin))
        return with_slip, without

    proved = proved_plan(problem, find, simulated if request.verify else None)
    notes = (*proved.notes, NO_TURNS) if request.pivot and model.spot is None else proved.notes
    return result_of(replace(proved, notes=notes), problem, exact)


def result_of(proved: ProvedPlan, problem: Problem, obstacles: Obstacles) -> PlanResult:
    """A plan for a problem, with what there is to say of it, among obstacles without room."""
    rows, found, goal = proved.plan.rows, proved.plan.search.result(), problem.goal
    return PlanResult(
        rows,
        found.first_solution or math.nan,
        proved.planning,
        proved.plan.cost,
        found.nodes,
        least_clearance(obstacles, rows.x, rows.y, np.unwrap(rows.yaw)),
        math.dist((rows.x[-1], rows.y[-1]), goal[:2]),
        abs(math.remainder(rows.yaw[-1] - goal[2], 2.0 * math.pi)),
        problem.grid,
        problem.footprint,
        proved.verification,
        proved.no_slip,
        proved.notes,
    )


def poses_of(request: PlanRequest) -> tuple[Pose, Pose]:
    """Start and goal, both on the map."""
    frame, found = grid_frame(request.planning_map), []
    for name in ("start", "goal"):
        pose = getattr(request.planning_map, name)
        if pose is None:
            raise UsageError(
                f"--{name}", None, f"X,Y,YAW_DEG, here or as `{name}: [x_m, y_m, yaw_deg]` in the map's YAML"
            )
        if frame.cell(pose[0], pose[1]) is None:
            corners = [frame.to_world(c, r) for c in (0.0, frame.n_columns) for r in (0.0, frame.n_rows)]
            x, y = ([corner[k] for corner in corners] for k in (0, 1))
            given = f"{pose[0]:.10g},{pose[1]:.10g},{math.degrees(pose[2]):g}"
            x_range, y_range = (f"{min(v):.10g} to {max(v):.10g} m" for v in (x, y))
            allowed = f"a place on the map, x from {x_range}, y from {y_range}"
            raise UsageError(f"--{name}", given, allowed)
        found.append(pose)
    return found[0], found[1]


def check_apart(start: Pose, goal: Pose) -> None:
    """Refuse a goal that is where the start is."""
    apart, turn = math.dist(start[:2], goal[:2]), abs(math.remainder(goal[2] - start[2], 2.0 * math.pi))
    if max(apart, turn) < SAME_POSE:
        rounded = f", to {SAME_POSE:g} m and rad" if max(apart, turn) > 0.0 else ""
        raise NoAnswerError(f"start and goal are one pose{rounded}: there is nothing to drive")


def check_pose(request: PlanRequest, obstacles: Obstacles, name: str, pose: Pose) -> None:
    """Refuse a start or goal at which the footprint, with the clearance, touches something."""
    row, column = touched_cell(obstacles, *pose)
    if row != NOWHERE:
        room = f", {request.clearance:g} m of clearance included," if request.clearance else ""
        raise NoAnswerError(f"{name}: the footprint{room} touches {describe_cell(request.planning_map, row, column)}")


def check_goal(request: PlanRequest, obstacles: Obstacles, target: Target) -> None:
    """Refuse a goal if the footprint touches something at every pose within its tolerance."""
    if is_exact(target):
        check_pose(request, obstacles, "goal", target[:3])
    elif not is_clear_somewhere(obstacles, target):
        within = f"goal, anywhere within {target.distance:g} m and {math.degrees(target.turn):g} deg"
        check_pose(request, obstacles, within, target[:3])


def infeasible_ground(request: PlanRequest, field: SlopeField) -> str:
    """Why nothing can be driven."""
    low, high = (math.degrees(slope) for slope in slope_range(field))
    where = f"{low:.4g} deg" if is_plane(field) else f"{low:.4g} to {high:.4g} deg"
    return (
        f"{request.vehicle.name} can drive in no direction on {request.terrain.name} on this slope ({where}): "
        "there is no equilibrium within the limits of the profile"
    )


def summary_without(reason: str, verify: bool) -> dict[str, object]:
    """What `summary_of` has where there is no plan, for some reason."""
    keys = (*FIGURES, *(VERIFIED if verify else ()))
    return {"solved": False, **dict.fromkeys(keys), "reason": reason}


def summary_of(result: PlanResult) -> dict[str, object]:
    """A result as a JSON object."""
    rows, found, twin = result.rows, result.verification, result.no_slip
    values: tuple[object, ...] = (result.first_solution, result.planning, rows.length, float(rows.time[-1]))
    values += (result.cost, result.nodes, result.min_clearance, result.goal_distance, result.goal_yaw_error)
    summary = {"solved": True, **dict(zip(FIGURES, values, strict=True)), "reason": ""}
    if found is not None and twin is not None:
        values = (found.max_deviation, twin.max_deviation, found.collision, found.min_clearance)
        summary |= dict(zip(VERIFIED, values, strict=True))
    return summary
