"""From a route to what the vehicle drives: blended lines, speeds, sprocket rates, within all limits."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, zip_longest

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from trackctl.planning.blending import Line, blended_route
from trackctl.planning.clearance import first_hit
from trackctl.planning.collision import Obstacles
from trackctl.planning.ground import Cost, Ground, ground_of, straight_tangent
from trackctl.planning.pose import advanced
from trackctl.planning.route import Route
from trackctl.planning.slope_field import SlopeField
from trackctl.planning.speed_profile import fastest_speed
from trackctl.planning.steering_limits import SteeringLimits
from trackctl.planning.surface_line import (
    SurfaceLine,
    gradients_along,
    is_plane,
    on_ground,
    on_map,
    rates_along,
    slope_and_uphill,
    surface_line,
)
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.simulation.path import Path
from trackctl.simulation.path_rule import Ground as PathGround
from trackctl.simulation.path_rule import PathCommands, no_slip_ratios, path_commands
from trackctl.simulation.spot_turn import SpotDrive, spot_drive, spot_rate, spot_turn
from trackctl.simulation.vehicle_rates import Scene, scene
from trackctl.workflows.plan_turn import DrivenTurn

Array = NDArray[np.float64]
Pose = tuple[float, float, float]

#: Between samples of a line, over the contact length, and at most. [m]
SPACING, LONGEST_STEP = 1.0 / 48.0, 0.05
#: Between rows, over the contact length, and at most. [m]
ROW_SPACING, LONGEST_ROW = 1.0 / 12.0, 0.1
#: Steps between samples of a line, and between rows of a stretch, at least.
LEAST_STEPS, LEAST_ROWS = 48, 12
#: Between poses that are checked for collisions, in cells, or over the footprint's reach if that is less.
CHECKED = 0.25
#: Largest residual of commands.
LARGEST_RESIDUAL = 1e-8
#: Limits are planned with this share, so that rounding does not exceed them.
SHARE = 0.97
#: Slip that a plan may need, or so many times that of the steady turns, if it is more; and where there is no other. [-]
MOST_SLIP, MORE_SLIP, MUCH_MORE_SLIP = 0.25, 1.1, 1.5
#: Rounds of slowing down where a limit is exceeded, and the excess that an unsolved sample counts as.
SLOWER_ROUNDS, UNSOLVED_EXCESS = 16, 2.0
#: Track speed over that of the hull, at most usually.
SLIPPING = 1.15
#: Rounds in which the tangents at the ends settle to the sideslip there.
END_ROUNDS, SETTLED, TINY = 12, 1e-9, 1e-300
#: Blends over the least that the model page asks for, as far as there is room: the longer, the better they are driven.
LONG_BLENDS = (2.0, 1.5)
#: Curvature so gentle that a vehicle drives its jumps off by no more than this: it needs no blends of that length. [m]
SLIGHT = 3e-3
#: Ramps of a way as gentle as that, over its length.
GENTLE_RAMP = 0.2
#: Places so near an end are called by it [m], and curvatures that are none. [1/m]
NEAR, STRAIGHT = 0.2, 1e-3
#: Slope from which tight turns, of radii below two contact lengths, need blends of as much. [rad]
STEEP = math.radians(15.0)


@dataclass(frozen=True, slots=True, eq=False)
class DriveModel:
    """What turns a route into commands.

    Attributes
    ----------
    vehicle, terrain
        Profiles.
    field
        Slope of the map.
    forward, backward
        Limits of steering in either gear; None: forward only.
    obstacles
        What the footprint must not touch.
    ahead, behind
        The vehicle, and as it is when turned round to drive backwards.
    pace, slips
        Speeds and slips of steady turns as the search's kernels read them.
    sharpest
        Largest curvature. [1/m]
    spot
        How it turns on the spot; None: it cannot.
    more_slip
        Slip over that of the steady turns, at most, where it is more than `MOST_SLIP`.
    """

    vehicle: VehicleProfile
    terrain: TerrainProfile
    field: SlopeField
    obstacles: Obstacles
    ahead: Scene
    behind: Scene
    pace: Ground
    slips: Ground
    sharpest: float
    spot: SpotDrive | None
    more_slip: float = MORE_SLIP


@dataclass(frozen=True, slots=True, eq=False)
class DrivenLine:
    """A line with its commands.

    Attributes
    ----------
    line
        On the map.
    surface
        On the ground.
    place
        Arc lengths on the map of the samples of the commands. [m]
    commands
        In the direction of travel.
    twin
        What the commands drive where the line's curvature jumps, at the same arc lengths; None: the line.
    """

    line: Line
    surface: SurfaceLine
    place: Array
    commands: PathCommands
    twin: DrivenLine | None = None

    def surface_at(self, name: str) -> Array:
        """A quantity of the surface line at the commands' samples."""
        values: Array = getattr(self.surface, name)
        return np.interp(self.commands.path.arc_length, self.surface.arc_length, values)


