"""The fastest speed along a path that friction, drive and vehicle allow."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csr_array, diags_array, vstack

from trackctl.errors import NoAnswerError
from trackctl.forces.gauss_newton import ITERATIONS
from trackctl.forces.model import ForceModel, ReferencePoints, gravity_in_body, smooth_magnitude, steady_sideslip
from trackctl.forces.nominal import friction_moment, limits, nominal_forces
from trackctl.forces.reference import Reference
from trackctl.forces.sideslip_spline import solve_spline
from trackctl.forces.speed_profile import SpeedProfile, constant, from_spline
from trackctl.forces.yaw import YawMotion
from trackctl.geometry.bspline import Spline, SplineSpace, clamped_knots
from trackctl.geometry.gauss import gauss_points
from trackctl.geometry.path import Path

Array = NDArray[np.float64]

#: Degree of the squared speed: the acceleration has a continuous derivative.
DEGREE = 3
#: Points an interval at which the limits are asked for.
POINTS = 4
#: Intervals of the sideslip to one of the squared speed.
REFINEMENT = 3
#: And at which they are checked in the end.
CHECKS = 8
#: Intervals are this share of the ground contact, if that gives no more than so many.
CONTACT_SHARE = 0.25
MOST_INTERVALS = 4000
#: The acceleration takes this share of the ground contact to go from nothing to its limit.
RISE = 0.5
#: Share of mu_t N used, so that the tracks keep sliding both ways.
LATERAL_MARGIN = 0.999
#: Share of c that braking in a turn may take up.
BRAKING = 0.8
#: Largest residual of a speed that is taken, solved on so many intervals.
BALANCED = 0.01
#: Shares of the track forces' limits used, the first that the forces of the speed found then keep.
MARGINS = (0.98, 0.96, 0.93, 0.9, 0.85, 0.8)
#: Rounds to that end, and the change of the squared speed below which they end.
ROUNDS = 16
SETTLED = 1e-3
#: Lowest speed on the way, where the ends are at rest. [m/s]
SLOWEST = 0.01

NO_SPEED = "found no speed along this path that keeps within the limits of friction and drive"


@dataclass(frozen=True, slots=True)
class SpeedLimits:
    """What else bounds the speed.

    Attributes
    ----------
    ends
        Speed at start and end. [m/s]
    top
        Largest speed. [m/s]
    acceleration
        Largest acceleration, either way. [m/s2]
    """

    ends: float
    top: float
    acceleration: float


def optimal_speed(model: ForceModel, path: Path, bounds: SpeedLimits) -> SpeedProfile:
    """The fastest squared speed among cubic splines, by a sequence of linear programs.

    With the yaw of the last round all limits are linear in z and z': the lateral force below mu_t N, which is
    |D| < L/2, and the force of each track. Maximising z at one place never asks for less of it at another, so
    that the largest integral of z is also the shortest time.

    Parameters
    ----------
    model
        The vehicle.
    path
        Without jumps of curvature.
    bounds
        Of speed and acceleration.

    Raises
    ------
    NoAnswerError
        If no speed is feasible.
    """
    for margin in MARGINS:
        speed = settled_speed(model, path, bounds, margin)
        if speed is not None and is_drivable(model, Reference(path, speed)):
            return speed
    raise NoAnswerError(NO_SPEED)


def is_drivable(model: ForceModel, reference: Reference) -> bool:
    """Whether the yaw is found as finely as it needs to be, and the forces keep the limits all along."""
    solution = solve_spline(model, reference)
    edges = speed_edges(model, reference.path)
    stations = np.union1d(edges, gauss_points(edges, CHECKS)[0])
    forces = nominal_forces(model, reference, solution.yaw, stations)
    return solution.iterations < ITERATIONS and bool(limits(model, reference, forces).feasible.all())


def settled_speed(model: ForceModel, path: Path, bounds: SpeedLimits, margin: float) -> SpeedProfile | None:
    """The fastest speed met that is feasible, each the best for a mean of the yaws of those before."""
    edges = speed_edges(model, path)
    places = gauss_points(edges, POINTS)[0].ravel()
    stations = np.concatenate((edges[:1], places, edges[-1:]))
    points = Reference(path, constant(path.length, max(bounds.ends, SLOWEST))).at(places)
    motion = YawMotion(steady_sideslip(model, points, points.curvature), points.curvature, points.curvature_gradient)
    best, least_time, squared = None, np.inf, np.zeros(places.size)
    for k in range(ROUNDS):
        speed = fastest(model, edges, points, motion, bounds, margin)
        if speed is None:
            break
        reference = Reference(path, speed)
        points = reference.at(places)
        yaw = solve_spline(model, reference, REFINEMENT * (edges.size - 1)).yaw
        motion = mean_motion(motion, yaw.at(places, points), 2.0 / (k + 2.0))
        forces = nominal_forces(model, reference, yaw, stations)
        drivable = limits(model, reference, forces).feasible.all() and np.abs(forces.residual).max() < BALANCED
        if drivable and forces.time[-1] < least_time:
            best, least_time = speed, forces.time[-1]
        if best is not None and np.abs(points.squared_speed - squared).max() <= SETTLED * points.squared_speed.max():
            break
        squared = points.squared_speed
    return best


def mean_motion(old: YawMotion, new: YawMotion, share: float) -> YawMotion:
    """The old yaw, a share of the way to the new one."""
    pairs = ((getattr(old, field.name), getattr(new, field.name)) for field in fields(YawMotion))
    return YawMotion(*(before + share * (after - before) for before, after in pairs))


def speed_edges(model: ForceModel, path: Path) -> Array:
    """Even intervals of the squared speed. [m]"""
    count = int(np.ceil(path.length / (CONTACT_SHARE * model.length)))
    return np.linspace(0.0, path.length, min(max(count, 20), MOST_INTERVALS) + 1)


def fastest(
    model: ForceModel, edges: Array, points: ReferencePoints, motion: YawMotion, bounds: SpeedLimits, margin: float
) -> SpeedProfile | None:
    """The squared speed of largest integral within the limits, for a yaw given at the Gauss points; None if none is."""
    places, weights = (part.ravel() for part in gauss_points(edges, POINTS))
    space = SplineSpace(clamped_knots(edges, DEGREE), DEGREE)
    squared, slope, bend = (basis_matrix(space, at, order) for at, order in ((places, 0), (places, 1), (edges, 2)))
    rises = np.full(edges.size, bounds.acceleration / (RISE * model.length))
    bounded = [
        (0.5 * slope, np.zeros(places.size), np.full(places.size, bounds.acceleration)),
        (0.5 * bend, np.zeros(edges.size), rises),
    ]
    for limit in force_limits(model, points, motion, margin):
        rows = diags_array(limit.by_squared_speed) @ squared + diags_array(0.5 * limit.by_acceleration) @ slope
        bounded.append((rows, limit.rest, limit.bound))
    matrix = vstack([rows for rows, _, _ in bounded])
    rest, bound = (np.concatenate(parts) for parts in list(zip(*bounded, strict=True))[1:])
    low, high = np.full(space.size, min(bounds.ends, SLOWEST) ** 2), np.full(space.size, float(bounds.top) ** 2)
    low[[0, -1]] = high[[0, -1]] = bounds.ends**2
    within = LinearConstraint(matrix, -bound - rest, bound - rest)
    found = milp(-(weights @ squared), constraints=within, bounds=Bounds(low, high))
    return from_spline(Spline(space, found.x)) if found.success else None


def basis_matrix(space: SplineSpace, places: Array, derivative: int) -> csr_array:
    """From coefficients to values at places, shape (n, space.size)."""
    span = space.span(places)
    columns = (span - space.degree)[:, None] + np.arange(space.degree + 1)
    starts = np.arange(places.size + 1) * (space.degree + 1)
    values = space.basis(places, span, derivative).T.ravel()
    # Before scipy 1.15 `milp` takes no indices of 64 bits.
    indices = columns.ravel().astype(np.int32), starts.astype(np.int32)
    return csr_array((values, *indices), shape=(places.size, space.size))


@dataclass(frozen=True, slots=True, eq=False)
class ForceLimit:
    """abs(by_squared_speed z + by_acceleration a + rest) <= bound, arrays of shape (n,)."""

    by_squared_speed: Array
    by_acceleration: Array
    rest: Array
    bound: Array


def force_limits(model: ForceModel, points: ReferencePoints, motion: YawMotion, margin: float) -> list[ForceLimit]:
    """Limits of the lateral force over mass, of braking, and of the force on each track, for a given yaw.

    Braking may not undo the friction that turns the sideslip back: c + a |theta_s| > 0.
    """
    sine, cosine = np.sin(motion.sideslip), np.cos(motion.sideslip)
    gravity = gravity_in_body(model, points.tangent - motion.sideslip)
    magnitude = smooth_magnitude(motion.gradient, points)
    offset = -sine * motion.gradient / magnitude**2
    moment = friction_moment(model, gravity.load_offset, offset, motion.gradient / magnitude)
    sliding = np.full(sine.size, LATERAL_MARGIN * model.lateral_friction * model.load / model.mass)
    bend, most = np.abs(motion.gradient), np.full(sine.size, 1e3 * model.grip)
    found = [
        ForceLimit(points.curvature * cosine, sine, -gravity.left, sliding),
        ForceLimit(np.zeros(sine.size), bend, BRAKING * model.grip - most, most),  # only from below
    ]
    shifted = model.mass * gravity.left * model.cog_height / model.gauge
    for side in (-1.0, 1.0):
        arm = 2.0 * side / model.gauge
        grip = model.longitudinal_friction * (0.5 * model.load - side * shifted)
        found.append(
            ForceLimit(
                0.5 * (arm * model.yaw_inertia * motion.gradient_change - model.mass * points.curvature * sine),
                0.5 * (arm * model.yaw_inertia * motion.gradient + model.mass * cosine),
                -0.5 * (arm * moment + model.mass * gravity.forward),
                margin * np.minimum(grip, model.max_track_force),
            )
        )
    return found
