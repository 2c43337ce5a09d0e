"""Plans on maps."""

from __future__ import annotations

import math
from pathlib import Path

from trackctl.api.arguments import check
from trackctl.files.map_file import read_planning_map
from trackctl.lut.grid import STEEPEST_SLOPE
from trackctl.mechanics.parameters import STANDARD_GRAVITY
from trackctl.planning.planning_map import PlanningMap, Pose
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.workflows import plan as plan_workflow
from trackctl.workflows.plan import PlanRequest, PlanResult, changed_map, search_settings
from trackctl.workflows.plan_choices import PlanCost

__all__ = ["PlanCost", "PlanResult", "PlanningMap", "load_map", "plan"]


def load_map(file: str | Path) -> PlanningMap:
    r"""A map: ROS map_server YAML, MovingAI ``.map``, or an elevation grid.

    Raises
    ------
    MapError
        If the file is none.

    Examples
    --------
    >>> from pathlib import Path
    >>> import trackctl
    >>> text = "obstacles:\n  circles: [[5, 5, 1.2]]\nbounds_m: [0, 0, 10, 10]\nslope_deg: 5\n"
    >>> Path("map.yaml").write_text(text) > 0
    True
    >>> found = trackctl.load_map("map.yaml")
    >>> len(found.circles), found.bounds
    (1, (0.0, 0.0, 10.0, 10.0))
    """
    return read_planning_map(str(file))


def plan(
    planning_map: PlanningMap,
    vehicle: VehicleProfile,
    terrain: TerrainProfile,
    *,
    start: Pose | None = None,
    goal: Pose | None = None,
    goal_tolerance: tuple[float, float] | None = None,
    slope: float | None = None,
    uphill_yaw: float | None = None,
    lut: str | Path | None = None,
    gravity: float = STANDARD_GRAVITY,
    most_speed: float | None = None,
    clearance: float = 0.0,
    cost: PlanCost = PlanCost.TIME,
    reverse: bool = False,
    pivot: bool | None = None,
    allow_unknown: bool = False,
    time_limit: float = 1.0,
    iterations: int | None = None,
    seed: int = 0,
    verify: bool = False,
    jobs: int = 1,
) -> PlanResult:
    """A collision-free, feasible trajectory with the sprocket rates that make the vehicle drive it; `plan`.

    Parameters
    ----------
    planning_map
        Of `load_map`.
    vehicle, terrain
        Profiles; those that the map names are not looked at.
    start, goal
        x, y [m] and yaw [rad], None for the map's own.
    goal_tolerance
        How far from the goal [m], and turned by how much [rad], it may end; None for the map's own, or met exactly.
    slope, uphill_yaw
        Of one plane, None for the map's own. [rad]
    lut
        Table to read, None for one from the user's cache folder, where it is compiled if need be.
    gravity
        [m/s2]
    most_speed
        None for the vehicle's. [m/s]
    clearance
        To keep. [m]
    cost
        What to have the least of.
    reverse, allow_unknown
        Whether to drive backwards, and on unknown cells, too.
    pivot
        Whether to turn on the spot where that is cheaper; None: only where there is no other way.
    time_limit, iterations
        How long to look for better ways; iterations, where given, in place of the time. [s]
    seed
        Of the search.
    verify
        Whether to simulate the plan.
    jobs
        Threads.

    Returns
    -------
    PlanResult
        `rows` has the trajectory as arrays.

    Raises
    ------
    NoAnswerError
        If there is no plan, with the reason.
    MapError, UsageError
        If start or goal lie outside the map, or a value is not allowed.

    Examples
    --------
    >>> from pathlib import Path
    >>> import trackctl
    >>> vehicle, terrain = trackctl.load_vehicle("utv-61cm"), trackctl.load_terrain("asphalt")
    >>> ground = trackctl.load_map("map.yaml")
    >>> found = trackctl.plan(ground, vehicle, terrain, start=(2, 2, 0), goal=(8, 8, 1.5), iterations=50)
    >>> print(f"{found.rows.x[-1]:.3f} {found.rows.y[-1]:.3f} {found.rows.yaw[-1]:.3f}")
    8.000 8.000 1.500
    """
    check("slope", slope, slope is None or 0.0 <= slope < STEEPEST_SLOPE, "from 0 to below pi/4")
    check("uphill_yaw", uphill_yaw, uphill_yaw is None or math.isfinite(uphill_yaw), "finite")
    within = goal_tolerance is None or (0.0 <= goal_tolerance[0] < math.inf and 0.0 <= goal_tolerance[1] <= math.pi)
    check("goal_tolerance", goal_tolerance, within, "a distance from 0 and an angle from 0 to pi")
    check("gravity", gravity, 0.0 < gravity < math.inf, "above 0")
    check("most_speed", most_speed, most_speed is None or 0.0 < most_speed < math.inf, "above 0")
    check("clearance", clearance, 0.0 <= clearance < math.inf, "0 or more")
    check("time_limit", time_limit, 0.0 < time_limit < math.inf, "above 0")
    check("iterations", iterations, iterations is None or iterations > 0, "above 0")
    request = PlanRequest(
        planning_map=changed_map(
            planning_map, (), start=start, goal=goal, goal_tolerance=goal_tolerance, slope=slope, uphill_yaw=uphill_yaw
        ),
        vehicle=vehicle,
        terrain=terrain,
        gravity=gravity,
        lut=None if lut is None else Path(lut),
        search=search_settings(seed, time_limit, iterations, cost),
        most_speed=most_speed,
        clearance=clearance,
        reverse=reverse,
        pivot=pivot,
        allow_unknown=allow_unknown,
        verify=verify,
        jobs=jobs,
    )
    return plan_workflow.plan(request)