Driven = DrivenLine | DrivenTurn
#: Drives between two ends, each x, y [m] and tangent [rad], with turns of the tangent where the gear changes; told
#: whether for the first time. The lines, and the turns on the spot before each and after the last. [rad]
DriveBetween = Callable[[Pose, Pose, Sequence[float] | None, bool], tuple[list[DrivenLine], Array]]


class UndrivableError(Exception):
    """A route cannot be driven; says why."""


class SlippingError(UndrivableError):
    """A route asks for too much slip, and for nothing else that cannot be."""


def turned_round(vehicle: VehicleProfile) -> VehicleProfile:
    """The vehicle with its rear in front."""
    footprint = tuple((-x, -y) for x, y in vehicle.footprint)
    return replace(vehicle, cog_forward=-vehicle.cog_forward, cog_left=-vehicle.cog_left, footprint=footprint)


def drive_model(
    vehicle: VehicleProfile,
    terrain: TerrainProfile,
    gravity: float,
    field: SlopeField,
    obstacles: Obstacles,
    limits: tuple[SteeringLimits, SteeringLimits | None],
    most_speed: float,
) -> DriveModel:
    """The model of profiles, gravity [m/s2], slopes, obstacles, limits of both gears and a bound of speed. [m/s]"""
    ahead, behind = (scene(each, terrain, gravity, 0.0, 0.0) for each in (vehicle, turned_round(vehicle)))
    pace, slips = (ground_of(field, *limits, cost) for cost in (Cost.TIME, Cost.SLIP))
    sharpest = float(limits[0].curvature[-1])
    spot = spot_drive(ahead, vehicle, most_speed) if pace.is_level else None
    return DriveModel(vehicle, terrain, field, obstacles, ahead, behind, pace, slips, sharpest, spot)


def blend_length(model: DriveModel, slope: float, sharpest: float) -> float:
    """Over which curvature may change on a slope, in turns up to a curvature; see the model page. [m]"""
    length = model.vehicle.contact_length
    if slope >= STEEP and sharpest * 2.0 * length > 1.0:
        return 2.0 * length
    return max(length, 2.0 * length * math.tan(slope) / model.terrain.friction_coefficient)


def slopes_at(model: DriveModel, x: Array, y: Array) -> Array:
    """Slope angle at points of the map; 0 where it is not known. [rad]"""
    g_x, g_y = gradients_along(model.field, x, y)
    return np.asarray(np.arctan(np.nan_to_num(np.hypot(g_x, g_y))))


def drive_route(model: DriveModel, route: Route, start: Pose, goal: Pose, longer: float) -> list[Driven]:
    """Drive a route from pose to pose, x, y [m] and yaw [rad], both met exactly; its blends so many times the least.

    Raises
    ------
    UndrivableError
        If it cannot be blended, touches something, or asks for more than the vehicle can.
    """
    route, blend, sharpest = blend_of(model, route, longer)

    def driven_between(
        start: Pose, goal: Pose, kinks: Sequence[float] | None, first: bool
    ) -> tuple[list[DrivenLine], Array]:
        blended = blended_route(route, start, goal, blend, sharpest, kinks)
        if blended is None:
            near = math.dist(start[:2], goal[:2])
            between = f" between poses {near:.2g} m apart" if near < blend else ""
            raise UndrivableError(f"its turns leave no room for blends of {blend:.2g} m{between}")
        if first:
            check_roughly(model, blended.lines)
        driven = [drive_line(model, line) for line in blended.lines]
        check_clear(model, driven)
        return driven, blended.turns

    return settled(model, route, (start, goal), driven_between)


