"""``trackctl simulate``: forward dynamics on a slope."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trackctl.cli import options
from trackctl.cli.csv_output import CsvOutput
from trackctl.cli.first_run import compile_first
from trackctl.cli.progress import say
from trackctl.cli.ranges import number
from trackctl.errors import NoAnswerError, UsageError
from trackctl.workflows.steering import Measured, Steering

if TYPE_CHECKING:
    from typing import Any

    from trackctl.workflows.drive_commands import DriveCommands
    from trackctl.workflows.simulate import CircleTarget, SimulateResult

DEFAULT_SLOPE_DEG, DEFAULT_RADIUS, DEFAULT_SPEED, DEFAULT_LAPS = 12.13, 2.0, 2.0 / 3.6, 3
DEFAULT_UPHILL_DEG = 90.0
STEEPEST_DEG, FASTEST, MOST_LAPS, MOST_ROWS = 45.0, 100.0, 1000, 10_000_000


def simulate(
    commands_csv: Annotated[
        str | None,
        typer.Argument(
            metavar="[COMMANDS]",
            help="CSV of time_s with sprocket_rate_left_radps and sprocket_rate_right_radps, or track_speed_left_mps "
            "and ..., or force_left_n and ...; linear between rows. The CSV of plan or forces as it is. - is standard "
            "input.",
            show_default=False,
        ),
    ] = None,
    track_speeds_mps: Annotated[
        str | None, typer.Option("--track-speeds-mps", metavar="LEFT,RIGHT", help="Constant, with --duration-s.")
    ] = None,
    circle_radius_m: Annotated[
        float | None,
        typer.Option("--circle-radius-m", help="Drive laps of a circle; negative to the right.", show_default="2"),
    ] = None,
    speed_mps: Annotated[
        float | None, typer.Option("--speed-mps", help="On the circle.", show_default="2 km/h")
    ] = None,
    laps: Annotated[int | None, typer.Option("--laps", help="Turns of 2 pi of yaw.", show_default="3")] = None,
    commands: Annotated[
        Steering,
        typer.Option(
            "--commands", help="For the circle: the path rule, a table read at its curvature, or as if without slip."
        ),
    ] = Steering.PATH,
    feedback: Annotated[
        Measured, typer.Option("--feedback", help="Corrections at 50 Hz, where there is a target.")
    ] = Measured.NONE,
    lut: Annotated[
        Path | None,
        typer.Option(
            "--lut",
            metavar="FILE",
            help="Read the commands of the circle from this table; the path rule then leaves out inertia.",
            show_default="exact solutions",
        ),
    ] = None,
    initial: Annotated[
        str | None,
        typer.Option(
            "--initial",
            metavar="X,Y,YAW_DEG",
            help="Where to start, at rest; a circle starts there in steady motion, its tangent along the yaw.",
            show_default="the target's start, or 0,0,0",
        ),
    ] = None,
    duration_s: Annotated[
        float | None, typer.Option("--duration-s", help="How long.", show_default="as long as the commands")
    ] = None,
    interval_s: Annotated[float, typer.Option("--interval-s", help="Between rows of the output.")] = 0.1,
    rtol: Annotated[float, typer.Option("--rtol", help="Relative tolerance of a step, 1e-12 to 1e-2.")] = 1e-6,
    contact_memory: Annotated[
        bool,
        typer.Option(
            "--contact-memory/--no-contact-memory",
            help="Keep where each shoe has entered the ground, or take the present motion to have lasted since.",
        ),
    ] = True,
    slope_deg: Annotated[
        float | None,
        typer.Option(
            "--slope-deg",
            help="Slope angle of one plane, 0 to 45.",
            show_default="12.13; 0 under track forces; the ground of a plan",
        ),
    ] = None,
    uphill_yaw_deg: Annotated[
        float | None,
        typer.Option(
            "--uphill-yaw-deg",
            help="Direction of up-slope, counter-clockwise from the x axis.",
            show_default="90; the ground of a plan",
        ),
    ] = None,
    vehicle: options.Vehicle = options.DEFAULT_VEHICLE,
    terrain: options.Terrain = options.DEFAULT_TERRAIN,
    gravity_mps2: options.Gravity = options.DEFAULT_GRAVITY,
    output: options.Output = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    as_json: options.Json = False,
) -> None:
    """Forward dynamics of a vehicle on a slope, under sprocket rates, track speeds or track forces; CSV of its motion.

    Without commands it drives three laps of a 2 m circle at 2 km/h, by the path rule. Track forces drive on level
    ground with the friction law of Shiller et al.

    Example:
      trackctl simulate --track-speeds-mps 0.2567,0.5 --duration-s 70 --json
    """
    from trackctl.files.profile_yaml import load_terrain, load_vehicle
    from trackctl.workflows.simulate import (
        CircleTarget,
        SimulateRequest,
        is_forced,
        motion_columns,
        result_summary,
        run_simulation,
    )

    destination = CsvOutput(output, force, as_json)
    destination.check()
    circle_given = {"--circle-radius-m": circle_radius_m, "--speed-mps": speed_mps, "--laps": laps}
    check_one_drive(commands_csv, track_speeds_mps, circle_given)
    check_within("--rtol", rtol, 1e-12, 1e-2)
    if uphill_yaw_deg is not None:
        check_within("--uphill-yaw-deg", uphill_yaw_deg, -360.0, 360.0)
    if duration_s is not None and not 0.0 < duration_s < math.inf:
        raise UsageError("--duration-s", duration_s, "above 0")
    if not 0.0 < interval_s < math.inf:
        raise UsageError("--interval-s", interval_s, "above 0")
    carrier = load_vehicle(vehicle)
    drive = chosen_drive(
        commands_csv, track_speeds_mps, duration_s, carrier, circle_radius_m, speed_mps, laps, commands
    )
    is_circle = isinstance(drive, CircleTarget)
    if lut is not None and (not is_circle or commands is Steering.NO_SLIP):
        raise UsageError("--lut", lut, "only for a circle, with --commands path or table")
    if commands is not Steering.PATH and not is_circle:
        raise UsageError("--commands", commands.value, "only for a circle")
    forced = is_forced(drive)
    has_target = isinstance(drive, CircleTarget) or drive.target is not None
    if feedback is not Measured.NONE and (forced or not has_target):
        raise UsageError("--feedback", feedback.value, "only for a circle, or track speeds with a target beside them")
    slope = asked_slope(drive, slope_deg, uphill_yaw_deg, forced)
    request = SimulateRequest(
        carrier,
        load_terrain(terrain),
        gravity_mps2,
        slope,
        math.radians(DEFAULT_UPHILL_DEG if uphill_yaw_deg is None else uphill_yaw_deg),
        drive,
        feedback,
        None if initial is None else initial_state(initial),
        duration_s,
        rtol,
        contact_memory,
        interval_s,
        lut,
    )
    check_rows(request_duration(drive, duration_s), interval_s)
    compile_first(quiet, "simulate", *([] if lut is None else ["look up"]))
    result = run_simulation(request)
    destination.write(motion_columns(result.motion), result_summary(result))
    report(result, quiet)
    if result.problem:
        raise NoAnswerError(result.problem)


def asked_slope(
    drive: CircleTarget | DriveCommands, slope_deg: float | None, uphill_yaw_deg: float | None, forced: bool
) -> float | None:
    """Slope of the plane [rad], None for the ground that a plan stands on."""
    from trackctl.workflows.simulate import CircleTarget

    planned = not isinstance(drive, CircleTarget) and drive.ground is not None
    if slope_deg is None and planned:
        if uphill_yaw_deg is not None:
            raise UsageError("--uphill-yaw-deg", uphill_yaw_deg, "beside a plan only with --slope-deg")
        return None
    slope = (0.0 if forced else DEFAULT_SLOPE_DEG) if slope_deg is None else slope_deg
    check_within("--slope-deg", slope, 0.0, 0.0 if forced else STEEPEST_DEG)
    return math.radians(slope)


def check_one_drive(commands_csv: str | None, track_speeds: str | None, circle: dict[str, float | None]) -> None:
    """Refuse more than one way to drive."""
    if commands_csv is not None and track_speeds is not None:
        raise UsageError("--track-speeds-mps", track_speeds, "nothing beside a file of commands")
    for option, value in circle.items():
        if value is not None and (commands_csv is not None or track_speeds is not None):
            raise UsageError(option, value, "nothing beside other commands")


def check_within(option: str, value: float, low: float, high: float) -> None:
    """Refuse a number out of its range."""
    if not low <= value <= high:
        raise UsageError(
            option, value, f"{low:g} to {high:g}" if low < high else f"{low:g}, as forces are on level ground"
        )


def chosen_drive(
    commands_csv: str | None,
    track_speeds: str | None,
    duration: float | None,
    carrier: Any,
    radius: float | None,
    speed: float | None,
    laps: int | None,
    steering: Steering,
) -> CircleTarget | DriveCommands:
    """What the vehicle is to do."""
    from trackctl.files.csv_table import read_csv
    from trackctl.workflows.drive_commands import read_commands
    from trackctl.workflows.simulate import CircleTarget, constant_drive

    if commands_csv is not None:
        return read_commands(read_csv(commands_csv), carrier.sprocket_radius)
    if track_speeds is not None:
        if duration is None:
            raise UsageError("--duration-s", None, "a time, beside --track-speeds-mps")
        left, right = numbers_of(track_speeds, "--track-speeds-mps", "LEFT,RIGHT, two numbers up to 100 either way", 2)
        for value in (left, right):
            check_within("--track-speeds-mps", value, -FASTEST, FASTEST)
        return constant_drive(left, right, duration)
    target = CircleTarget(
        DEFAULT_RADIUS if radius is None else radius,
        DEFAULT_SPEED if speed is None else speed,
        DEFAULT_LAPS if laps is None else laps,
        steering,
    )
    if not 0.0 < target.speed <= FASTEST:
        raise UsageError("--speed-mps", target.speed, f"above 0, up to {FASTEST:g}")
    if not 0.5 * carrier.track_gauge < abs(target.radius) <= 1e5:
        raise UsageError(
            "--circle-radius-m", target.radius, f"above half the gauge, {0.5 * carrier.track_gauge:g}, either way"
        )
    check_within("--laps", target.laps, 1, MOST_LAPS)
    return target


def numbers_of(text: str, option: str, allowed: str, count: int) -> list[float]:
    """A comma-separated list of finite numbers."""
    parts = text.split(",")
    if len(parts) != count:
        raise UsageError(option, text, allowed)
    return [number(part, option, allowed) for part in parts]


def initial_state(text: str) -> Any:
    """``X,Y,YAW_DEG`` at rest."""
    from trackctl.workflows.simulate import rest_at

    x, y, yaw = numbers_of(text, "--initial", "X,Y,YAW_DEG, three numbers", 3)
    return rest_at(x, y, math.radians(yaw))


def request_duration(drive: CircleTarget | DriveCommands, duration: float | None) -> float:
    """How long the motion will be, about. [s]"""
    from trackctl.workflows.simulate import CircleTarget

    if duration is not None:
        return duration
    if isinstance(drive, CircleTarget):
        return drive.laps * 2.0 * math.pi * abs(drive.radius) / drive.speed
    return float(drive.commands.time[-1] - drive.commands.time[0])


def check_rows(duration: float, interval: float) -> None:
    """Refuse an output that nobody can want."""
    if duration / interval > MOST_ROWS:
        raise UsageError("--interval-s", interval, f"at least {duration / MOST_ROWS:g}, for {MOST_ROWS} rows")


def report(result: SimulateResult, quiet: bool) -> None:
    """Say what the motion comes to."""
    if result.laps:
        radii = ", ".join(f"{lap.radius:.4f}" for lap in result.laps)
        drift = "" if result.drift is None else f"; drift {result.drift:.4f} m a lap"
        say(f"{len(result.laps)} laps of radius {radii} m{drift}", quiet)
    if result.max_deviation is not None and not result.problem:
        say(f"largest distance from the target {result.max_deviation:.4f} m", quiet)
