"""``trackctl forces``: nominal track forces along a path."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

import typer

from trackctl.cli import options
from trackctl.cli.csv_output import CsvOutput
from trackctl.cli.progress import say
from trackctl.cli.ranges import number
from trackctl.errors import NoAnswerError, UsageError
from trackctl.workflows.forces_options import Basis, SpeedKind

if TYPE_CHECKING:
    from trackctl.files.csv_writer import Column
    from trackctl.workflows.forces import ForcesResult, SpeedRequest
    from trackctl.workflows.forces_path import ForcesPath

DEFAULT_VEHICLE = "shiller-1993"
DEFAULT_RADIUS = 5.0
DEFAULT_PEAK = 3.0
DEFAULT_ENDS = 0.2
LARGEST_SPEED = 100.0
RADII = (0.01, 1e6)
MOST_TURN = 36000.0
STEEPEST = 45.0

#: Column of the CSV table for each array of the nominal forces.
COLUMNS = {
    "arc_length_m": "arc_length",
    "time_s": "time",
    "x_m": "x",
    "y_m": "y",
    "yaw_rad": "yaw",
    "yaw_rate_radps": "yaw_rate",
    "speed_mps": "speed",
    "slip_angle_rad": "sideslip",
    "yaw_gradient_1pm": "yaw_gradient",
    "icr_offset_m": "zero_slide_offset",
    "force_total_n": "total",
    "force_difference_n": "difference",
    "force_left_n": "left",
    "force_right_n": "right",
    "friction_moment_nm": "friction_moment",
    "constraint_residual": "residual",
}
#: And for each of the simulated motion.
SIMULATED = {
    "simulated_x_m": "x",
    "simulated_y_m": "y",
    "simulated_yaw_rad": "yaw",
    "simulated_yaw_rate_radps": "yaw_rate",
    "simulated_speed_mps": "speed",
    "simulated_slip_angle_rad": "sideslip",
}
REASONS = {
    "curvature_jump": "at a jump of curvature",
    "beyond_contact": "sliding to one side along all of the track (D beyond L/2)",
    "beyond_grip": "with a force beyond the friction of a track",
    "beyond_drive": "with a force beyond the drive of a track",
    "lifted": "with a track or its end lifted",
    "unbalanced": "out of balance sideways",
}


def forces(
    path: Annotated[
        str | None,
        typer.Argument(
            metavar="PATH",
            help="CSV of waypoints x_m, y_m and perhaps speed_mps, or of `trackctl plan`; - is standard input.",
            show_default=f"a circle of {DEFAULT_RADIUS:g} m",
        ),
    ] = None,
    circle_radius_m: Annotated[
        float | None, typer.Option("--circle-radius-m", help="Of a circle; negative to the right.")
    ] = None,
    arc_deg: Annotated[
        float | None, typer.Option("--arc-deg", help="Part of the circle, or several turns of it.", show_default="360")
    ] = None,
    clothoid: Annotated[
        str | None,
        typer.Option(
            "--clothoid",
            metavar="RADIUS,ENTRY,ARC,EXIT",
            help="A curve between straights: a clothoid, an arc and a clothoid, lengths in m.",
        ),
    ] = None,
    speed_profile: Annotated[
        SpeedKind | None,
        typer.Option(
            "--speed-profile",
            help="Shape of the speed; optimal is the fastest within all limits.",
            show_default="that of the CSV, or else triangular",
        ),
    ] = None,
    speed_mps: Annotated[
        float | None,
        typer.Option(
            "--speed-mps", help="Peak speed.", show_default=f"{DEFAULT_PEAK:g}; with optimal, the vehicle's top speed"
        ),
    ] = None,
    speed_start_mps: Annotated[
        float | None, typer.Option("--speed-start-mps", help="At both ends.", show_default=f"{DEFAULT_ENDS:g}")
    ] = None,
    basis: Annotated[
        Basis, typer.Option("--basis", help="Sideslip as a spline, or yaw gradient as a polynomial.")
    ] = Basis.SPLINE,
    order: Annotated[
        int | None, typer.Option("--order", min=0, max=60, help="Of the polynomial.", show_default="3")
    ] = None,
    transition_length_m: Annotated[
        float | None,
        typer.Option("--transition-length-m", help="Draw jumps of curvature out to this length."),
    ] = None,
    fit_tolerance_m: Annotated[
        float, typer.Option("--fit-tolerance-m", help="How far a curve may leave waypoints that scatter.")
    ] = 0.05,
    step_m: Annotated[
        float | None,
        typer.Option("--step-m", help="Between stations.", show_default="a fortieth of the ground contact"),
    ] = None,
    slope_deg: Annotated[float, typer.Option("--slope-deg", help="Angle of the ground, below 45.")] = 0.0,
    uphill_yaw_deg: Annotated[
        float, typer.Option("--uphill-yaw-deg", help="Direction of steepest ascent from the x axis.")
    ] = 90.0,
    strict: Annotated[bool, typer.Option("--strict", help="Exit with 1 if a station is not drivable.")] = False,
    verify: Annotated[
        bool, typer.Option("--verify", help="Simulate the forces, say how far they err, add the simulated motion.")
    ] = False,
    vehicle: options.Vehicle = DEFAULT_VEHICLE,
    terrain: Annotated[
        str | None,
        typer.Option(
            "--terrain",
            metavar="NAME|FILE",
            help="Terrain profile.",
            autocompletion=options.complete_terrain,
            show_default="friction 0.8 both ways",
        ),
    ] = None,
    gravity_mps2: options.Gravity = options.DEFAULT_GRAVITY,
    output: options.Output = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    as_json: options.Json = False,
) -> None:
    """Nominal forces of both tracks along a path at desired speeds, as CSV (Shiller, Serate and Hua 1993).

    `feasible` says where the vehicle can put them on the ground.

    Example:
      trackctl forces --circle-radius-m 5 --speed-profile smooth --verify
    """
    from trackctl.files.profile_yaml import load_terrain, load_vehicle
    from trackctl.workflows.forces import ForcesRequest, find_forces

    destination = CsvOutput(output, force, as_json)
    destination.check()
    if order is not None and basis is not Basis.POLYNOMIAL:
        raise UsageError("--order", order, "a number beside --basis polynomial")
    for option, value in (("--step-m", step_m), ("--transition-length-m", transition_length_m)):
        if value is not None:
            check_within(option, value, 0.0, math.inf, low_excluded=True)
    check_within("--slope-deg", slope_deg, 0.0, STEEPEST, high_excluded=True)
    check_within("--uphill-yaw-deg", uphill_yaw_deg, -MOST_TURN, MOST_TURN)
    check_within("--fit-tolerance-m", fit_tolerance_m, 0.0, math.inf, high_excluded=True)
    carrier = load_vehicle(vehicle)
    ground = None if terrain is None else load_terrain(terrain)
    curve = asked_path(path, circle_radius_m, arc_deg, clothoid, transition_length_m, fit_tolerance_m)
    has_speeds = curve.squared_speed is not None
    request = ForcesRequest(
        carrier,
        ground,
        gravity_mps2,
        math.radians(slope_deg),
        math.radians(uphill_yaw_deg),
        curve,
        asked_speed(speed_profile, speed_mps, speed_start_mps, carrier.max_speed, has_speeds),
        basis,
        3 if order is None else order,
        step_m,
        verify,
    )
    found = find_forces(request)
    destination.write(columns_of(found), summary_of(found))
    report(found, strict, quiet)


def check_within(
    option: str,
    value: float,
    low: float,
    high: float,
    *,
    low_excluded: bool = False,
    high_excluded: bool = False,
) -> None:
    """Refuse a number out of range; NaN is, and so is an infinite one."""
    inside = low <= value <= high and math.isfinite(value)
    if not inside or (low_excluded and value == low) or (high_excluded and value == high):
        lower = f"above {low:g}" if low_excluded else f"{low:g}"
        upper = "" if math.isinf(high) else f"{' and below' if high_excluded else ' to'} {high:g}"
        raise UsageError(option, value, f"{lower}{upper or ' or more'}")


def asked_path(
    path: str | None,
    radius: float | None,
    arc_deg: float | None,
    clothoid: str | None,
    transition: float | None,
    tolerance: float,
) -> ForcesPath:
    """The path of the arguments, of which there may be one kind."""
    from trackctl.files.path_csv import read_waypoints
    from trackctl.workflows.forces_path import arc_path, clothoid_path, waypoint_path

    if path is not None:
        for option, value in (("--circle-radius-m", radius), ("--arc-deg", arc_deg), ("--clothoid", clothoid)):
            if value is not None:
                raise UsageError(option, value, "nothing beside a CSV of waypoints")
        return waypoint_path(read_waypoints(path), tolerance, transition)
    if clothoid is not None:
        for option, value in (("--circle-radius-m", radius), ("--arc-deg", arc_deg)):
            if value is not None:
                raise UsageError(option, value, "nothing beside --clothoid")
        return clothoid_path(*clothoid_lengths(clothoid), transition)
    if transition is not None:
        raise UsageError("--transition-length-m", transition, "nothing with a circle, whose curvature does not jump")
    radius = DEFAULT_RADIUS if radius is None else radius
    check_within("--circle-radius-m", abs(radius), *RADII)
    angle = 360.0 if arc_deg is None else arc_deg
    check_within("--arc-deg", angle, 0.0, MOST_TURN, low_excluded=True)
    return arc_path(radius, math.radians(angle))


def clothoid_lengths(text: str) -> tuple[float, float, float, float]:
    """Radius and the three lengths. [m]"""
    allowed = "RADIUS,ENTRY,ARC,EXIT, four numbers in m, the lengths 0 or more"
    parts = [number(part, "--clothoid", allowed) for part in text.split(",")]
    if len(parts) != 4 or min(parts[1:]) < 0.0:
        raise UsageError("--clothoid", text, allowed)
    check_within("--clothoid radius", abs(parts[0]), *RADII)
    radius, entry, middle, exit_length = parts
    return radius, entry, middle, exit_length


def asked_speed(
    kind: SpeedKind | None, peak: float | None, ends: float | None, top: float, has_speeds: bool
) -> SpeedRequest:
    """The speeds of the options."""
    from trackctl.workflows.forces import SpeedRequest

    for option, value in (("--speed-mps", peak), ("--speed-start-mps", ends)):
        if value is None:
            continue
        if kind is None and has_speeds:
            raise UsageError(option, value, "nothing beside the speeds of the CSV, unless --speed-profile is given")
        check_within(option, value, 0.0, LARGEST_SPEED, low_excluded=option == "--speed-mps")
    if kind is SpeedKind.CONSTANT and ends is not None:
        raise UsageError("--speed-start-mps", ends, "nothing with --speed-profile constant")
    peak = peak if peak is not None else top if kind is SpeedKind.OPTIMAL else DEFAULT_PEAK
    return SpeedRequest(kind, DEFAULT_ENDS if ends is None else ends, peak)


def columns_of(found: ForcesResult) -> dict[str, Column]:
    """The forces as columns of a CSV table."""
    columns: dict[str, Column] = {header: getattr(found.forces, name) for header, name in COLUMNS.items()}
    columns |= {"feasible": found.limits.feasible}
    if found.trial is not None:
        simulated = found.trial.simulated(found.forces)
        columns |= {header: simulated[name] for header, name in SIMULATED.items()}
    return columns


def summary_of(found: ForcesResult) -> dict[str, object]:
    """What there is to say about the forces, for JSON."""
    from trackctl.workflows.forces import limit_counts

    friction = found.required_friction
    summary: dict[str, object] = {
        "max_residual": float(abs(found.forces.residual).max()),
        "feasible": bool(found.limits.feasible.all()),
        "required_friction_coefficient": friction if math.isfinite(friction) else None,
        "stations": int(found.limits.feasible.size),
        "infeasible_stations": int((~found.limits.feasible).sum()),
        "infeasible": limit_counts(found.limits),
        "length_m": float(found.forces.arc_length[-1]),
        "duration_s": float(found.forces.time[-1]),
        "max_speed_mps": float(found.forces.speed.max()),
    }
    return summary if found.trial is None else summary | {"max_deviation_m": found.trial.largest_deviation}


def report(found: ForcesResult, strict: bool, quiet: bool) -> None:
    """Say how the forces are, and raise a `NoAnswerError` if they must be drivable and are not."""
    from trackctl.workflows.forces import limit_counts

    for note in found.notes:
        say(note, quiet)
    if found.trial is not None:
        say(f"simulated: the mass centre stays within {found.trial.largest_deviation:.3g} m of the path", quiet)
    total, bad = found.limits.feasible.size, int((~found.limits.feasible).sum())
    reasons = [f"{count} {REASONS[name]}" for name, count in limit_counts(found.limits).items() if count]
    if not bad:
        words = f"all {total} stations are drivable"
    else:
        words = f"{bad} of {total} stations are not drivable: {', '.join(reasons)}"
    if bad and strict:
        raise NoAnswerError(words)
    say(
        f"{words}; needs friction {found.required_friction:.3g}; largest residual "
        f"{float(abs(found.forces.residual).max()):.2g}",
        quiet,
    )
