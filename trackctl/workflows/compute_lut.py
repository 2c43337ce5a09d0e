"""`compute-lut`: sensitivity, steps, solving, certificate, file."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from trackctl import __version__
from trackctl.errors import NoAnswerError, UsageError
from trackctl.files.atomic import check_output, whole_file
from trackctl.files.journal import Journal, journal_path
from trackctl.files.lut_writer import LutWriter
from trackctl.files.profile_yaml import terrain_to_yaml, vehicle_to_yaml
from trackctl.lut.axes import Array, Axes
from trackctl.lut.cell import TOLERANCE
from trackctl.lut.cells import CELL, Cells
from trackctl.lut.certificate import (
    ErrorCertificate,
    SwarmCheck,
    certify,
    check_by_swarm,
    random_arcs,
    random_near_straight,
)
from trackctl.lut.grid import Divisions, Ranges, check_ranges, make_axes
from trackctl.lut.interpolation import Interpolant, interpolant_of
from trackctl.lut.sweep import Seeding, Sweep, column_values, solve_columns
from trackctl.lut.table import Status
from trackctl.mechanics.parameters import TrackModel, track_model
from trackctl.mechanics.quadrature import COUNTS
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.workflows.provenance import Provenance
from trackctl.workflows.table_steps import ChosenSteps

Progress = Callable[[int, int], None]

#: Points of the error certificate, and cells of the swarm check.
CERTIFICATE_POINTS = 2000
CHECKED_CELLS = 250


@dataclass(frozen=True, slots=True, eq=False)
class TableRequest:
    """What a table is compiled from.

    Attributes
    ----------
    vehicle, terrain
        Profiles.
    gravity
        [m/s2]
    slope
        Nodes of the slope axis. [rad]
    ranges, divisions
        Of the other axes.
    seeding, seed
        Of the solver.
    """

    vehicle: VehicleProfile
    terrain: TerrainProfile
    gravity: float
    slope: Array
    ranges: Ranges
    divisions: Divisions
    seeding: Seeding
    seed: int

    @property
    def model(self) -> TrackModel:
        """Vehicle on its terrain."""
        return track_model(self.vehicle, self.terrain, self.gravity)

    @property
    def axes(self) -> Axes:
        """Grid nodes."""
        return make_axes(self.vehicle, self.slope, self.ranges, self.divisions)

    @property
    def sweep(self) -> Sweep:
        """What the columns are solved from."""
        return Sweep(self.model, self.axes, self.seeding, self.seed)

    def description(self) -> dict[str, object]:
        """All that the cells depend on, for people and for a digest."""
        return {
            "trackctl_version": __version__,
            "vehicle": vehicle_to_yaml(self.vehicle),
            "terrain": terrain_to_yaml(self.terrain),
            "gravity_mps2": self.gravity,
            "slope_rad": self.slope.tolist(),
            "ranges": asdict(self.ranges),
            "divisions": asdict(self.divisions),
            "seeding": str(self.seeding),
            "seed": self.seed,
        }


class ToleranceError(Exception):
    """The held-out sample errs by more than the tolerance.

    Parameters
    ----------
    error
        Its largest error, as a share of the vehicle's speed.
    """

    def __init__(self, error: float) -> None:
        self.error = error
        super().__init__(f"held-out error {error:g}")


@dataclass(frozen=True, slots=True)
class TableSummary:
    """What became of a table.

    Attributes
    ----------
    cells
        Number of cells.
    status_counts
        Cells of each status.
    certificate, near_straight
        Interpolation error on turns of the table's radii, and between the largest radius and straight driving.
    swarm_check
        Sample of cells solved again.
    """

    cells: int
    status_counts: dict[Status, int]
    certificate: ErrorCertificate
    near_straight: ErrorCertificate
    swarm_check: SwarmCheck

    def attributes(self) -> dict[str, object]:
        """Root attributes that state it in the file."""
        named = {
            "certificate": asdict(self.certificate),
            "certificate_near_straight": asdict(self.near_straight),
            "swarm_check": asdict(self.swarm_check),
        }
        return {f"{group}_{key}": value for group, values in named.items() for key, value in values.items()}


def new_request(
    vehicle: VehicleProfile,
    terrain: TerrainProfile,
    gravity: float,
    slope: Array,
    ranges: Ranges,
    seeding: str,
    seed: int,
) -> TableRequest:
    """A checked request whose divisions are still to be chosen.

    Raises
    ------
    UsageError
        If a slope or range is not allowed.
    """
    check_ranges(vehicle, slope, ranges)
    return TableRequest(vehicle, terrain, gravity, slope, ranges, Divisions(0, 0, 0), Seeding(seeding), seed)


def digest_of(description: dict[str, object]) -> str:
    """Digest of a request."""
    return hashlib.sha256(json.dumps(description, sort_keys=True).encode()).hexdigest()


def settings_attributes(request: TableRequest) -> dict[str, object]:
    """Root attributes that state how the cells were solved."""
    return {
        "seed": request.seed,
        "seeding": str(request.seeding),
        "solver": "PSO-LM",
        "residual_tolerance": TOLERANCE,
        "quadrature": "Gauss-Legendre, each track split where the lateral sliding vanishes",
        "quadrature_nodes": np.array(COUNTS),
        "certificate_method": "mls",
        "certificate_unit": "error of the worse track's speed over the vehicle's speed",
    }


@contextmanager
def checkpoint(request: TableRequest, output: Path, resume: bool, force: bool) -> Iterator[Journal]:
    """Journal of the columns that are done; kept if the block fails, removed if it ends well."""
    description = request.description()
    path, digest = journal_path(output), digest_of(description)
    if resume:
        journal = Journal.resume(path, digest, description)
    else:
        journal = Journal.create(path, digest, description, force)
    with journal:
        yield journal
        journal.discard()


def solve_into(journal: Journal, sweep: Sweep, executor: Executor, workers: int, progress: Progress) -> None:
    """Solve the columns that the journal lacks."""
    done = journal.blocks()
    total = sweep.column_count
    progress(len(done), total)
    missing = (column for column in range(total) if column not in done)
    for count, (column, cells) in enumerate(
        solve_columns(sweep, missing, executor, workers), start=len(done) + 1
    ):
        journal.append(column, cells.tobytes())
        progress(count, total)


def cells_of(journal: Journal, sweep: Sweep, column: int) -> Cells:
    """Cells of a column in the journal."""
    shape = sweep.axes.velocity.size, sweep.axes.heading.size
    return np.frombuffer(journal.read(column), CELL).reshape(shape)


def packed(journal: Journal, sweep: Sweep) -> tuple[Array, NDArray[np.uint8]]:
    """Unknowns and status of the whole table, shapes (*axes.shape, 3) and axes.shape."""
    unknowns = np.empty((*sweep.axes.shape, 3))
    status = np.empty(sweep.axes.shape, np.uint8)
    for column in range(sweep.column_count):
        i, k = sweep.place(column)
        cells = cells_of(journal, sweep, column)
        unknowns[i, :, k], status[i, :, k] = cells["unknowns"], cells["status"]
    return unknowns, status


def certificates(
    table: Interpolant, request: TableRequest, axes: Axes, jobs: int
) -> tuple[ErrorCertificate, ErrorCertificate]:
    """Error on turns of the table's radii, and between the largest radius and straight driving."""
    random = np.random.default_rng(request.seed)
    arcs = random_arcs(axes, CERTIFICATE_POINTS, random)
    near_straight = random_near_straight(axes, CERTIFICATE_POINTS // 4, random)
    return (
        certify(table, request.model, arcs, request.seed, jobs),
        certify(table, request.model, near_straight, request.seed, jobs),
    )


def summarise(journal: Journal, request: TableRequest, jobs: int) -> TableSummary:
    """Count the cells, check a sample of them and certify the interpolation.

    Raises
    ------
    NoAnswerError
        If no cell has converged.
    """
    sweep = request.sweep
    unknowns, status = packed(journal, sweep)
    counted = np.bincount(status.ravel(), minlength=len(Status))
    counts = {each: int(counted[each]) for each in Status}
    if counts[Status.CONVERGED] == 0:
        reasons = ", ".join(f"{count} {each.name.lower()}" for each, count in counts.items() if count)
        raise NoAnswerError(f"no cell of the table is feasible: {reasons}")
    swarm = check_by_swarm(sweep.model, sweep.axes, unknowns, status, CHECKED_CELLS, request.seed, jobs)
    table = interpolant_of(sweep.axes, unknowns, status, request.vehicle, math.inf)
    certificate, near_straight = certificates(table, request, sweep.axes, jobs)
    return TableSummary(status.size, counts, certificate, near_straight, swarm)


def write_table(
    path: Path,
    journal: Journal,
    request: TableRequest,
    steps: ChosenSteps,
    summary: TableSummary,
    provenance: Provenance,
) -> None:
    """Write the file from the journal, column by column."""
    sweep = request.sweep
    attributes = {
        "created": provenance.created,
        "history": provenance.history,
        **settings_attributes(request),
        **steps.attributes(),
        **summary.attributes(),
    }
    weight = request.vehicle.mass * request.gravity
    with LutWriter(path, sweep.axes, request.vehicle, request.terrain, request.gravity, attributes) as writer:
        for column in range(sweep.column_count):
            cells = cells_of(journal, sweep, column)
            values = column_values(sweep, column, cells, request.vehicle.sprocket_radius, weight)
            writer.write_column(*sweep.place(column), values, cells["status"])
        if steps.sensitivity is not None:
            found = steps.sensitivity
            samples = np.column_stack((found.inputs, found.outputs))
            writer.write_sensitivity(found.result.indices, found.names, samples, steps.attributes())


def compute_lut(
    request: TableRequest,
    steps: ChosenSteps,
    output: Path,
    provenance: Provenance,
    *,
    tolerance: float | None = None,
    jobs: int,
    resume: bool,
    force: bool,
    progress: Progress,
    executor: Executor | None = None,
) -> TableSummary:
    """Compile a table into a file.

    Parameters
    ----------
    request
        What to compile.
    steps
        Where the divisions of the request came from, to be stated in the file.
    output
        The file; it appears whole or not at all.
    provenance
        To be stated in the file.
    tolerance
        Largest error of the held-out sample, as a share of the vehicle's speed.
    jobs
        Threads, or columns per worker of the executor to keep under way.
    resume, force
        Continue the checkpoint beside the output; replace the output and drop the checkpoint.
    progress
        Told the number of columns done, and of all.
    executor
        Where the columns are solved; threads of this process if None.

    Raises
    ------
    UsageError, OutputError, InputFileError
        Before anything is computed.
    NoAnswerError, ToleranceError
        If no cell is feasible, or the tolerance is not met; nothing is left behind.
    """
    sweep = request.sweep
    check_output(output, force)
    with checkpoint(request, output, resume, force) as journal:
        if executor is None:
            with ThreadPoolExecutor(jobs) as threads:
                solve_into(journal, sweep, threads, jobs, progress)
        else:
            solve_into(journal, sweep, executor, jobs, progress)
        try:
            summary = summarise(journal, request, jobs)
            if tolerance is not None and not summary.certificate.max_error <= tolerance:
                raise ToleranceError(summary.certificate.max_error)
        except (NoAnswerError, ToleranceError):
            journal.discard()
            raise
        with whole_file(output, force) as path:
            write_table(path, journal, request, steps, summary, provenance)
    return summary


def refuse_streams(output: Path) -> None:
    """A table is no stream: HDF5 needs a file that it can seek in."""
    if str(output) == "-":
        raise UsageError("--output", "-", "the path of a file")
