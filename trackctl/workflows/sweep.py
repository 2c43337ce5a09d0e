"""`sweep`: what the tracks do over the headings of a turn, at several slopes and speeds: the paper's section IV."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.errors import NoAnswerError, UsageError
from trackctl.lut.axes import FULL_CIRCLE, Array, Axes
from trackctl.lut.cells import Cells
from trackctl.lut.crew import solve_columns, threads
from trackctl.lut.grid import STEEPEST_SLOPE
from trackctl.lut.sweep import Seeding, Sweep
from trackctl.lut.table import Status
from trackctl.mechanics.parameters import track_model
from trackctl.mechanics.slip import body_speed, no_slip_radius, slip
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile

Progress = Callable[[int, int], None]

#: More would take gigabytes of memory.
MOST_ROWS = 10**7
#: Tells headings that go evenly round the full circle from others. [rad]
EVENNESS = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class SweepRequest:
    """Which turns to solve; the axes are ascending.

    Attributes
    ----------
    vehicle, terrain
        Profiles.
    gravity
        [m/s2]
    slope
        [rad]
    velocity
        Of the mass centre. [m/s]
    radius
        Of the turn, negative to the right. [m]
    heading
        From up-slope, counter-clockwise, in [0, 2 pi). [rad]
    seed
        Of the swarms.
    jobs
        Threads.
    """

    vehicle: VehicleProfile
    terrain: TerrainProfile
    gravity: float
    slope: Array
    velocity: Array
    radius: float
    heading: Array
    seed: int = 0
    jobs: int = 1

    @property
    def rows(self) -> int:
        """Number of operating points."""
        return self.slope.size * self.velocity.size * self.heading.size

    @property
    def axes(self) -> Axes:
        """The same as the grid of a table with one curvature."""
        curvature = np.array([1.0 / self.radius])
        return Axes(self.slope, self.velocity, curvature, self.heading, is_periodic(self.heading))


@dataclass(frozen=True, slots=True, eq=False)
class SweepResult:
    """The turns of a request, arrays of shape (n_slope, n_velocity, n_heading), NaN without an answer.

    Attributes
    ----------
    request
        Which turns.
    track_speed_inner, track_speed_outer
        Of the tracks over the hull: the paper's output velocity. [m/s]
    body_speed_inner, body_speed_outer
        Of the hull over the ground at the tracks: the paper's driving velocity. [m/s]
    sideslip
        From the body's x axis to the velocity of the mass centre, counter-clockwise. [rad]
    theoretical_radius
        Turn radius that the track speeds would give without slip, negative to the right. [m]
    status
        Code of `Status`.
    """

    request: SweepRequest
    track_speed_inner: Array
    track_speed_outer: Array
    body_speed_inner: Array
    body_speed_outer: Array
    sideslip: Array
    theoretical_radius: Array
    status: NDArray[np.uint8]

    @property
    def slip_inner(self) -> Array:
        """Positive driving, negative braking."""
        return slip(self.track_speed_inner, self.body_speed_inner)

    @property
    def slip_outer(self) -> Array:
        """Positive driving, negative braking."""
        return slip(self.track_speed_outer, self.body_speed_outer)


def sweep(request: SweepRequest, progress: Progress = lambda done, total: None) -> SweepResult:
    """Solve the turns of a request.

    Parameters
    ----------
    request
        Which turns.
    progress
        Told the number of slopes solved, and of all.

    Raises
    ------
    UsageError
        If the request holds what no vehicle can do or no computer hold.
    NoAnswerError
        If no turn has an answer.
    """
    check(request)
    result = turns(request, solved_cells(request, progress))
    if not np.any(result.status == Status.CONVERGED):
        raise NoAnswerError(f"none of the {request.rows} operating points has an answer: {reasons(result)}")
    return result


def check(request: SweepRequest) -> None:
    """Refuse values out of range, naming the option at fault."""
    half_gauge = 0.5 * request.vehicle.track_gauge
    for angle in request.slope[~((request.slope >= 0.0) & (request.slope < STEEPEST_SLOPE))]:
        raise UsageError("--slope-deg", f"{math.degrees(angle):g}", "0 or more, below 45")
    for velocity in request.velocity[~(request.velocity > 0.0)]:
        raise UsageError("--velocity-mps", f"{velocity:g}", "above 0")
    if not half_gauge < abs(request.radius) < math.inf:
        allowed = f"finite, above {half_gauge:g} (half the gauge), or below -{half_gauge:g} for right turns"
        raise UsageError("--radius-m", f"{request.radius:g}", allowed)
    for heading in request.heading[~((request.heading >= 0.0) & (request.heading < FULL_CIRCLE))]:
        raise UsageError("--heading-deg", f"{math.degrees(heading):g}", "0 or more, below 360")
    if request.rows > MOST_ROWS:
        raise UsageError("--heading-deg", f"a sweep of {request.rows:.3g} rows", f"at most {MOST_ROWS:.3g} rows")


def is_periodic(heading: Array) -> bool:
    """Whether headings go evenly round the full circle."""
    even = heading[0] + np.arange(heading.size) * FULL_CIRCLE / heading.size
    return heading.size > 1 and bool(np.allclose(heading, even, rtol=0.0, atol=EVENNESS))


def solved_cells(request: SweepRequest, progress: Progress) -> Cells:
    """Cells of the turns, shape (n_slope, n_velocity, n_heading); each slope is one column of a table."""
    columns = Sweep(
        track_model(request.vehicle, request.terrain, request.gravity),
        request.axes,
        Seeding.CONTINUATION,
        request.seed,
    )
    count = columns.column_count
    found: dict[int, Cells] = {}
    with threads(request.jobs) as crew:
        for column, cells in solve_columns(columns, range(count), crew):
            found[column] = cells
            progress(len(found), count)
    return np.stack([found[column] for column in range(count)])


def turns(request: SweepRequest, cells: Cells) -> SweepResult:
    """Speeds of the inner and outer track from the solved cells."""
    vehicle, status = request.vehicle, cells["status"]
    unknowns = np.where((status == Status.CONVERGED)[..., None], cells["unknowns"], np.nan)
    velocity, curvature = request.velocity[:, None], 1.0 / request.radius
    left, right, sideslip = velocity * unknowns[..., 0], velocity * unknowns[..., 1], unknowns[..., 2]
    body_left, body_right = (
        body_speed(velocity, curvature, sideslip, side * vehicle.track_gauge - vehicle.cog_left) for side in (0.5, -0.5)
    )
    inner, outer = ((left, body_left), (right, body_right))[:: 1 if curvature > 0.0 else -1]
    return SweepResult(
        request,
        track_speed_inner=inner[0],
        track_speed_outer=outer[0],
        body_speed_inner=inner[1],
        body_speed_outer=outer[1],
        sideslip=sideslip,
        theoretical_radius=no_slip_radius(vehicle.track_gauge, left, right),
        status=status,
    )


def tidy_columns(result: SweepResult) -> dict[str, Array | list[str]]:
    """One row per slope, speed and heading, as columns of a CSV table."""
    request = result.request
    slope, velocity, heading = np.meshgrid(request.slope, request.velocity, request.heading, indexing="ij")
    columns = {
        "slope_rad": slope,
        "velocity_mps": velocity,
        "radius_m": np.full(slope.shape, request.radius),
        "heading_rad": heading,
        "track_speed_inner_mps": result.track_speed_inner,
        "track_speed_outer_mps": result.track_speed_outer,
        "body_speed_inner_mps": result.body_speed_inner,
        "body_speed_outer_mps": result.body_speed_outer,
        "slip_inner": result.slip_inner,
        "slip_outer": result.slip_outer,
        "sideslip_rad": result.sideslip,
        "theoretical_radius_m": result.theoretical_radius,
    }
    words = {each.value: each.name.lower() for each in Status}
    statuses = [words[code] for code in result.status.ravel().tolist()]
    return {name: column.ravel() for name, column in columns.items()} | {"status": statuses}


def summary_columns(result: SweepResult) -> dict[str, Array | NDArray[np.int64]]:
    """One row per slope and speed, as columns of a CSV table; NaN where no heading has an answer.

    The largest theoretical radius is that of the straightest no-slip turn, the smallest that of the tightest: ordered
    by curvature, which goes through zero, not infinity, where the tracks run equally fast.
    """
    request = result.request
    slope, velocity = np.meshgrid(request.slope, request.velocity, indexing="ij")
    straightest, max_radius_heading = extreme(result, np.argmin, np.inf)
    tightest, min_radius_heading = extreme(result, np.argmax, -np.inf)
    columns = {
        "slope_rad": slope,
        "velocity_mps": velocity,
        "radius_m": np.full(slope.shape, request.radius),
        "rmse_inner_mps": rmse(result.track_speed_inner, result.body_speed_inner),
        "rmse_outer_mps": rmse(result.track_speed_outer, result.body_speed_outer),
        "max_radius_m": straightest,
        "max_radius_heading_rad": max_radius_heading,
        "min_radius_m": tightest,
        "min_radius_heading_rad": min_radius_heading,
        "infeasible_count": np.sum(result.status != Status.CONVERGED, axis=-1),
    }
    return {name: column.ravel() for name, column in columns.items()}


def rmse(actual: Array, predicted: Array) -> Array:
    """Root mean square error over the last axis, eq (34), of the entries that are no NaN; NaN if none is."""
    squares = (predicted - actual) ** 2
    count = np.sum(~np.isnan(squares), axis=-1)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.sqrt(np.nansum(squares, axis=-1) / count), np.float64)


def extreme(result: SweepResult, pick: Callable[..., NDArray[np.intp]], worst: float) -> tuple[Array, Array]:
    """Theoretical radius and heading where `pick` finds its curvature, taken positive into the turn, extreme.

    Parameters
    ----------
    result
        The turns.
    pick
        `numpy.argmin` or `numpy.argmax`.
    worst
        A curvature that it never picks.

    Returns
    -------
    tuple of ndarray, shape (n_slope, n_velocity)
        Radius [m] and heading [rad], NaN where no heading has an answer.
    """
    curvature = math.copysign(1.0, result.request.radius) / result.theoretical_radius
    place = pick(np.where(np.isnan(curvature), worst, curvature), axis=-1)
    radius = np.take_along_axis(result.theoretical_radius, place[..., None], axis=-1)[..., 0]
    return radius, np.where(np.isnan(radius), np.nan, result.request.heading[place])


def status_counts(result: SweepResult) -> dict[str, int]:
    """Number of operating points of each status, by its word."""
    counts = np.bincount(result.status.ravel(), minlength=len(Status))
    return {each.name.lower(): int(counts[each]) for each in Status}


def reasons(result: SweepResult) -> str:
    """Why operating points have no answer, with their numbers; empty if all have one."""
    counts = status_counts(result).items()
    return ", ".join(f"{count} {word}" for word, count in counts if count and word != "converged")


def rows_of(columns: Mapping[str, Array | NDArray[np.int64]]) -> Iterator[dict[str, float | None]]:
    """The rows of a summary in the types of JSON, None for NaN."""
    for row in zip(*(column.tolist() for column in columns.values()), strict=True):
        yield {name: None if math.isnan(value) else value for name, value in zip(columns, row, strict=True)}
