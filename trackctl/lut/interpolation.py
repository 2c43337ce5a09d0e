"""Sprocket commands between the nodes of a table.

Interpolated are the track speeds over the vehicle's speed and the sideslip, which are smooth; slips follow.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trackctl.compiled import inlined, kernel
from trackctl.lut.axes import FULL_CIRCLE, Array, Axes
from trackctl.lut.shape_functions import Flags, Method, Offsets, Stencils, axis_stencils, weigh
from trackctl.lut.table import Status, Table
from trackctl.profiles.vehicle import VehicleProfile

Codes = NDArray[np.uint8]

#: Float arrays of a `LookupResult`.
ANSWER_COUNT = 7
#: Queries to a pass: their weights stay in the cache.
CHUNK = 4096
UNKNOWN = -1


class LookupStatus(IntEnum):
    """What became of a query: the table's `Status`, and what only a query can meet."""

    CONVERGED = Status.CONVERGED
    INFEASIBLE_GRIP = Status.INFEASIBLE_GRIP
    INFEASIBLE_LIFTOFF = Status.INFEASIBLE_LIFTOFF
    INFEASIBLE_PITCHOVER = Status.INFEASIBLE_PITCHOVER
    OUTSIDE_MODEL = Status.OUTSIDE_MODEL
    NOT_CONVERGED = Status.NOT_CONVERGED
    OUTSIDE_TABLE = 6
    NEAR_INFEASIBLE = 7
    ACTUATOR_LIMIT = 8

    @property
    def label(self) -> str:
        """The word for it in files."""
        return self.name.lower()


class Grid(NamedTuple):
    """What the kernels read of a table (a named tuple, since kernels take no dataclass).

    Attributes
    ----------
    slope, velocity, curvature, heading
        Stencils of the axes.
    values
        Left and right track speed over speed [-] and sideslip [rad], NaN in cells without an answer; heading
        innermost, shape (n_cells, 3).
    status
        `Status` of the cells, shape (n_cells,).
    mirrored
        Whether right turns are read as mirrored left turns.
    half_gauge, cog_left, sprocket_radius
        Of the vehicle. [m]
    max_sprocket_rate
        Of the vehicle. [rad/s]
    """

    slope: Stencils
    velocity: Stencils
    curvature: Stencils
    heading: Stencils
    values: Array
    status: Codes
    mirrored: bool
    half_gauge: float
    cog_left: float
    sprocket_radius: float
    max_sprocket_rate: float


@dataclass(frozen=True, slots=True, eq=False)
class Interpolant:
    """A table made ready for `look_up`."""

    grid: Grid


@dataclass(frozen=True, slots=True, eq=False)
class LookupResult:
    """Answers to a batch of queries, arrays of shape (n_queries,); NaN where the status is not converged.

    Attributes
    ----------
    track_speed_left, track_speed_right
        Of the tracks over the hull. [m/s]
    sprocket_rate_left, sprocket_rate_right
        [rad/s]
    sideslip
        From the body's x axis to the velocity of the mass centre, counter-clockwise. [rad]
    slip_left, slip_right
        Positive driving, negative braking. [-]
    status
        `LookupStatus` of each query.
    """

    track_speed_left: Array
    track_speed_right: Array
    sprocket_rate_left: Array
    sprocket_rate_right: Array
    sideslip: Array
    slip_left: Array
    slip_right: Array
    status: Codes


def interpolant(table: Table) -> Interpolant:
    """Pack a table for `look_up`, once: the values of a cell adjacent in memory."""
    speed_ratio = table.vehicle.sprocket_radius / table.axes.velocity[:, None, None]
    unknowns = np.stack(
        [
            table.values["sprocket_rate_left"] * speed_ratio,
            table.values["sprocket_rate_right"] * speed_ratio,
            table.values["sideslip"],
        ],
        axis=-1,
    )
    return interpolant_of(table.axes, unknowns, table.status, table.vehicle, table.vehicle.max_sprocket_rate)


