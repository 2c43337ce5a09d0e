"""Track forces along paths, forward dynamics, and slip learned from logs."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

from trackctl.api.arguments import check, unheard
from trackctl.files.csv_table import read_csv
from trackctl.files.path_csv import read_waypoints
from trackctl.lut.grid import STEEPEST_SLOPE
from trackctl.mechanics.parameters import STANDARD_GRAVITY
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.simulation.motion import State
from trackctl.simulation.track_speeds import TrackSpeeds, constant_speeds
from trackctl.workflows import forces as forces_workflow
from trackctl.workflows import identify as identify_workflow
from trackctl.workflows import simulate as simulate_workflow
from trackctl.workflows.drive_commands import DriveCommands, read_commands
from trackctl.workflows.forces import ForcesRequest, ForcesResult, SpeedRequest
from trackctl.workflows.forces_options import Basis, SpeedKind
from trackctl.workflows.forces_path import ForcesPath, arc_path, clothoid_path, waypoint_path
from trackctl.workflows.identify import IdentifyRequest, IdentifyResult
from trackctl.workflows.simulate import CircleTarget, SimulateRequest, SimulateResult, is_forced
from trackctl.workflows.slip_choices import FilterKind, SlipModel
from trackctl.workflows.steering import Measured, Steering
from trackctl.workflows.update_columns import Columns

__all__ = [
    "Basis",
    "CircleTarget",
    "DriveCommands",
    "FilterKind",
    "ForcesPath",
    "ForcesResult",
    "IdentifyResult",
    "Measured",
    "SimulateResult",
    "SlipModel",
    "SpeedKind",
    "SpeedRequest",
    "State",
    "Steering",
    "TrackSpeeds",
    "arc_path",
    "clothoid_path",
    "constant_speeds",
    "identify",
    "load_commands",
    "load_path",
    "nominal_forces",
    "simulate",
]

#: Yaw of a slope that rises along the y axis. [rad]
UPHILL_LEFT = 0.5 * math.pi
DEFAULT_SPEED = SpeedRequest(None, ends=0.2, peak=3.0)
FASTEST, COARSEST = 100.0, 1e-2


def load_path(file: str | Path, tolerance: float = 0.05, transition: float | None = None) -> ForcesPath:
    r"""A curve of continuous curvature along the waypoints of a CSV file (`x_m`, `y_m`, perhaps `speed_mps`).

    Parameters
    ----------
    file
        The CSV.
    tolerance
        How far the curve may leave waypoints that scatter. [m]
    transition
        Length to draw jumps of curvature out to. [m]

    Raises
    ------
    InputFileError, UsageError
        If the waypoints make no path, or a length is not allowed.

    Examples
    --------
    >>> from pathlib import Path
    >>> import trackctl
    >>> Path("path.csv").write_text("x_m,y_m\n0,0\n10,0\n20,5\n30,5\n") > 0
    True
    >>> round(trackctl.load_path("path.csv").path.length, 1)
    31.8
    """
    check("tolerance", tolerance, 0.0 <= tolerance < math.inf, "0 or more")
    check("transition", transition, transition is None or 0.0 < transition < math.inf, "above 0")
    return waypoint_path(read_waypoints(file), tolerance, transition)


def nominal_forces(
    vehicle: VehicleProfile,
    path: ForcesPath,
    speed: SpeedRequest = DEFAULT_SPEED,
    *,
    terrain: TerrainProfile | None = None,
    gravity: float = STANDARD_GRAVITY,
    slope: float = 0.0,
    uphill_yaw: float = UPHILL_LEFT,
    basis: Basis = Basis.SPLINE,
    order: int = 3,
    step: float | None = None,
    verify: bool = False,
) -> ForcesResult:
    """Nominal forces of both tracks along a path at desired speeds (Shiller, Serate and Hua 1993); `forces`.

    Parameters
    ----------
    vehicle
        Profile.
    path
        Of `arc_path`, `clothoid_path` or `load_path`.
    speed
        Shape, speed at the ends and peak; a shape of None is that of the path's file, or a triangle.
    terrain
        None for friction of 0.8 both ways.
    gravity
        [m/s2]
    slope, uphill_yaw
        Of the ground. [rad]
    basis, order
        Of the yaw; the order is that of the polynomial.
    step
        Between stations, None to choose. [m]
    verify
        Simulate the forces, too.

    Raises
    ------
    UsageError
        If the speeds or the step do not suit.
    NoAnswerError
        If the constraint has no solution, or no speed is feasible.

    Examples
    --------
    >>> import math
    >>> import trackctl
    >>> found = trackctl.nominal_forces(
    ...     trackctl.load_vehicle("shiller-1993"),
    ...     trackctl.arc_path(radius=5.0, angle=2.0 * math.pi),
    ...     trackctl.SpeedRequest(trackctl.SpeedKind.SMOOTH, ends=0.2, peak=3.0),
    ... )
    >>> bool(found.limits.feasible.all()), bool(abs(found.forces.residual).max() < 1e-6)
    (True, True)
    >>> bool((found.forces.right > found.forces.left).all())
    True
    """
    check("speed", speed.peak, 0.0 < speed.peak <= FASTEST, f"a peak above 0, up to {FASTEST:g} m/s")
    check("speed", speed.ends, 0.0 <= speed.ends <= FASTEST, f"ends from 0 to {FASTEST:g} m/s")
    check("gravity", gravity, 0.0 < gravity < math.inf, "above 0")
    check("slope", slope, 0.0 <= slope < STEEPEST_SLOPE, "from 0 to below pi/4")
    check("uphill_yaw", uphill_yaw, math.isfinite(uphill_yaw), "finite")
    check("order", order, 0 <= order <= 60, "from 0 to 60")
    check("step", step, step is None or 0.0 < step < math.inf, "above 0")
    request = ForcesRequest(vehicle, terrain, gravity, slope, uphill_yaw, path, speed, basis, order, step, verify)
    return forces_workflow.find_forces(request)


def load_commands(file: str | Path, vehicle: VehicleProfile) -> DriveCommands:
    r"""Sprocket rates, track speeds or track forces over time from a CSV file, for `simulate`.

    Raises
    ------
    InputFileError
        If the file holds no commands.

    Examples
    --------
    >>> from pathlib import Path
    >>> import trackctl
    >>> header = "time_s,track_speed_left_mps,track_speed_right_mps"
    >>> Path("commands.csv").write_text(f"{header}\n0,0.5,0.5\n4,0.5,1\n") > 0
    True
    >>> trackctl.load_commands("commands.csv", trackctl.load_vehicle("utv-61cm")).commands.right.tolist()
    [0.5, 1.0]
    """
    return read_commands(read_csv(file), vehicle.sprocket_radius)


def simulate(
    vehicle: VehicleProfile,
    terrain: TerrainProfile,
    drive: TrackSpeeds | CircleTarget | DriveCommands,
    *,
    slope: float = 0.0,
    uphill_yaw: float = UPHILL_LEFT,
    gravity: float = STANDARD_GRAVITY,
    feedback: Measured = Measured.NONE,
    initial: State | None = None,
    duration: float | None = None,
    tolerance: float = 1e-6,
    contact_memory: bool = True,
    interval: float = 0.1,
    lut: str | Path | None = None,
) -> SimulateResult:
    """Forward dynamics on a slope; `simulate`.

    Parameters
    ----------
    vehicle, terrain
        Profiles.
    drive
        Track speeds over time, laps of a circle, or the commands of a file (`load_commands`).
    slope, uphill_yaw
        Of the plane; track forces drive on level ground only. [rad]
    gravity
        [m/s2]
    feedback
        What is fed back, where there is a target.
    initial
        Where to start, None for the target's start or the origin at rest.
    duration
        None for that of the commands. [s]
    tolerance
        Relative, of a step.
    contact_memory
        Whether each shoe's point of entry is kept.
    interval
        Of the samples. [s]
    lut
        Table to read the commands of a circle from, None for exact solutions.

    Returns
    -------
    SimulateResult
        Its `problem` says why the simulation ended early, empty if it has not.

    Raises
    ------
    UsageError
        If an argument is out of its range, or does not go with `drive`.
    NoAnswerError
        If there are no commands for the target.

    Examples
    --------
    Unequal track speeds drive an arc that is wider than without slip (1.02 m):

    >>> import trackctl
    >>> result = trackctl.simulate(
    ...     trackctl.load_vehicle("utv-61cm"),
    ...     trackctl.load_terrain("asphalt"),
    ...     trackctl.constant_speeds(0.25, 0.5, duration=4.0),
    ... )
    >>> speed, rate = result.motion.forward_velocity[-1], result.motion.yaw_rate[-1]
    >>> result.problem, bool(speed / rate > 1.2)
    ('', True)
    """
    commands = DriveCommands(drive, None) if isinstance(drive, TrackSpeeds) else drive
    check("slope", slope, 0.0 <= slope < STEEPEST_SLOPE, "from 0 to below pi/4")
    check("slope", slope, slope == 0.0 or not is_forced(commands), "0, as forces are on level ground")
    check("uphill_yaw", uphill_yaw, math.isfinite(uphill_yaw), "finite")
    check("gravity", gravity, 0.0 < gravity < math.inf, "above 0")
    check("duration", duration, duration is None or 0.0 < duration < math.inf, "above 0")
    check("tolerance", tolerance, 1e-12 <= tolerance <= COARSEST, f"1e-12 to {COARSEST:g}")
    check("interval", interval, 0.0 < interval < math.inf, "above 0")
    if isinstance(commands, CircleTarget):
        check_circle(commands, vehicle)
        read = lut is None or commands.steering is not Steering.NO_SLIP
        check("lut", lut, read, "nothing with commands as if without slip")
    else:
        check("lut", lut, lut is None, "nothing but for a circle")
        followed = commands.target is not None and not is_forced(commands)
        check("feedback", feedback.value, followed or feedback is Measured.NONE, "none without a target")
    request = SimulateRequest(
        vehicle, terrain, gravity, slope, uphill_yaw, commands, feedback, initial, duration, tolerance, contact_memory,
        interval, None if lut is None else Path(lut),
    )  # fmt: skip
    return simulate_workflow.run_simulation(request)


def check_circle(target: CircleTarget, vehicle: VehicleProfile) -> None:
    """Refuse a circle that no vehicle drives."""
    half_gauge = 0.5 * vehicle.track_gauge
    check("radius", target.radius, half_gauge < abs(target.radius) <= 1e5, f"above half the gauge, {half_gauge:g}")
    check("speed", target.speed, 0.0 < target.speed <= FASTEST, f"above 0, up to {FASTEST:g}")
    check("laps", target.laps, 1 <= target.laps <= 1000, "1 to 1000")


def identify(
    log: str | Path,
    vehicle: VehicleProfile,
    *,
    model: SlipModel = SlipModel.PARAMETRIC,
    kind: FilterKind = FilterKind.WINDOW,
    window: float | None = None,
    horizon: float = 2.0,
    on_updates: Callable[[Columns], None] = unheard,
) -> IdentifyResult:
    r"""Learn a vehicle's slip from a log of track speeds and poses; `identify`.

    Parameters
    ----------
    log
        CSV: `time_s`, `track_speed_left_mps`, `track_speed_right_mps` (or sprocket rates), `x_m`, `y_m`, `yaw_rad`.
    vehicle
        Whose gauge and sprocket radius count.
    model, kind
        What is learned, and by which filter.
    window, horizon
        Over which motions are compared, and how far ahead they are predicted to be judged. [s]
    on_updates
        Told the columns of the command's CSV, by header, for each batch of poses.

    Raises
    ------
    UsageError
        If window or horizon are out of range.
    InputFileError
        If the log is none.
    NoAnswerError
        If it has no pose.

    Examples
    --------
    A vehicle whose tracks run 10 % faster than it moves:

    >>> from pathlib import Path
    >>> import trackctl
    >>> rows = [f"{k / 10},1.0,1.0,{0.09 * k},0,0" for k in range(200)]
    >>> header = "time_s,track_speed_left_mps,track_speed_right_mps,x_m,y_m,yaw_rad"
    >>> Path("log.csv").write_text("\n".join([header, *rows])) > 0
    True
    >>> vehicle = trackctl.load_vehicle("carrier-13t6")
    >>> result = trackctl.identify("log.csv", vehicle, model=trackctl.SlipModel.FACTORS)
    >>> result.updates, result.slip.p[9:].round(2).tolist()
    (200, [-0.1, -0.1])
    """
    request = IdentifyRequest(str(log), vehicle, model, kind, window, horizon)
    return identify_workflow.identify(request, on_updates)