def as_straight(route: Route, gentle: float) -> Route | None:
    """The straight that a route driven one way is, but for turns by a curvature so gentle on average [1/m]; or None."""
    length = float(route.length.sum())
    turned = float(np.abs(route.curvature * route.length).sum())
    if route.pivot.any() or np.abs(route.length).sum() > abs(length) * (1.0 + 1e-9) or turned > gentle * abs(length):
        return None
    return Route(route.start, np.zeros(1), np.array([length]), np.zeros(1))


def blend_of(model: DriveModel, route: Route, longer: float) -> tuple[Route, float, float]:
    """A route, its blends, so many times the least [m], and the largest curvature between them. [1/m]

    A short way as good as straight has shorter blends, and stays as good as straight.
    """
    blend = least_blend(model, route)
    gentle = min(24.0 * SLIGHT / blend**2, model.sharpest)
    straight = as_straight(route, gentle)
    if straight is None or (ramp := GENTLE_RAMP * abs(float(straight.length[0]))) >= longer * blend:
        return route, longer * blend, model.sharpest
    return straight, ramp, gentle


def least_blend(model: DriveModel, route: Route) -> float:
    """Over which the curvature of a route may change. [m]"""
    return blend_length(model, steepest_along(model, route), float(np.abs(route.curvature).max()))


def settled(
    model: DriveModel,
    route: Route,
    ends: tuple[Pose, Pose],
    driven_between: DriveBetween,
) -> list[Driven]:
    """Drive a route so that the body's poses at the ends are met with the sideslips that it is driven with."""
    ways = route.length[route.length != 0.0]
    backwards = [bool(ways.size and ways[k] < 0.0) for k in (0, -1)]
    tangents = [
        straight_tangent(model.pace, model.pace.backward if back else model.pace.forward, *pose)
        for pose, back in zip(ends, backwards, strict=True)
    ]
    kinks, steps, before, slopes = None, np.zeros(2), np.zeros(2), -np.eye(2)
    for turn in range(END_ROUNDS):
        first, last = ((*pose[:2], tangent) for pose, tangent in zip(ends, tangents, strict=True))
        driven, turns = driven_between(first, last, kinks, turn == 0)
        if not driven:
            break
        sideslips = [driven[0].commands.sideslip[0], driven[-1].commands.sideslip[-1]]
        found = [tangent_of(model, pose, beta) for pose, beta in zip(ends, sideslips, strict=True)]
        kinks = [float(after.commands.sideslip[0] - before.commands.sideslip[-1]) for before, after in pairwise(driven)]
        moves = np.array([math.remainder(a - b, 2.0 * math.pi) for a, b in zip(found, tangents, strict=True)])
        if np.abs(moves).max() < SETTLED:
            break
        # Broyden's method: in a short way the ends have to do with each other.
        slopes += np.outer(moves - before - slopes @ steps, steps) / max(float(steps @ steps), TINY)
        steps, before = np.linalg.lstsq(slopes, -moves, rcond=None)[0], moves
        tangents = (np.array(tangents) + steps).tolist()
    return with_turns(model, driven, turns, ends[0])


def with_turns(model: DriveModel, driven: Sequence[DrivenLine], turns: Array, start: Pose) -> list[Driven]:
    """Driven lines with the turns on the spot before, between and after them; from x, y [m] and yaw. [rad]"""
    parts: list[Driven] = []
    pose = start
    for angle, line in zip_longest(turns.tolist(), driven):
        if angle != 0.0:
            parts.append(driven_turn(model, pose, angle))
        if line is not None:
            parts.append(line)
            x, y, yaw, _ = map_poses(line)
            pose = float(x[-1]), float(y[-1]), float(yaw[-1])
    return parts


