"""How far a table can be trusted: against direct solves off the grid, and against independent swarms on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.lut.axes import FULL_CIRCLE, Array, Axes
from trackctl.lut.interpolation import Interpolant, LookupResult, LookupStatus, look_up
from trackctl.lut.point import solve_points
from trackctl.lut.shape_functions import Method
from trackctl.lut.table import Status
from trackctl.mechanics.parameters import TrackModel

#: Roots that differ by more than this are two. [-]
SAME_ROOT = 1e-6
#: Share of the points that err by no more than the `certified_error`.
CERTIFIED_SHARE = 0.99


@dataclass(frozen=True, slots=True)
class ErrorCertificate:
    """Error of interpolated track speeds, as a share of the vehicle's speed, over points where both have an answer.

    Attributes
    ----------
    max_error, rms_error
        Of the worse track, NaN if no point was compared. [-]
    certified_error
        What all but a share of 1 - `CERTIFIED_SHARE` of the points stay within: the largest error belongs to the few
        points next to the fold where grip ends. [-]
    points
        Number of points compared.
    unanswered
        Points that the model answers and the table does not, being near infeasible cells.
    unfounded
        Points that the table answers and the model does not.
    """

    max_error: float
    rms_error: float
    certified_error: float
    points: int
    unanswered: int
    unfounded: int


@dataclass(frozen=True, slots=True)
class SwarmCheck:
    """Cells solved again by a swarm that knows nothing of the table.

    Attributes
    ----------
    cells
        Number of cells.
    different_root
        Cells that both solve, with different roots.
    different_feasibility
        Cells that only one of the two solves.
    """

    cells: int
    different_root: int
    different_feasibility: int

    @property
    def disagreements(self) -> int:
        """Cells where the two disagree."""
        return self.different_root + self.different_feasibility


def between(nodes: Array, share: Array) -> Array:
    """Values spread over the range of an axis, uniformly in its value."""
    low, high = float(nodes[0]), float(nodes[-1])
    return low + share * (high - low)


def random_arcs(axes: Axes, count: int, random: np.random.Generator) -> Array:
    """Operating points on turns, uniform in each axis (radius, not curvature) of a table, shape (count, 4)."""
    points = np.empty((count, 4))
    points[:, 0] = between(axes.slope, random.random(count))
    points[:, 1] = between(axes.velocity, random.random(count))
    points[:, 2] = random_sides(axes, count, random) / between(left_radii(axes), random.random(count))
    points[:, 3] = random_headings(axes, count, random)
    return points


def random_along(axes: Axes, axis: str, count: int, random: np.random.Generator) -> Array:
    """Operating points on nodes of all axes but one, and anywhere along that, shape (count, 4).

    Parameters
    ----------
    axes
        Of the table.
    axis
        ``slope``, ``velocity``, ``radius`` or ``heading``.
    count
        Number of points; all on turns.
    random
        Source of the draws.
    """
    radii, anywhere = left_radii(axes), random_arcs(axes, count, random)
    on_nodes = np.column_stack(
        (
            random.choice(axes.slope, count),
            random.choice(axes.velocity, count),
            random_sides(axes, count, random) / random.choice(radii, count),
            random.choice(axes.heading, count),
        )
    )
    place = ("slope", "velocity", "radius", "heading").index(axis)
    on_nodes[:, place] = anywhere[:, place]
    return on_nodes


def left_radii(axes: Axes) -> Array:
    """Radii of the left turns, ascending. [m]"""
    return axes.radius[axes.curvature > 0.0][::-1]


def random_sides(axes: Axes, count: int, random: np.random.Generator) -> Array:
    """1 for a left turn, -1 for a right one where the table holds those, shape (count,)."""
    if axes.curvature[0] >= 0.0:
        return np.ones(count)
    return np.where(random.random(count) < 0.5, 1.0, -1.0)


def random_near_straight(axes: Axes, count: int, random: np.random.Generator) -> Array:
    """Operating points between straight driving and the table's largest radius, shape (count, 4)."""
    points = random_arcs(axes, count, random)
    least = axes.curvature[axes.curvature > 0.0][0]
    points[:, 2] = np.sign(points[:, 2]) * least * random.random(count)
    return points


def random_headings(axes: Axes, count: int, random: np.random.Generator) -> Array:
    """Headings within the table."""
    if axes.heading_is_periodic:
        return FULL_CIRCLE * random.random(count)
    return between(axes.heading, random.random(count))


def track_error(found: LookupResult, unknowns: Array, velocity: Array) -> Array:
    """Error of the worse track's speed as a share of the vehicle's speed, shape (n,). [-]"""
    left = found.track_speed_left / velocity - unknowns[:, 0]
    right = found.track_speed_right / velocity - unknowns[:, 1]
    return np.maximum(np.abs(left), np.abs(right))


def certify(table: Interpolant, model: TrackModel, points: Array, seed: int, jobs: int) -> ErrorCertificate:
    """Compare moving least squares on a table with direct solves.

    Parameters
    ----------
    table
        With actuator limits out of the way.
    model
        Vehicle on its terrain.
    points
        Slope [rad], velocity [m/s], curvature [1/m], heading [rad], shape (n, 4).
    seed, jobs
        Of the direct solves.
    """
    exact = solve_points(model, points, seed=seed, jobs=jobs)
    slope, velocity, curvature, heading = points.T
    found = look_up(table, slope, velocity, curvature, heading, Method.MLS, jobs)
    solved = exact["status"] == Status.CONVERGED
    answered = found.status == LookupStatus.CONVERGED
    both = solved & answered
    error = track_error(found, exact["unknowns"], velocity)[both]
    known = error if error.size else np.array([np.nan])
    return ErrorCertificate(
        max_error=float(known.max()),
        rms_error=float(np.sqrt(np.mean(known**2))),
        certified_error=float(np.quantile(known, CERTIFIED_SHARE)),
        points=error.size,
        unanswered=int((solved & ~answered).sum()),
        unfounded=int((answered & ~solved).sum()),
    )


def check_by_swarm(
    model: TrackModel,
    axes: Axes,
    unknowns: Array,
    status: NDArray[np.uint8],
    count: int,
    seed: int,
    jobs: int,
) -> SwarmCheck:
    """Solve a random sample of cells again, by a swarm in each, and count where the answers differ.

    Parameters
    ----------
    model, axes
        Of the table.
    unknowns, status
        The table's cells, shapes (*axes.shape, 3) and axes.shape.
    count
        Cells to draw.
    seed, jobs
        Of the draw and the swarms.
    """
    places = np.random.default_rng(seed).choice(axes.size, min(count, axes.size), replace=False)
    index = np.unravel_index(places, axes.shape)
    nodes = (axes.slope, axes.velocity, axes.curvature, axes.heading)
    points = np.stack([axis[k] for axis, k in zip(nodes, index, strict=True)], axis=-1)
    again = solve_points(model, points, seed=seed ^ 1, swarm_always=True, jobs=jobs)
    solved, solved_again = status[index] == Status.CONVERGED, again["status"] == Status.CONVERGED
    apart = np.abs(again["unknowns"] - unknowns[index]).max(axis=-1)
    return SwarmCheck(
        cells=places.size,
        different_root=int((apart[solved & solved_again] > SAME_ROOT).sum()),
        different_feasibility=int((solved != solved_again).sum()),
    )
