"""`simulate`: forward dynamics of a vehicle on a slope plane, under track speeds, sprocket rates or track forces."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from trackctl.errors import NoAnswerError, UsageError
from trackctl.files.lut_match import check_matches
from trackctl.files.lut_reader import read_lut
from trackctl.geometry.circle import Circle
from trackctl.lut.interpolation import interpolant, look_up
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.simulation.following import Feedback, deviation, follow, start_on
from trackctl.simulation.laps import drift_per_lap, laps
from trackctl.simulation.motion import End, Integration, Motion, State, sample, simulate, turn_time
from trackctl.simulation.path import Path as TargetPath
from trackctl.simulation.path import circle
from trackctl.simulation.path_rule import (
    PathCommands,
    Reading,
    naive_commands,
    no_slip_commands,
    path_commands,
    read_naive_commands,
    read_path_commands,
)
from trackctl.simulation.track_force_drive import BodyState, TrackForces, TrackForceVehicle, drive_linear
from trackctl.simulation.track_speeds import SHORTEST, TrackSpeeds, constant_speeds
from trackctl.simulation.vehicle_rates import Scene, scene
from trackctl.workflows.drive_commands import DriveCommands, target_commands
from trackctl.workflows.steering import Measured, Steering
from trackctl.workflows.unrolled_ground import Unrolled, unrolled

Array = NDArray[np.float64]

#: Laps that commands are made for, over and above those asked for: the vehicle may turn slower than it should.
SPARE_LAPS = 1.0
#: Largest residual of commands that are driven.
LARGEST_RESIDUAL = 1e-8

REASONS = {
    End.LIFTED: "a track lifts off the ground",
    End.PITCHED: "the vehicle pitches over",
    End.STUCK: "the integration cannot go on: its step has become too small",
}


@dataclass(frozen=True, slots=True)
class CircleTarget:
    """Laps of a circle: radius, negative to the right [m], speed [m/s], laps, and the way to its commands."""

    radius: float
    speed: float
    laps: int
    steering: Steering


@dataclass(frozen=True, slots=True)
class SimulateRequest:
    """What to simulate.

    Attributes
    ----------
    vehicle, terrain, gravity
        [m/s2]
    slope, uphill_yaw
        Of the plane, None for the ground that the commands stand beside. [rad]
    drive
        The target or the commands.
    feedback
        What is fed back, where there is a target.
    initial
        Where to start, None for the target's start or the origin. A circle starts there, its tangent along the yaw.
    duration
        None for that of the commands. [s]
    tolerance
        Relative, of a step.
    contact_memory
        Whether each shoe's point of entry is kept.
    interval
        Of the output. [s]
    lut
        Table to read the commands of a circle from, None for exact solutions.
    """

    vehicle: VehicleProfile
    terrain: TerrainProfile
    gravity: float
    slope: float | None
    uphill_yaw: float
    drive: CircleTarget | DriveCommands
    feedback: Measured = Measured.NONE
    initial: State | None = None
    duration: float | None = None
    tolerance: float = 1e-6
    contact_memory: bool = True
    interval: float = 0.1
    lut: Path | None = None


@dataclass(frozen=True, slots=True, eq=False)
class SimulateResult:
    """A simulated motion and what it comes to.

    Attributes
    ----------
    motion
        Samples.
    laps
        Circles of the whole laps.
    drift
        Mean distance of their successive centres, None for fewer than two. [m]
    max_deviation
        Largest distance from the target path, None where there is none. [m]
    problem
        Why the simulation has ended early, empty if it has not.
    """

    motion: Motion
    laps: list[Circle]
    drift: float | None
    max_deviation: float | None
    problem: str


def run_simulation(request: SimulateRequest) -> SimulateResult:
    """Simulate what a request asks for.

    Raises
    ------
    NoAnswerError
        If there are no commands for the target.
    LutMismatchError
        If the table is made for something else.
    """
    slope, uphill_yaw = plane_of(request)
    profiles = request.vehicle, request.terrain, request.gravity
    ground = scene(*profiles, slope, uphill_yaw, remember=request.contact_memory)
    if isinstance(request.drive, CircleTarget):
        return drive_circle(request, ground, request.drive)
    if isinstance(request.drive.commands, TrackForces):
        return drive_forced(request, request.drive.commands, request.drive)
    return drive_speeds(request, ground, request.drive.commands, request.drive)


def plane_of(request: SimulateRequest) -> tuple[float, float]:
    """Slope and direction of up-slope of the plane, or of the ground at the start. [rad]"""
    if request.slope is not None:
        return request.slope, request.uphill_yaw
    ground = request.drive.ground if isinstance(request.drive, DriveCommands) else None
    if ground is None:
        raise ValueError("no plane is asked for, and no ground stands beside the commands")
    return float(ground.slope[0]), float(ground.yaw[0] - ground.heading[0])


def drive_circle(request: SimulateRequest, ground: Scene, target: CircleTarget) -> SimulateResult:
    """Drive laps of a circle."""
    start = request.initial or State()
    path = circle(target.radius, target.speed, 1.5 * target.laps + SPARE_LAPS, start.pose)
    commands = circle_commands(request, ground, path, target.steering)
    turn = 2.0 * math.pi * target.laps
    simulation, end = follow(
        ground,
        commands,
        Feedback(request.feedback.value),
        start_on(commands),
        request.tolerance,
        steady_start=True,
        duration=math.inf if request.duration is None else request.duration,
        most_turn=turn if request.duration is None else math.inf,
    )
    last = turn_time(simulation, turn) if end is End.TURNED else simulation.time
    return summary(request, simulation, end, last, path)


def circle_commands(request: SimulateRequest, ground: Scene, path: TargetPath, steering: Steering) -> PathCommands:
    """Commands along a path, all of them solved."""
    if steering is Steering.NO_SLIP:
        commands = no_slip_commands(ground, path)
    elif request.lut is None:
        commands = (naive_commands if steering is Steering.TABLE else path_commands)(ground, path)
    else:
        by_table = read_naive_commands if steering is Steering.TABLE else read_path_commands
        commands = by_table(ground, path, reading(request, request.lut))
    unsolved = np.flatnonzero(~(commands.residual <= LARGEST_RESIDUAL))
    if unsolved.size:
        place = commands.path.arc_length[unsolved[0]]
        raise NoAnswerError(
            f"no track speeds hold the path {place:.3g} m from its start (heading "
            f"{math.degrees(commands.path.tangent[unsolved[0]] - request.uphill_yaw) % 360.0:.0f} deg from up-slope): "
            f"{unsolved.size} of {commands.residual.size} samples have no equilibrium"
            f"{'' if request.lut is None else f' in {request.lut}'}"
        )
    return commands


def reading(request: SimulateRequest, lut: Path) -> Reading:
    """The table of steady turns in a file."""
    table = read_lut(lut)
    check_matches(table, request.vehicle, request.terrain, request.gravity, lut)
    packed = interpolant(table)

    def read(speed: Array, curvature: Array, heading: Array) -> Array:
        found = look_up(packed, plane_of(request)[0], speed, curvature, heading)
        return np.stack((found.track_speed_left / speed, found.track_speed_right / speed, found.sideslip))

    return read


def drive_speeds(request: SimulateRequest, ground: Scene, speeds: TrackSpeeds, drive: DriveCommands) -> SimulateResult:
    """Drive under track speeds over time; the target beside them, if there is one, is where to start."""
    speeds = speeds if request.duration is None else speeds.until(float(speeds.time[0]) + request.duration)
    if drive.target is None:
        simulation, end = simulate(ground, speeds, request.initial or State(), request.tolerance)
        return summary(request, simulation, end, simulation.time, None)
    flat = unrolled_of(request, drive)
    target = drive.target
    if flat is not None:
        target = replace(target, x=flat.x, y=flat.y, yaw=flat.yaw)
    commands = target_commands(target, drive.commands)  # type: ignore[arg-type]
    start = start_on(commands) if request.initial is None else request.initial
    steady_start = request.initial is None and not start.is_rest
    if request.feedback is Measured.NONE and flat is None:
        simulation, end = simulate(ground, speeds, start, request.tolerance, steady_start=steady_start)
    else:
        simulation, end = follow(
            ground,
            commands,
            Feedback(request.feedback.value),
            start,
            request.tolerance,
            steady_start=steady_start,
            duration=math.inf if request.duration is None else request.duration,
            slopes=None if flat is None else flat.slopes,
        )
    nothing = np.zeros_like(drive.target.x)
    path = TargetPath(nothing, drive.target.x, drive.target.y, nothing, nothing, nothing)
    return summary(request, simulation, end, simulation.time, path, flat)


def unrolled_of(request: SimulateRequest, drive: DriveCommands) -> Unrolled | None:
    """The unrolled ground of commands that stand beside ground of changing slope, if they count."""
    if request.slope is not None or drive.ground is None or drive.ground.is_plane:
        return None
    if request.initial is not None:
        raise UsageError(
            "--initial", "a pose", "nothing beside a plan on an elevation grid, which tells where to start"
        )
    return unrolled(drive.ground)


def output_times(first: float, last: float, interval: float) -> Array:
    """Even times from the first on, and the last."""
    time = first + interval * np.arange(math.ceil((last - first) / interval - 1e-9))
    return np.append(time, last)


def summary(
    request: SimulateRequest,
    simulation: Integration,
    end: End,
    last: float,
    path: TargetPath | None,
    flat: Unrolled | None = None,
) -> SimulateResult:
    """Samples, laps and deviation of a simulation up to a time."""
    steps = simulation.steps[: simulation.count]
    if not steps.size:
        why = REASONS.get(end, f"its commands last no longer than {SHORTEST:g} s")
        raise NoAnswerError(f"the simulation cannot begin: {why}")
    times = output_times(float(steps["time"][0]), last, request.interval)
    slopes = None if flat is None else flat.slopes
    motion = sample(simulation, request.vehicle.mass, times, slopes)
    circles = laps(simulation)
    places, at = steps["pose"][steps["time"] < last], steps["time"][steps["time"] < last]
    if flat is not None:
        x, y, yaw = flat.to_map(times, motion.x, motion.y, motion.yaw)
        motion = replace(motion, x=x, y=y, yaw=yaw)
        places = np.stack(flat.to_map(at, *places[:, 0].T), axis=-1)
    away = None
    if path is not None:
        away = float(deviation(path, places[..., 0].ravel(), places[..., 1].ravel()).max())
    problem = f"{REASONS[end]} at {simulation.time:.6g} s" if end in REASONS else ""
    return SimulateResult(motion, circles, drift_per_lap(circles), away, problem)


def drive_forced(request: SimulateRequest, forces: TrackForces, drive: DriveCommands) -> SimulateResult:
    """Drive under track forces on level ground."""
    vehicle, terrain = request.vehicle, request.terrain
    rider = TrackForceVehicle(
        mass=vehicle.mass,
        yaw_inertia=vehicle.yaw_inertia,
        gauge=vehicle.track_gauge,
        length=vehicle.contact_length,
        cog_height=vehicle.cog_height,
        lateral_friction=terrain.lateral_friction_coefficient or terrain.friction_coefficient,
        gravity=request.gravity,
    )
    first = float(forces.time[0])
    last = float(forces.time[-1]) if request.duration is None else first + request.duration
    start, away, target = request.initial or State(), None, drive.target
    if target is not None and request.initial is None:
        start = State(
            float(target.x[0]),
            float(target.y[0]),
            float(target.yaw[0]),
            float(target.speed[0] * math.cos(target.sideslip[0])),
            float(target.speed[0] * math.sin(target.sideslip[0])),
            float(np.gradient(target.yaw, target.time)[0]),
        )
    time = output_times(first, last, request.interval)
    begin = BodyState(*start.pose, *start.velocity)
    x, y, yaw, forward, lateral, yaw_rate = np.array(drive_linear(rider, begin, forces, time, request.tolerance))
    if target is not None:
        nothing = np.zeros_like(target.x)
        path = TargetPath(nothing, target.x, target.y, nothing, nothing, nothing)
        away = float(deviation(path, x, y).max())
    unknown, load = np.full_like(time, np.nan), np.full_like(time, 0.5 * vehicle.mass * request.gravity)
    motion = Motion(time, x, y, yaw, forward, lateral, yaw_rate, unknown, unknown, unknown, unknown, load, load)
    return SimulateResult(motion, [], None, away, "")


def rest_at(x: float, y: float, yaw: float) -> State:
    """At rest, at x, y [m] and yaw. [rad]"""
    return State(x, y, yaw)


def is_forced(drive: CircleTarget | DriveCommands) -> bool:
    """Whether track forces drive the vehicle."""
    return isinstance(drive, DriveCommands) and isinstance(drive.commands, TrackForces)


def constant_drive(left: float, right: float, duration: float) -> DriveCommands:
    """Constant track speeds [m/s] for a time. [s]"""
    return DriveCommands(constant_speeds(left, right, duration), None)


def motion_columns(motion: Motion) -> dict[str, Array]:
    """A motion as columns of a CSV table."""
    return {
        "time_s": motion.time,
        "x_m": motion.x,
        "y_m": motion.y,
        "yaw_rad": motion.yaw,
        "forward_velocity_mps": motion.forward_velocity,
        "lateral_velocity_mps": motion.lateral_velocity,
        "yaw_rate_radps": motion.yaw_rate,
        "track_speed_left_mps": motion.track_speed_left,
        "track_speed_right_mps": motion.track_speed_right,
        "slip_left": motion.slip_left,
        "slip_right": motion.slip_right,
        "load_left_n": motion.load_left,
        "load_right_n": motion.load_right,
    }


def result_summary(result: SimulateResult) -> dict[str, object]:
    """A result as a JSON object."""
    return {
        "duration_s": float(result.motion.time[-1] - result.motion.time[0]),
        "laps": [{"centre_x_m": lap.x, "centre_y_m": lap.y, "radius_m": lap.radius} for lap in result.laps],
        "drift_m_per_lap": result.drift,
        "max_deviation_m": None if result.problem else result.max_deviation,
        "problem": result.problem or None,
    }