def driven_turn(model: DriveModel, pose: Pose, angle: float) -> DrivenTurn:
    """A turn on the spot from a pose, x, y [m] and yaw [rad], by an angle. [rad]"""
    if model.spot is None:
        raise UndrivableError("it turns on the spot")
    turn = spot_turn(model.ahead, model.spot, angle)
    if turn is None:
        raise UndrivableError(f"its tracks spin in a turn on the spot by {math.degrees(angle):.3g} deg")
    driven = DrivenTurn(pose, model.field.level_uphill, model.vehicle.track_gauge, turn)
    if first_hit(model.obstacles, *finely_turned(model, driven)) is not None:
        raise UndrivableError(f"it touches an obstacle turning on the spot at ({pose[0]:.2f}, {pose[1]:.2f}) m")
    return driven


def finely_turned(model: DriveModel, driven: DrivenTurn) -> tuple[Array, Array, Array]:
    """x, y [m] and yaw [rad] of a turn, in steps as of `checked_step`."""
    x, y, yaw = driven.poses
    step = checked_step(model.obstacles) / model.obstacles.footprint.reach
    fine = np.linspace(yaw[0], yaw[-1], math.ceil(abs(yaw[-1] - yaw[0]) / step) + 2)
    return np.full_like(fine, x[0]), np.full_like(fine, y[0]), fine


def checked_step(obstacles: Obstacles) -> float:
    """Between poses that are checked for collisions: small beside a cell and beside the vehicle. [m]"""
    return CHECKED * min(obstacles.resolution, obstacles.footprint.reach)


def pivot_speed(model: DriveModel) -> float:
    """Rate of turns on the spot as a search takes them; 0: cannot. [rad/s]"""
    return 0.0 if model.spot is None else spot_rate(model.ahead.model, model.spot)


def steepest_along(model: DriveModel, route: Route) -> float:
    """Largest slope under a route, looked for at a few points of each piece. [rad]"""
    pose, points = route.start, [route.start]
    for curvature, length, turn in zip(route.curvature, route.length, route.pivot, strict=True):
        points += [advanced(*pose, curvature, share * length) for share in (0.25, 0.5, 0.75, 1.0)]
        x, y, tangent = points[-1]
        pose = x, y, tangent + turn
    across, up, _ = np.ascontiguousarray(np.array(points).T)
    return float(slopes_at(model, across, up).max())


def tangent_of(model: DriveModel, pose: Pose, sideslip: float) -> float:
    """Tangent on the map of a body's pose with a sideslip. [rad]"""
    x, y, yaw = pose
    if is_plane(model.field):
        return yaw + sideslip
    slope, (uphill,) = slope_and_uphill(model.field, *gradients_along(model.field, np.array([x]), np.array([y])))
    return float(uphill) + float(on_map(on_ground(np.array([yaw - uphill]), slope) + sideslip, slope)[0])


def limits_along(
    model: DriveModel, line: Line, pose: tuple[Array, Array, Array], curvature: Array
) -> tuple[Array, Array, Array]:
    """Speed [m/s], sideslip [rad] and slip of the steady turns along a line; a speed of 0 where there is none."""
    x, y, direction = pose
    tangent, bend = (direction - math.pi, -curvature) if line.backwards else (direction, curvature)
    gears = [(ground.backward if line.backwards else ground.forward) for ground in (model.pace, model.slips)]
    pace, sideslip = rates_along(model.pace, gears[0], x, y, tangent, bend)
    slip, _ = rates_along(model.slips, gears[1], x, y, tangent, bend)
    return 1.0 / pace, sideslip, slip


def samples_of(model: DriveModel, line: Line) -> tuple[Array, tuple[Array, Array, Array], Array]:
    """Arc length, pose and curvature at even steps."""
    step = min(SPACING * model.vehicle.contact_length, LONGEST_STEP)
    arc_length = np.linspace(0.0, line.length, max(math.ceil(line.length / step), LEAST_STEPS) + 1)
    return arc_length, line.at(arc_length), line.curvature_at(arc_length)


