"""`lookup`: sprocket commands for operating points, from a table or from the model that it was made with."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import interpreted
from trackctl.errors import InputFileError
from trackctl.files.lut_match import check_matches
from trackctl.files.lut_reader import LutHeader, read_lut, read_lut_header
from trackctl.lut.axes import Array, Axes
from trackctl.lut.interpolation import LookupResult, LookupStatus, interpolant, look_up, table_points
from trackctl.lut.shape_functions import Method, axis_stencils
from trackctl.lut.table import Table
from trackctl.mechanics.parameters import track_model
from trackctl.mechanics.slip import body_speed, slip
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.workflows.lookup_method import LookupMethod
from trackctl.workflows.operating_points import OperatingPoints

Progress = Callable[[int, int], None]
Found = TypeVar("Found", Table, LutHeader)

#: Points answered between two reports of progress.
BATCH = 16384
#: Most points that are interpreted, at some 3 ms each.
FEW = 64
SHOWN_SLOPES = 8


@dataclass(frozen=True, slots=True, eq=False)
class LookupRequest:
    """What to look up, and where.

    Attributes
    ----------
    lut
        The table's file.
    points
        The queries; their slope may be left out if the table has only one.
    method
        How they are answered.
    vehicle, terrain, gravity
        What the table must be made for, None to take it as it is; the limits of a vehicle that is given apply
        in place of the table's. Gravity: [m/s2]
    jobs
        Threads.
    """

    lut: Path
    points: OperatingPoints
    method: LookupMethod = LookupMethod.MLS
    vehicle: VehicleProfile | None = None
    terrain: TerrainProfile | None = None
    gravity: float | None = None
    jobs: int = 1


def lookup(request: LookupRequest, progress: Progress = lambda done, total: None) -> LookupResult:
    """Answer the queries of a request.

    Parameters
    ----------
    request
        What to look up.
    progress
        Told the number of points answered, and of all.

    Returns
    -------
    LookupResult
        Arrays of shape (n_points,); NaN where `status` says that there is no answer.

    Raises
    ------
    LutFormatError
        If the file is no table.
    LutMismatchError
        If the table is made for something else.
    InputFileError
        If the points do not say which of the table's slopes they are on.
    """
    answer, axes = opened_table(request)
    context = interpreted if is_short(request) else nullcontext
    velocity, curvature, heading = request.points.velocity, request.points.curvature, request.points.heading
    points = np.stack((slopes(request, axes), velocity, curvature, heading))
    answered = []
    for start in range(0, velocity.size, BATCH):
        with context():
            answered.append(answer(np.ascontiguousarray(points[:, start : start + BATCH])))
        progress(min(start + BATCH, velocity.size), velocity.size)
    return joined(answered)


def is_short(request: LookupRequest) -> bool:
    """Whether so little is asked that it is answered sooner than compiled code is loaded."""
    return request.method is not LookupMethod.EXACT and request.points.velocity.size <= FEW


def opened_table(request: LookupRequest) -> tuple[Callable[[Array], LookupResult], Axes]:
    """What answers a batch of points, shape (4, n_points), and the axes of the table behind it."""
    if request.method is LookupMethod.EXACT:
        header = matching(request, read_lut_header(request.lut))
        return lambda points: exact_answers(header, points, request.jobs), header.axes
    table = matching(request, read_lut(request.lut))
    packed, method = interpolant(table), Method(request.method.value)

    def interpolated(points: Array) -> LookupResult:
        slope, velocity, curvature, heading = points
        return look_up(packed, slope, velocity, curvature, heading, method, request.jobs)

    return interpolated, table.axes


def matching(request: LookupRequest, found: Found) -> Found:
    """The table for the vehicle asked for, or a `LutMismatchError`."""
    vehicle, terrain = request.vehicle or found.vehicle, request.terrain or found.terrain
    gravity = found.gravity if request.gravity is None else request.gravity
    check_matches(found, vehicle, terrain, gravity, request.lut)
    return replace(found, vehicle=vehicle)


def slopes(request: LookupRequest, axes: Axes) -> Array:
    """Slope of each point: its own, or the only one of the table."""
    if request.points.slope is not None:
        return request.points.slope
    if axes.slope.size == 1:
        return np.full(request.points.velocity.size, axes.slope[0])
    shown = ", ".join(f"{angle:.6g}" for angle in np.degrees(axes.slope[:SHOWN_SLOPES]))
    more = ", ..." if axes.slope.size > SHOWN_SLOPES else ""
    raise InputFileError(
        request.lut,
        f"has {axes.slope.size} slopes ({shown}{more} deg) and the points name none; "
        "add a column slope_rad or slope_deg, or --slope-deg to a single point",
    )


def exact_answers(header: LutHeader | Table, points: Array, jobs: int) -> LookupResult:
    """Answers of the model itself to points in the range of a table, shape (4, n_points)."""
    inside = inside_table(header.axes, header.vehicle, points)
    return solved_answers(header.vehicle, header.terrain, header.gravity, points, inside, jobs)


def solved_answers(
    vehicle: VehicleProfile,
    terrain: TerrainProfile,
    gravity: float,
    points: Array,
    inside: NDArray[np.bool_],
    jobs: int,
) -> LookupResult:
    """Answers of the model to those of the points, shape (4, n_points), that are `inside`."""
    from trackctl.lut.point import solve_points  # with it numba, which other methods may do without

    model = track_model(vehicle, terrain, gravity)
    status = np.full(inside.size, LookupStatus.OUTSIDE_TABLE, np.uint8)
    ratios = np.full((3, inside.size), np.nan)
    cells = solve_points(model, points[:, inside].T, jobs=jobs)
    status[inside], ratios[:, inside] = cells["status"], cells["unknowns"].T
    too_fast = np.abs(ratios[:2] * points[1]).max(axis=0) > vehicle.max_sprocket_rate * vehicle.sprocket_radius
    status[too_fast], ratios[:, too_fast] = LookupStatus.ACTUATOR_LIMIT, np.nan

    left, right, sideslip = ratios
    velocity, curvature = points[1], np.where(inside, points[2], np.nan)
    left_arm, right_arm = (side * vehicle.track_gauge - vehicle.cog_left for side in (0.5, -0.5))
    return LookupResult(
        track_speed_left=left * velocity,
        track_speed_right=right * velocity,
        sprocket_rate_left=left * velocity / vehicle.sprocket_radius,
        sprocket_rate_right=right * velocity / vehicle.sprocket_radius,
        sideslip=sideslip,
        slip_left=slip(left, body_speed(1.0, curvature, sideslip, left_arm)),
        slip_right=slip(right, body_speed(1.0, curvature, sideslip, right_arm)),
        status=status,
    )


def inside_table(axes: Axes, vehicle: VehicleProfile, points: Array) -> NDArray[np.bool_]:
    """Whether points lie in the range of a table, as interpolation has it, shape (n_points,)."""
    stencils = axis_stencils(axes)
    mirrored = bool(axes.curvature[0] >= 0.0) and vehicle.cog_left == 0.0
    places = table_points(points, mirrored, stencils[-1].lower)
    within = [(axis.lower <= x) & (x <= axis.upper) for axis, x in zip(stencils, places, strict=True)]
    return np.asarray(np.all(within, axis=0), np.bool_)


def joined(parts: list[LookupResult]) -> LookupResult:
    """Results of consecutive batches as one."""
    names = [field.name for field in dataclasses.fields(LookupResult)]
    return LookupResult(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def answer_columns(result: LookupResult) -> dict[str, Array | list[str]]:
    """The answers as columns of a CSV table."""
    words = {each.value: each.label for each in LookupStatus}
    return {
        "sprocket_rate_left_radps": result.sprocket_rate_left,
        "sprocket_rate_right_radps": result.sprocket_rate_right,
        "track_speed_left_mps": result.track_speed_left,
        "track_speed_right_mps": result.track_speed_right,
        "sideslip_rad": result.sideslip,
        "slip_left": result.slip_left,
        "slip_right": result.slip_right,
        "status": [words[code] for code in result.status.tolist()],
    }


def status_counts(result: LookupResult) -> dict[str, int]:
    """Number of points of each status, by its word."""
    counts = np.bincount(result.status, minlength=len(LookupStatus))
    return {each.label: int(counts[each]) for each in LookupStatus}
