"""`sensitivity`: how much speed, radius and heading each matter to the sprocket rates on a slope."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from trackctl.errors import NoAnswerError
from trackctl.lut.axes import Array
from trackctl.lut.cells import Cells
from trackctl.lut.grid import Ranges, check_ranges, default_ranges
from trackctl.lut.point import solve_points
from trackctl.lut.table import Status
from trackctl.mechanics.parameters import track_model
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.sensitivity.pawn import PawnResult, check_settings, pawn_indices
from trackctl.sensitivity.sampling import latin_hypercube

Progress = Callable[[int, int], None]

INPUTS = ("velocity", "radius", "heading")
OUTPUTS = ("sprocket_rate_left", "sprocket_rate_right")
#: Points solved between two reports of progress.
BATCH = 8192


@dataclass(frozen=True, slots=True)
class SensitivityRequest:
    """What to analyse, and how closely.

    Attributes
    ----------
    vehicle, terrain
        Profiles.
    gravity
        [m/s2]
    slope
        [rad]
    ranges
        Of the inputs; turns are to the left.
    samples
        Operating points.
    slices, resamples, confidence
        See `pawn_indices`.
    seed
        Of the sample, the swarms and the resamples.
    jobs
        Threads.
    """

    vehicle: VehicleProfile
    terrain: TerrainProfile
    gravity: float
    slope: float
    ranges: Ranges
    samples: int = 4096
    slices: int = 10
    resamples: int = 1000
    confidence: float = 0.95
    seed: int = 0
    jobs: int = 1


@dataclass(frozen=True, slots=True, eq=False)
class SensitivityResult:
    """Indices, and the sample that they come from.

    Attributes
    ----------
    result
        PAWN indices of the points that have an answer.
    inputs : ndarray, shape (n_samples, 3)
        Velocity [m/s], radius [m], heading [rad].
    outputs : ndarray, shape (n_samples, 2)
        Left and right sprocket rate, NaN where there is no answer. [rad/s]
    """

    result: PawnResult
    inputs: Array
    outputs: Array

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the inputs, then of the outputs."""
        return INPUTS + OUTPUTS


def ranges_within(
    vehicle: VehicleProfile,
    velocity: tuple[float, float] | None = None,
    radius: tuple[float, float] | None = None,
    heading: tuple[float, float] | None = None,
) -> Ranges:
    """The ranges given, and for those left out the vehicle's own. [m/s], [m], [rad]"""
    given = {"velocity": velocity, "radius": radius, "heading": heading}
    return replace(default_ranges(vehicle), **{name: ends for name, ends in given.items() if ends is not None})


def slope_steering_sensitivity(
    request: SensitivityRequest, progress: Progress = lambda done, total: None
) -> SensitivityResult:
    """PAWN indices of both sprocket rates over velocity, radius and heading at one slope.

    The points are a Latin hypercube over the ranges, each solved on its own; those without an answer are left
    out of the indices.

    Parameters
    ----------
    request
        What to analyse.
    progress
        Told the number of points solved, and of all.

    Raises
    ------
    UsageError
        If a range or setting is not allowed, or too few points have an answer.
    NoAnswerError
        If none has.
    """
    check_ranges(request.vehicle, np.array([request.slope]), request.ranges)
    check_settings(request.slices, request.resamples, request.confidence, request.samples)
    lower, upper = zip(*(getattr(request.ranges, name) for name in INPUTS), strict=True)
    inputs = latin_hypercube(lower, upper, request.samples, request.seed)
    cells = solve_inputs(request, inputs, progress)
    refuse_unanswered(cells)
    outputs = cells["unknowns"][:, :2] * inputs[:, :1] / request.vehicle.sprocket_radius
    result = pawn_indices(
        inputs,
        outputs,
        INPUTS,
        OUTPUTS,
        slices=request.slices,
        resamples=request.resamples,
        confidence=request.confidence,
        seed=request.seed,
    )
    return SensitivityResult(result, inputs, outputs)


def solve_inputs(request: SensitivityRequest, inputs: Array, progress: Progress) -> Cells:
    """Cells of the operating points with these velocities, radii and headings, shape (n_samples,)."""
    model = track_model(request.vehicle, request.terrain, request.gravity)
    velocity, radius, heading = inputs.T
    points = np.column_stack((np.full(radius.size, request.slope), velocity, 1.0 / radius, heading))
    solved = []
    for start in range(0, len(points), BATCH):
        batch = points[start : start + BATCH]
        solved.append(solve_points(model, batch, seed=request.seed, jobs=request.jobs))
        progress(start + len(batch), len(points))
    return np.concatenate(solved)


def refuse_unanswered(cells: Cells) -> None:
    """Raise a `NoAnswerError` if no cell has converged."""
    counts = np.bincount(cells["status"], minlength=len(Status))
    if not counts[Status.CONVERGED]:
        reasons = ", ".join(f"{counts[each]} {each.name.lower()}" for each in Status if counts[each])
        raise NoAnswerError(f"no sampled operating point has an answer: {reasons}")