def interpolant_of(
    axes: Axes, unknowns: Array, status: Codes, vehicle: VehicleProfile, max_sprocket_rate: float
) -> Interpolant:
    """Make solved cells ready for `look_up`.

    Parameters
    ----------
    axes
        Grid nodes.
    unknowns
        Left and right track speed over speed [-] and sideslip [rad], shape `axes.shape` and 3; overwritten with NaN
        where the status is not converged.
    status
        `Status` of the cells, shape `axes.shape`.
    vehicle
        For its geometry.
    max_sprocket_rate
        Above it a query is at the actuator limit. [rad/s]
    """
    unknowns[status != Status.CONVERGED] = np.nan
    values, codes = unknowns.reshape(-1, 3), status.flatten()
    values.setflags(write=False)
    codes.setflags(write=False)
    left_turns_only = bool(axes.curvature[0] >= 0.0)
    grid = Grid(
        *axis_stencils(axes),
        values=values,
        status=codes,
        mirrored=left_turns_only and vehicle.cog_left == 0.0,
        half_gauge=0.5 * vehicle.track_gauge,
        cog_left=vehicle.cog_left,
        sprocket_radius=vehicle.sprocket_radius,
        max_sprocket_rate=max_sprocket_rate,
    )
    return Interpolant(grid)


def look_up(
    interpolant: Interpolant,
    slope: ArrayLike,
    velocity: ArrayLike,
    curvature: ArrayLike,
    heading: ArrayLike,
    method: Method = Method.MLS,
    jobs: int = 1,
) -> LookupResult:
    """Interpolate a table at a batch of operating points.

    Nothing is extrapolated, and no value comes from a stencil that counts an infeasible cell.

    Parameters
    ----------
    interpolant
        The packed table.
    slope, velocity, curvature, heading
        Operating points, broadcast to shape (n_queries,). [rad], [m/s], [1/m], [rad]
    method
        MLS has a continuous slope across cells, cubic errs least on a smooth table, linear counts the fewest
        neighbours, so it answers nearest to infeasible cells.
    jobs
        Threads.
    """
    queries = np.broadcast_arrays(*(np.atleast_1d(axis) for axis in (slope, velocity, curvature, heading)))
    count = queries[0].size
    answers = np.empty((ANSWER_COUNT, count))
    status = np.empty(count, np.uint8)

    def answer(start: int) -> None:
        part = slice(start, start + CHUNK)
        points = np.stack([axis[part] for axis in queries], dtype=np.float64)
        found = np.empty((ANSWER_COUNT, points.shape[1]))
        answer_all(interpolant.grid, method.code, points, found, status[part])
        answers[:, part] = found

    starts = range(0, count, CHUNK)
    if jobs == 1 or len(starts) == 1:
        for start in starts:
            answer(start)
    else:
        with ThreadPoolExecutor(jobs) as pool:
            list(pool.map(answer, starts))
    return LookupResult(
        track_speed_left=answers[0],
        track_speed_right=answers[1],
        sprocket_rate_left=answers[2],
        sprocket_rate_right=answers[3],
        sideslip=answers[4],
        slip_left=answers[5],
        slip_right=answers[6],
        status=status,
    )


@kernel
def answer_all(grid: Grid, method: int, points: Array, answers: Array, status: Codes) -> None:
    """Answer queries, in passes over all: what costs is to fetch cells, and a pass overlaps that.

    Parameters
    ----------
    grid
        The packed table.
    method
        Its code.
    points
        Slope, velocity, curvature, heading, shape (4, n_queries).
    answers
        Results in the order of `LookupResult`, shape (ANSWER_COUNT, n_queries).
    status
        Result, shape (n_queries,).
    """
    count = status.size
    places = table_points(points, grid.mirrored, grid.heading.lower)
    weights, offsets = np.zeros((4, count, 4)), np.zeros((4, count, 4), np.uint64)
    inside = np.ones(count, np.bool_)
    weigh(grid.slope, method, places[0], weights[0], offsets[0], inside)
    weigh(grid.velocity, method, places[1], weights[1], offsets[1], inside)
    weigh(grid.curvature, method, places[2], weights[2], offsets[2], inside)
    weigh(grid.heading, method, places[3], weights[3], offsets[3], inside)
    contract(grid.values, weights, offsets, answers)
    judge(grid.status, weights, offsets, inside, answers, status)
    derive(grid, points, answers, status)