def check_roughly(model: DriveModel, lines: Sequence[Line]) -> None:
    """Refuse lines that touch something with the sideslip of steady turns, before anything is solved."""
    for line in lines:
        _, pose, curvature = samples_of(model, line)
        speed, sideslip, _ = limits_along(model, line, pose, curvature)
        if not (speed > 0.0).all():
            place = int(np.argmin(speed > 0.0))
            raise UndrivableError(infeasible_place(model, lines, line, place))
        yaw = pose[2] - sideslip + (math.pi if line.backwards else 0.0)
        check_poses(model, pose[0], pose[1], yaw)


def infeasible_place(model: DriveModel, lines: Sequence[Line], line: Line, sample: int) -> str:
    """Where on lines no steady turn is feasible, and what it would have been."""
    arc_length, (x, y, direction), curvature = samples_of(model, line)
    done = sum(each.length for each in lines[: lines.index(line)]) + arc_length[sample]
    left = sum(each.length for each in lines) - done
    if min(done, left) < NEAR:
        where = "at the start" if done < left else "at the goal"
    else:
        where = f"{done:.2f} m from the start and {left:.2f} m before the goal"
    g_x, g_y = gradients_along(model.field, x[[sample]], y[[sample]])
    slope, uphill = math.degrees(math.atan(math.hypot(g_x[0], g_y[0]))), math.atan2(g_y[0], g_x[0])
    heading = math.degrees(direction[sample] - uphill) % 360.0
    turn = f"a turn of {curvature[sample]:.3g} 1/m" if abs(curvature[sample]) > STRAIGHT else "straight driving"
    return (
        f"{where}, ({x[sample]:.2f}, {y[sample]:.2f}) m, it has no speed for {turn} on a slope of {slope:.3g} deg, "
        f"{heading:.0f} deg from up-slope: there is no equilibrium within the profile's limits"
    )


def check_poses(model: DriveModel, x: Array, y: Array, yaw: Array) -> None:
    """Refuse poses, and what lies between them, that touch something."""
    way = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))))
    fine = np.linspace(0.0, way[-1], math.ceil(way[-1] / checked_step(model.obstacles)) + 2)
    hit = first_hit(model.obstacles, *(np.interp(fine, way, values) for values in (x, y, np.unwrap(yaw))))
    if hit is not None:
        at = [float(np.interp(fine[hit], way, values)) for values in (x, y)]
        raise UndrivableError(f"it touches an obstacle at ({at[0]:.2f}, {at[1]:.2f}) m")


def drive_line(model: DriveModel, line: Line) -> DrivenLine:
    """Commands along a line from rest to rest, as fast as all limits allow.

    The speed is that of the steady turns first; where the commands then exceed a limit, or have no equilibrium, it is
    lowered, and with it the acceleration.
    """
    place, pose, curvature = samples_of(model, line)
    surface = surface_line(model.field, place, pose, curvature)
    most, _, steady_slip = limits_along(model, line, pose, curvature)
    if not (most > 0.0).all():
        raise UndrivableError("no feasible speed on it")
    # The outer track gains speed by the turn, and a little by slip.
    outer = SLIPPING + 0.5 * model.vehicle.track_gauge * np.abs(surface.curvature)
    by_drive = model.vehicle.max_sprocket_acceleration * model.vehicle.sprocket_radius / outer
    acceleration = SHARE * np.minimum(model.vehicle.max_acceleration, by_drive)
    allowed_slip = np.maximum(MOST_SLIP, model.more_slip * steady_slip)
    width = math.ceil(model.vehicle.contact_length / (place[1] - place[0]))
    for _ in range(SLOWER_ROUNDS):
        speed = fastest_speed(surface.arc_length, most, acceleration, 0.0, 0.0)
        path = Path(surface.arc_length, pose[0], pose[1], surface.direction, surface.curvature, speed)
        ground = PathGround(surface.arc_length, surface.slope, surface.uphill)
        commands = path_commands(model.behind if line.backwards else model.ahead, path, ground)
        slips = np.interp(commands.path.arc_length, surface.arc_length, allowed_slip)
        excess = excess_of(model, commands, slips)
        if excess.max() <= 1.0:
            return DrivenLine(line, surface, np.interp(commands.path.arc_length, surface.arc_length, place), commands)
        factor = np.interp(surface.arc_length, commands.path.arc_length, np.maximum(excess / SHARE, 1.0))
        factor = maximum_filter1d(factor, width, mode="nearest")
        most, acceleration = np.minimum(most, speed.max()) / np.sqrt(factor), acceleration / factor
    worst = int(np.argmax(excess))
    where = f"{commands.path.arc_length[worst]:.2f} m along it, however slowly"
    if excess_of(model, commands, np.full_like(slips, np.inf)).max() <= 1.0:
        raise SlippingError(f"its tracks slip too much {where}")
    raise UndrivableError(f"a limit of the vehicle or of the ground is exceeded {where}")


