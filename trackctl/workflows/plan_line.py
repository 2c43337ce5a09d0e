"""Commands along a line from rest to rest, within all limits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from trackctl.planning.blending import Line
from trackctl.planning.clearance import first_hit
from trackctl.planning.speed_profile import fastest_speed
from trackctl.planning.surface_line import (
    SurfaceLine,
    gradients_along,
    on_ground,
    on_map,
    rates_along,
    slope_and_uphill,
    surface_line,
)
from trackctl.simulation.path import Path
from trackctl.simulation.path_rule import Ground as PathGround
from trackctl.simulation.path_rule import PathCommands, path_commands
from trackctl.workflows.plan_model import MOST_SLIP, DriveModel, SlippingError, UndrivableError, checked_step

Array = NDArray[np.float64]

#: Between samples of a line, over the contact length, and at most. [m]
SPACING, LONGEST_STEP = 1.0 / 48.0, 0.05
#: Steps between samples of a line at least.
LEAST_STEPS = 48
#: Largest residual of commands.
LARGEST_RESIDUAL = 1e-8
#: Limits are planned with this share, so that rounding does not exceed them.
SHARE = 0.97
#: Rounds of slowing down where a limit is exceeded, and the excess that an unsolved sample counts as.
SLOWER_ROUNDS, UNSOLVED_EXCESS = 16, 2.0
#: Track speed over that of the hull, at most usually.
SLIPPING = 1.15
#: Places so near an end are called by it [m], and curvatures that are none. [1/m]
NEAR, STRAIGHT = 0.2, 1e-3


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


def samples_of(model: DriveModel, line: Line) -> tuple[Array, tuple[Array, Array, Array], Array]:
    """Arc length, pose and curvature at even steps."""
    step = min(SPACING * model.vehicle.contact_length, LONGEST_STEP)
    arc_length = np.linspace(0.0, line.length, max(math.ceil(line.length / step), LEAST_STEPS) + 1)
    return arc_length, line.at(arc_length), line.curvature_at(arc_length)


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
    gradients = gradients_along(model.field, x[[sample]], y[[sample]])
    slope, uphill = (math.degrees(float(angle[0])) for angle in slope_and_uphill(model.field, *gradients))
    heading = (math.degrees(direction[sample]) - uphill) % 360.0
    turn = f"a turn of {curvature[sample]:.3g} 1/m" if abs(curvature[sample]) > STRAIGHT else "straight driving"
    return (
        f"{where}, ({x[sample]:.2f}, {y[sample]:.2f}) m, it has no speed for {turn} on a slope of {slope:.3g} deg, "
        f"{heading:.0f} deg from up-slope: there is no equilibrium within the profile's limits"
    )


def check_clear(model: DriveModel, driven: Sequence[DrivenLine]) -> None:
    """Refuse what touches something, with the sideslips that are commanded."""
    for each in driven:
        x, y, yaw, _ = map_poses(each)
        check_poses(model, x, y, yaw)


def check_poses(model: DriveModel, x: Array, y: Array, yaw: Array) -> None:
    """Refuse poses, and what lies between them, that touch something."""
    way = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))))
    fine = np.linspace(0.0, way[-1], math.ceil(way[-1] / checked_step(model.obstacles)) + 2)
    hit = first_hit(model.obstacles, *(np.interp(fine, way, values) for values in (x, y, np.unwrap(yaw))))
    if hit is not None:
        at = [float(np.interp(fine[hit], way, values)) for values in (x, y)]
        raise UndrivableError(f"it touches an obstacle at ({at[0]:.2f}, {at[1]:.2f}) m")
