"""`compute-lut`: columns into a checkpoint, certificate, file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, nullcontext
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from trackctl.errors import NoAnswerError, OutputError, UsageError, WorkerError
from trackctl.files.atomic import check_output, is_stream, whole_file
from trackctl.files.journal import Journal, journal_path
from trackctl.files.lut_writer import LutWriter
from trackctl.lut.axes import Array
from trackctl.lut.cell import TOLERANCE
from trackctl.lut.cells import CELL, Cells
from trackctl.lut.certificate import CERTIFIED_SHARE
from trackctl.lut.crew import Crew, solve_columns, threads
from trackctl.lut.sweep import Sweep, column_values
from trackctl.mechanics.quadrature import COUNTS
from trackctl.workflows.provenance import Provenance
from trackctl.workflows.table_request import TableRequest, digest_of
from trackctl.workflows.table_steps import ChosenSteps
from trackctl.workflows.table_summary import TableSummary, summary_of

Progress = Callable[[int, int], None]


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
        "certificate_share": CERTIFIED_SHARE,
    }


def refuse_streams(output: Path) -> None:
    """A table is no stream: HDF5 needs a file that it can seek in."""
    if str(output) == "-" or is_stream(output):
        raise UsageError("--output", output, "the path of a file; a table cannot be written to a stream")


@contextmanager
def checkpoint(request: TableRequest, output: Path, resume: bool, force: bool) -> Iterator[Journal]:
    """Journal of the columns that are done: removed if the block ends well or has no answer, else kept.

    Raises
    ------
    OutputError, InputFileError, WorkerError
        If it cannot be opened; or from the block, with a word on how to go on.
    """
    description = request.description()
    path, digest = journal_path(output), digest_of(description)
    kept = f"{path} keeps what is done, --resume continues"
    with (
        Journal.resume(path, digest, description) if resume else Journal.create(path, digest, description, force)
    ) as journal:
        try:
            yield journal
        except NoAnswerError:
            journal.discard()
            raise
        except OutputError as error:
            raise OutputError(error.file, f"{error.problem}; {kept}") from error
        except WorkerError as error:
            raise WorkerError(f"{error}; {kept}") from error
        journal.discard()


def solve_into(journal: Journal, sweep: Sweep, crew: Crew, progress: Progress) -> None:
    """Solve the columns that the journal lacks."""
    done = journal.blocks()
    total = sweep.column_count
    progress(len(done), total)
    missing = (column for column in range(total) if column not in done)
    with closing(solve_columns(sweep, missing, crew)) as columns:
        for count, (column, cells) in enumerate(columns, start=len(done) + 1):
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


def summarise(journal: Journal, request: TableRequest, jobs: int) -> TableSummary:
    """Summary of the columns in the journal, which holds all of them.

    Raises
    ------
    NoAnswerError
        If no cell has converged.
    """
    return summary_of(request, *packed(journal, request.sweep), jobs)


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
    jobs: int,
    resume: bool,
    force: bool,
    progress: Progress,
    crew: Crew | None = None,
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
    jobs
        Threads of this process.
    resume
        Continue the checkpoint beside the output.
    force
        Replace the output, and unless resumed drop the checkpoint.
    progress
        Told the number of columns done, and of all.
    crew
        Who solves the columns; threads of this process if None.

    Raises
    ------
    UsageError, OutputError, InputFileError
        If the table cannot be written; what is done stays in the checkpoint.
    WorkerError
        If the crew fails; what is done stays in the checkpoint.
    NoAnswerError
        If no cell is feasible; nothing is left behind.
    """
    sweep = request.sweep
    refuse_streams(output)
    check_output(output, force)
    with checkpoint(request, output, resume, force) as journal:
        with threads(jobs) if crew is None else nullcontext(crew) as workers:
            solve_into(journal, sweep, workers, progress)
        summary = summarise(journal, request, jobs)
        with whole_file(output, force) as path:
            write_table(path, journal, request, steps, summary, provenance)
    return summary
