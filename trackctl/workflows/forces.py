"""`forces`: nominal track forces along a path at desired speeds."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from trackctl.errors import NoAnswerError, UsageError
from trackctl.forces import speed_profile
from trackctl.forces.gauss_newton import ITERATIONS
from trackctl.forces.model import ForceModel
from trackctl.forces.nominal import Limits, NominalForces, limits, nominal_forces, required_friction
from trackctl.forces.reference import Reference
from trackctl.forces.sideslip_spline import solve_spline
from trackctl.forces.speed_profile import SpeedProfile
from trackctl.forces.yaw import YawSolution
from trackctl.forces.yaw_polynomial import solve_polynomial
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.workflows.forces_options import Basis, SpeedKind
from trackctl.workflows.forces_path import ForcesPath

if TYPE_CHECKING:
    from trackctl.workflows.forces_verification import Trial

Array = NDArray[np.float64]

#: Friction of both kinds where no terrain is named.
DEFAULT_FRICTION = 0.8
#: Stations are this share of the ground contact apart, or closer or less close to be within these numbers.
STATION_SHARE = 0.025
FEWEST_STATIONS, MOST_STATIONS = 200, 100_000
MOST_ASKED_FOR = 1_000_000


@dataclass(frozen=True, slots=True)
class SpeedRequest:
    """How fast to go.

    Attributes
    ----------
    kind
        None for the speed of the waypoints, or a triangle where they have none.
    ends, peak
        At the start and the end, and the largest; a constant speed is the largest all along. [m/s]
    """

    kind: SpeedKind | None
    ends: float
    peak: float


@dataclass(frozen=True, slots=True)
class ForcesRequest:
    """What forces to find.

    Attributes
    ----------
    vehicle, terrain
        None for friction of `DEFAULT_FRICTION` both ways.
    gravity
        [m/s2]
    slope, uphill_yaw
        Of the ground. [rad]
    path
        To follow with the mass centre.
    speed
        On it.
    basis, order
        Of the yaw; the order is that of the polynomial.
    step
        Between stations, None to choose. [m]
    verify
        Whether to simulate the forces found.
    """

    vehicle: VehicleProfile
    terrain: TerrainProfile | None
    gravity: float
    slope: float
    uphill_yaw: float
    path: ForcesPath
    speed: SpeedRequest
    basis: Basis = Basis.SPLINE
    order: int = 3
    step: float | None = None
    verify: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class ForcesResult:
    """Nominal forces and how good they are.

    Attributes
    ----------
    forces, limits
        At stations along the path, shape (n,).
    trial
        The forces simulated, None where it was not asked for.
    notes
        What a user should know.
    """

    forces: NominalForces
    limits: Limits
    trial: Trial | None
    notes: tuple[str, ...]

    @property
    def required_friction(self) -> float:
        """Longitudinal friction coefficient that the forces need."""
        return float(required_friction(self.forces).max())


def find_forces(request: ForcesRequest) -> ForcesResult:
    """Nominal forces of a request.

    Raises
    ------
    NoAnswerError
        If the constraint is not solved, no speed is feasible, or the simulation fails.
    UsageError
        If the speeds or the step do not suit.
    """
    model = force_model(request)
    reference = Reference(request.path.path, speed_along(model, request))
    solution = solve(model, reference, request)
    forces = nominal_forces(model, reference, solution.yaw, stations(model, reference, request.step))
    trial = None
    if request.verify:
        from trackctl.workflows.forces_verification import try_out  # scipy.integrate takes its time

        trial = try_out(model, reference, solution)
    notes = (*request.path.notes, *notes_on(request, reference))
    return ForcesResult(forces, limits(model, reference, forces), trial, notes)


def force_model(request: ForcesRequest) -> ForceModel:
    """The vehicle on its ground."""
    vehicle, terrain = request.vehicle, request.terrain
    longitudinal = terrain.friction_coefficient if terrain else DEFAULT_FRICTION
    return ForceModel(
        mass=vehicle.mass,
        yaw_inertia=vehicle.yaw_inertia,
        gauge=vehicle.track_gauge,
        length=vehicle.contact_length,
        cog_height=vehicle.cog_height,
        lateral_friction=(terrain and terrain.lateral_friction_coefficient) or longitudinal,
        longitudinal_friction=longitudinal,
        gravity=request.gravity,
        slope=request.slope,
        uphill_yaw=request.uphill_yaw,
        max_track_force=vehicle.max_track_force or math.inf,
    )


def speed_along(model: ForceModel, request: ForcesRequest) -> SpeedProfile:
    """The speed that a request asks for."""
    kind, path, squared = request.speed.kind, request.path.path, request.path.squared_speed
    ends, peak = request.speed.ends, request.speed.peak
    if kind is None and squared is not None:
        return speed_profile.from_spline(squared)
    if kind is SpeedKind.CONSTANT:
        return speed_profile.constant(path.length, peak)
    if ends > peak:
        raise UsageError("--speed-start-mps", ends, f"up to the peak, {peak:g} m/s")
    if kind is SpeedKind.OPTIMAL:
        from trackctl.forces.optimal_speed import SpeedLimits, optimal_speed  # scipy.optimize takes its time

        return optimal_speed(model, path, SpeedLimits(ends, peak, request.vehicle.max_acceleration))
    if kind is SpeedKind.SMOOTH:
        if ends == 0.0:
            raise UsageError("--speed-start-mps", ends, "above 0; --speed-profile smooth never starts from rest")
        return speed_profile.smooth(path.length, ends, peak)
    shape = speed_profile.trapezoidal if kind is SpeedKind.TRAPEZOIDAL else speed_profile.triangular
    return shape(path.length, ends, peak)


def solve(model: ForceModel, reference: Reference, request: ForcesRequest) -> YawSolution:
    """The yaw along the path, or a `NoAnswerError`."""
    try:
        if request.basis is Basis.POLYNOMIAL:
            solution = solve_polynomial(model, reference, request.order)
        else:
            solution = solve_spline(model, reference)
    except np.linalg.LinAlgError:
        raise NoAnswerError("the constraint determines no yaw along this path at these speeds") from None
    if solution.iterations >= ITERATIONS:
        raise NoAnswerError(f"the yaw along the path has not converged after {ITERATIONS} iterations")
    return solution


def stations(model: ForceModel, reference: Reference, step: float | None) -> Array:
    """Arc lengths to answer at: evenly apart, and where the reference jumps. [m]"""
    length = reference.path.length
    count = int(min(max(length / (STATION_SHARE * model.length), FEWEST_STATIONS), MOST_STATIONS))
    if step is not None:
        if not length / step <= MOST_ASKED_FOR:
            raise UsageError("--step-m", step, f"{length / MOST_ASKED_FOR:g} or more, for up to a million stations")
        count = max(1, math.ceil(length / step))
    even = np.linspace(0.0, length, count + 1)
    found = np.unique(np.concatenate((even, reference.path.kinks, reference.path.jumps, reference.speed.jumps)))
    return np.asarray(found[np.append(np.diff(found) > 1e-9 * length, True)])


def notes_on(request: ForcesRequest, reference: Reference) -> list[str]:
    """What a user should know about the vehicle and the speed."""
    vehicle, found = request.vehicle, []
    if vehicle.cog_forward or vehicle.cog_left:
        found.append("the mass centre is taken to be over the middle of the ground contact")
    if reference.speed.jumps.size:
        found.append(
            f"the acceleration jumps at {reference.speed.jumps.size} places, which no finite force difference drives "
            "exactly; --speed-profile smooth does not"
        )
    return found


def limit_counts(limits: Limits) -> dict[str, int]:
    """How many stations break each limit."""
    return {field.name: int(getattr(limits, field.name).sum()) for field in fields(limits)}