@kernel
def table_points(points: Array, mirrored: bool, lowest_heading: float) -> Array:
    """The points where the table is read: right turns mirrored, headings within a circle from the lowest."""
    places = points.copy()
    for query in range(points.shape[1]):
        heading = points[3, query]
        if mirrored and points[2, query] < 0.0:
            places[2, query] = -points[2, query]
            heading = -heading
        places[3, query] = heading - FULL_CIRCLE * np.floor((heading - lowest_heading) / FULL_CIRCLE)
    return places


@kernel
def contract(values: Array, weights: Array, offsets: Offsets, answers: Array) -> None:
    """Sum over the nodes that count: track speeds over speed and sideslip, into the first three answers."""
    for query in range(weights.shape[1]):
        left = right = sideslip = 0.0
        for i in range(4):
            weight_i = weights[0, query, i]
            if weight_i == 0.0:
                continue
            for j in range(4):
                weight_j = weight_i * weights[1, query, j]
                if weight_j == 0.0:
                    continue
                for k in range(4):
                    weight_k = weight_j * weights[2, query, k]
                    if weight_k == 0.0:
                        continue
                    row = offsets[0, query, i] + offsets[1, query, j] + offsets[2, query, k]
                    for n in range(4):
                        weight = weight_k * weights[3, query, n]
                        if weight != 0.0:
                            cell = row + offsets[3, query, n]
                            left += weight * values[cell, 0]
                            right += weight * values[cell, 1]
                            sideslip += weight * values[cell, 2]
        answers[0, query] = left
        answers[1, query] = right
        answers[2, query] = sideslip


@kernel
def judge(cell_status: Codes, weights: Array, offsets: Offsets, inside: Flags, answers: Array, status: Codes) -> None:
    """Status of each query before actuator limits; NaN for answers outside the table."""
    for query in range(status.size):
        if not inside[query]:
            status[query] = LookupStatus.OUTSIDE_TABLE
            answers[:3, query] = math.nan
        elif math.isnan(answers[0, query]):
            status[query] = refusal(cell_status, weights, offsets, query)
        else:
            status[query] = LookupStatus.CONVERGED


@kernel
def refusal(cell_status: Codes, weights: Array, offsets: Offsets, query: int) -> int:
    """Status of a query that counts a cell without an answer: that of its corners, where they share one."""
    common = UNKNOWN
    for i in range(1, 3):
        for j in range(1, 3):
            for k in range(1, 3):
                for n in range(1, 3):
                    weight = weights[0, query, i] * weights[1, query, j] * weights[2, query, k] * weights[3, query, n]
                    if weight == 0.0:
                        continue
                    row = offsets[0, query, i] + offsets[1, query, j] + offsets[2, query, k]
                    corner = int(cell_status[row + offsets[3, query, n]])
                    if common != UNKNOWN and common != corner:
                        return LookupStatus.NEAR_INFEASIBLE
                    common = corner
    return LookupStatus.NEAR_INFEASIBLE if common == LookupStatus.CONVERGED else common


@kernel
def derive(grid: Grid, points: Array, answers: Array, status: Codes) -> None:
    """All answers from the first three: undo the mirror, apply actuator limits, slips as in the model."""
    mirrored, radius, max_rate = grid.mirrored, grid.sprocket_radius, grid.max_sprocket_rate
    left_arm, right_arm = grid.half_gauge - grid.cog_left, -grid.half_gauge - grid.cog_left
    for query in range(status.size):
        velocity, curvature = points[1, query], points[2, query]
        left, right, sideslip = answers[0, query], answers[1, query], answers[2, query]
        if mirrored and curvature < 0.0:
            left, right, sideslip = right, left, -sideslip
        if max(abs(left), abs(right)) * velocity > max_rate * radius:
            status[query] = LookupStatus.ACTUATOR_LIMIT
            left = right = sideslip = math.nan
        answers[0, query] = left * velocity
        answers[1, query] = right * velocity
        answers[2, query] = left * velocity / radius
        answers[3, query] = right * velocity / radius
        answers[4, query] = sideslip
        answers[5, query] = slip(left, math.cos(sideslip) - curvature * left_arm)
        answers[6, query] = slip(right, math.cos(sideslip) - curvature * right_arm)


@inlined
def slip(track: float, body: float) -> float:
    """Slip of a track from its speed over the hull and the hull's over the ground, in one unit."""
    return (track - body) / max(abs(track), abs(body))