def excess_of(model: DriveModel, commands: PathCommands, allowed_slip: Array) -> Array:
    """Sprocket rates, their changes, track forces and slips over what is allowed, the largest of each sample."""
    vehicle = model.vehicle
    rates = np.stack((commands.track_speed_left, commands.track_speed_right)) / vehicle.sprocket_radius
    change = np.abs(np.diff(rates, axis=1)) / np.diff(commands.time)
    change = np.maximum(np.pad(change, ((0, 0), (1, 0))), np.pad(change, ((0, 0), (0, 1))))
    slip = np.maximum(np.abs(commands.slip_left), np.abs(commands.slip_right))
    force = np.maximum(np.abs(commands.traction_left), np.abs(commands.traction_right))
    force *= vehicle.mass * model.ahead.model.gravity
    found = np.stack(
        (
            np.abs(rates).max(axis=0) / (SHARE * vehicle.max_sprocket_rate),
            change.max(axis=0) / (SHARE * vehicle.max_sprocket_acceleration),
            force / (SHARE * (vehicle.max_track_force or math.inf)),
            slip / allowed_slip,
            np.where(commands.residual <= LARGEST_RESIDUAL, 0.0, UNSOLVED_EXCESS),
        )
    )
    excess: Array = found.max(axis=0)
    return np.minimum(np.where(np.isfinite(excess), excess, UNSOLVED_EXCESS), 4.0)


def check_clear(model: DriveModel, driven: Sequence[DrivenLine]) -> None:
    """Refuse what touches something, with the sideslips that are commanded."""
    for each in driven:
        x, y, yaw, _ = map_poses(each)
        check_poses(model, x, y, yaw)


def map_poses(driven: DrivenLine) -> tuple[Array, Array, Array, Array]:
    """Position [m] and yaw of the body on the map at the commands' samples, and its heading from up-slope. [rad]

    The heading is in the plane of the ground; the yaw is without jumps.
    """
    x, y, direction = driven.line.at(driven.place)
    slope, uphill = driven.surface_at("slope"), driven.surface_at("map_uphill")
    back = math.pi if driven.line.backwards else 0.0
    if driven.surface.uphill is driven.surface.map_uphill:
        heading = direction - driven.commands.sideslip - uphill
        return x, y, np.unwrap(heading + uphill) + back, heading + back
    heading = on_ground(direction - uphill, slope) - driven.commands.sideslip
    return x, y, np.unwrap(uphill + on_map(heading, slope)) + back, heading + back


def no_slip_twin(model: DriveModel, driven: Driven) -> Driven:
    """The same with commands that would drive it without slip."""
    if isinstance(driven, DrivenTurn):
        return driven.without_slip
    path = driven.commands.path
    left, right, _ = no_slip_ratios((model.behind if driven.line.backwards else model.ahead).model, path.curvature)
    speeds = {"track_speed_left": left * path.speed, "track_speed_right": right * path.speed}
    return replace(driven, commands=replace(driven.commands, **speeds))
