"""``trackctl plan``: from a map to a trajectory with sprocket commands."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from trackctl.cli import options
from trackctl.cli.csv_output import CsvOutput
from trackctl.cli.first_run import compile_first
from trackctl.cli.plot import missing, picture_path
from trackctl.cli.progress import bar, say
from trackctl.cli.ranges import number
from trackctl.errors import NoAnswerError, UsageError
from trackctl.workflows.plan_choices import PlanCost, PlanFormat

if TYPE_CHECKING:
    from trackctl.workflows.plan import PlanResult

DEFAULT_TIME_LIMIT = 1.0
STEEPEST_DEG, FASTEST, WIDEST_CLEARANCE, LONGEST_SEARCH, MOST_ITERATIONS = 44.9, 100.0, 100.0, 3600.0, 10**9
#: An end as close to the goal is met. [m], [rad]
MET = 1e-5
FARTHEST_OFF, MOST_TURNED_DEG = 1000.0, 180.0
POSE, TOLERANCE = "X,Y,YAW_DEG", "M[,DEG]"


def plan(
    map_file: Annotated[
        str,
        typer.Argument(
            metavar="MAP",
            help="ROS map_server YAML, MovingAI .map, or an elevation grid; - is YAML on standard input.",
            show_default=False,
        ),
    ],
    start: Annotated[
        str | None,
        typer.Option("--start", metavar=POSE, help="Where to start, at rest.", show_default="the map's"),
    ] = None,
    goal: Annotated[
        str | None,
        typer.Option("--goal", metavar=POSE, help="Where to stop.", show_default="the map's"),
    ] = None,
    goal_tolerance: Annotated[
        str | None,
        typer.Option(
            "--goal-tolerance",
            metavar=TOLERANCE,
            help="How far from the goal, and turned by how much, it may stop where that is cheaper or all that can be.",
            show_default="the map's, or met exactly",
        ),
    ] = None,
    slope_deg: Annotated[
        float | None, typer.Option("--slope-deg", help="Angle of one plane, 0 to 44.9.", show_default="the map's, or 0")
    ] = None,
    uphill_yaw_deg: Annotated[
        float | None,
        typer.Option(
            "--uphill-yaw-deg",
            help="Direction of up-slope, counter-clockwise from the x axis.",
            show_default="the map's, or 90",
        ),
    ] = None,
    elevation: Annotated[
        Path | None,
        typer.Option(
            "--elevation", metavar="FILE", help="Elevation grid in place of a plane.", show_default="the map's"
        ),
    ] = None,
    resolution_m: Annotated[
        float | None, typer.Option("--resolution-m", help="Width of a cell.", show_default="the map's")
    ] = None,
    allow_unknown: Annotated[
        bool, typer.Option("--allow-unknown", help="Drive on cells that are neither free nor occupied.")
    ] = False,
    speed_mps: Annotated[
        float | None, typer.Option("--speed-mps", help="Drive no faster.", show_default="the vehicle's top speed")
    ] = None,
    clearance_m: Annotated[
        float,
        typer.Option(
            "--clearance-m", help="To keep between the footprint and obstacles; on a slope more, if none is given."
        ),
    ] = 0.0,
    cost: Annotated[PlanCost, typer.Option("--cost", help="What to have the least of.")] = PlanCost.TIME,
    reverse: Annotated[bool, typer.Option("--reverse", help="Drive backwards, too.")] = False,
    pivot: Annotated[
        bool | None,
        typer.Option(
            "--pivot/--no-pivot",
            help="Turn on the spot, on level ground, where that is cheaper; never.",
            show_default="where there is no other way",
        ),
    ] = None,
    time_limit_s: Annotated[
        float | None,
        typer.Option(
            "--time-limit-s", help="How long to look for better ways.", show_default=f"{DEFAULT_TIME_LIMIT:g}"
        ),
    ] = None,
    iterations: Annotated[
        int | None,
        typer.Option("--iterations", help="Of the search, in place of a time: gives the same bytes every time."),
    ] = None,
    verify: Annotated[
        bool,
        typer.Option("--verify", help="Simulate the commands, and those without slip; exit 1 at a collision."),
    ] = False,
    picture: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw the plan on its map: .png, .svg or .pdf.")
    ] = None,
    form: Annotated[PlanFormat, typer.Option("--format", help="Of the output.")] = PlanFormat.CSV,
    lut: Annotated[
        Path | None,
        typer.Option(
            "--lut",
            metavar="FILE",
            help="Look-up table of the vehicle, terrain, gravity and slopes.",
            show_default="the map's, or one that is compiled and kept",
        ),
    ] = None,
    vehicle: Annotated[
        str | None,
        typer.Option(
            "--vehicle",
            metavar="NAME|FILE",
            help="Vehicle profile; `trackctl profiles list` names them.",
            autocompletion=options.complete_vehicle,
            show_default=f"the map's, or {options.DEFAULT_VEHICLE}",
        ),
    ] = None,
    terrain: Annotated[
        str | None,
        typer.Option(
            "--terrain",
            metavar="NAME|FILE",
            help="Terrain profile; `trackctl profiles list` names them.",
            autocompletion=options.complete_terrain,
            show_default=f"the map's, or {options.DEFAULT_TERRAIN}",
        ),
    ] = None,
    gravity_mps2: options.Gravity = options.DEFAULT_GRAVITY,
    seed: options.Seed = options.DEFAULT_SEED,
    jobs: options.Jobs = options.DEFAULT_JOBS,
    output: options.Output = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    as_json: options.Json = False,
) -> None:
    """A collision-free, feasible trajectory with the sprocket rates that make the vehicle really drive it.

    From rest to rest. Start, goal, slope, vehicle and more may stand in the map's YAML.

    Example:
      trackctl plan map.yaml --start 1,1,0 --goal 9,9,90 --slope-deg 12 --verify -o plan.csv
    """
    from trackctl.files.profile_yaml import load_terrain, load_vehicle

    destination = CsvOutput(output, force, as_json, writer(form))
    destination.check()
    check_picture(picture, force)
    check_bounds(
        {
            "--slope-deg": (slope_deg, 0.0, STEEPEST_DEG),
            "--uphill-yaw-deg": (uphill_yaw_deg, -360.0, 360.0),
            "--resolution-m": (resolution_m, 1e-3, 100.0),
            "--speed-mps": (speed_mps, 1e-3, FASTEST),
            "--clearance-m": (clearance_m, 0.0, WIDEST_CLEARANCE),
            "--time-limit-s": (time_limit_s, 1e-3, LONGEST_SEARCH),
            "--iterations": (iterations, 1, MOST_ITERATIONS),
        }
    )
    if time_limit_s is not None and iterations is not None:
        raise UsageError("--iterations", iterations, "nothing beside --time-limit-s")
    if elevation is not None and (slope_deg is not None or uphill_yaw_deg is not None):
        raise UsageError("--elevation", elevation, "nothing beside --slope-deg and --uphill-yaw-deg")
    planning_map = asked_map(
        map_file,
        elevation,
        start=None if start is None else pose_of(start, "--start"),
        goal=None if goal is None else pose_of(goal, "--goal"),
        goal_tolerance=None if goal_tolerance is None else tolerance_of(goal_tolerance, "--goal-tolerance"),
        slope=None if slope_deg is None else math.radians(slope_deg),
        uphill_yaw=None if uphill_yaw_deg is None else math.radians(uphill_yaw_deg),
        resolution=resolution_m,
    )
    for note in planning_map.notes:
        say(note, quiet)
    named = Path(planning_map.lut) if planning_map.lut else None
    tasks = {"plan": True, "solve columns": (lut or named) is None or reverse, "simulate": verify or bool(pivot)}
    result = planned(
        {
            "planning_map": planning_map,
            "vehicle": load_vehicle(vehicle or planning_map.vehicle or options.DEFAULT_VEHICLE),
            "terrain": load_terrain(terrain or planning_map.terrain or options.DEFAULT_TERRAIN),
            "gravity": gravity_mps2,
            "lut": lut or named,
            "most_speed": speed_mps,
            "clearance": clearance_m,
            "reverse": reverse,
            "pivot": pivot,
            "allow_unknown": allow_unknown,
            "verify": verify,
            "jobs": jobs,
        },
        (seed, time_limit_s or DEFAULT_TIME_LIMIT, iterations, cost),
        [task for task, is_needed in tasks.items() if is_needed],
        quiet,
        as_json,
    )
    hand_out(result, destination)
    if picture is not None:
        from trackctl.workflows.plan_picture import draw

        draw(result, planning_map, picture, force)
    report(result, quiet)


def check_bounds(bounds: dict[str, tuple[float | None, float, float]]) -> None:
    """Refuse numbers out of range, NaN among them."""
    for option, (value, low, high) in bounds.items():
        if value is not None and not low <= value <= high:
            raise UsageError(option, value, f"{low:g} to {high:g}")


def check_picture(picture: Path | None, force: bool) -> None:
    """Refuse a picture that could not be drawn or written, before the work starts."""
    from importlib.util import find_spec

    from trackctl.files.atomic import check_output

    if picture is None:
        return
    try:
        picture_path(picture, picture)
    except UsageError as error:
        raise UsageError("--plot", error.value, error.allowed) from None
    check_output(picture, force)
    if find_spec("matplotlib") is None:
        raise missing(ModuleNotFoundError(name="matplotlib"))


def writer(form: PlanFormat) -> Any:
    """What writes a plan in a form; None for CSV."""
    from trackctl.files.plan_formats import write_json, write_ros_path

    return {PlanFormat.CSV: None, PlanFormat.JSON: write_json, PlanFormat.ROS: write_ros_path}[form]


def pose_of(text: str, option: str) -> tuple[float, float, float]:
    """``X,Y,YAW_DEG``, with the yaw in rad."""
    allowed = f"{POSE}, three numbers in m and deg"
    parts = text.split(",")
    if len(parts) != 3:
        raise UsageError(option, text, allowed)
    x, y, yaw = (number(part, option, allowed) for part in parts)
    return x, y, math.radians(yaw)


def tolerance_of(text: str, option: str) -> tuple[float, float]:
    """``M[,DEG]``, with the angle in rad; 0 if none is given."""
    allowed = f"{TOLERANCE}: 0 to {FARTHEST_OFF:g} m and 0 to {MOST_TURNED_DEG:g} deg"
    found = [number(part, option, allowed) for part in text.split(",")]
    if len(found) > 2:
        raise UsageError(option, text, allowed)
    distance, turn = (*found, 0.0)[:2]
    if not (0.0 <= distance <= FARTHEST_OFF and 0.0 <= turn <= MOST_TURNED_DEG):
        raise UsageError(option, text, allowed)
    return distance, math.radians(turn)


def asked_map(map_file: str, elevation: Path | None, **given: Any) -> Any:
    """The map with what the options give in place of its own."""
    from trackctl.files.elevation_file import read_elevation
    from trackctl.files.map_file import read_planning_map
    from trackctl.workflows.plan import changed_map

    found = read_planning_map(map_file)
    if elevation is None:
        return changed_map(found, (), **given)
    heights, notes = read_elevation(elevation)
    return changed_map(found, notes, elevation=heights, **given)


def planned(
    fields: dict[str, Any], how: tuple[int, float, int | None, PlanCost], tasks: list[str], quiet: bool, as_json: bool
) -> PlanResult:
    """The plan; where there is none, a summary says so if it was asked for."""
    from trackctl.workflows.plan import PlanRequest, search_settings, summary_without
    from trackctl.workflows.plan import plan as find

    request = PlanRequest(**fields, search=search_settings(*how))
    compile_first(quiet, *tasks)
    try:
        with bar("table", "column", quiet) as compiling, bar("search", "", quiet) as searching:
            return find(request, compiling, lambda done, total: searching(int(100 * done / total), 100))
    except NoAnswerError as error:
        if as_json:
            typer.echo(json.dumps(summary_without(str(error), request.verify)))
        raise


def hand_out(result: PlanResult, destination: CsvOutput) -> None:
    """Write the plan and its summary."""
    from trackctl.workflows.plan import summary_of
    from trackctl.workflows.plan_rows import columns_of

    destination.write(columns_of(result.rows), summary_of(result))


def report(result: PlanResult, quiet: bool) -> None:
    """Say what the plan comes to.

    Raises
    ------
    NoAnswerError
        If its simulation fails or touches something.
    """
    rows = result.rows
    for note in result.notes:
        say(note, quiet)
    say(
        f"{rows.length:.2f} m in {rows.time[-1]:.2f} s, clearance {result.min_clearance:.3f} m; first way after "
        f"{result.first_solution:.3f} s, done after {result.planning:.2f} s",
        quiet,
    )
    if max(result.goal_distance, result.goal_yaw_error) > MET:
        off = math.degrees(result.goal_yaw_error)
        say(f"ends {result.goal_distance:.3f} m and {off:.1f} deg from the goal, within its tolerance", quiet)
    if result.verification is None or result.no_slip is None:
        return
    found, without = result.verification, result.no_slip
    say(
        f"simulated: within {found.max_deviation:.3f} m of the plan, clearance {found.min_clearance:.3f} m; "
        f"commands without slip: {without.max_deviation:.3f} m",
        quiet,
    )
    if found.problem:
        raise NoAnswerError(f"the simulation of the plan has ended early: {found.problem}")
    if found.collision:
        raise NoAnswerError("the simulated footprint touches an obstacle")
