"""How fast the benchmark table is solved and written, and what its cells became.

Run from the repository: ``python benchmarks/compute_lut.py``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, process_time

import numpy as np
from tables import THREADS, benchmark_table, print_machine

from trackctl.files.atomic import whole_file
from trackctl.lut.cells import Cells
from trackctl.lut.crew import solve_columns, threads
from trackctl.lut.sweep import Seeding, Sweep
from trackctl.lut.table import Status
from trackctl.workflows.compute_lut import checkpoint, summarise, write_table
from trackctl.workflows.provenance import Provenance
from trackctl.workflows.table_request import TableRequest
from trackctl.workflows.table_steps import ChosenSteps

REPEATS = 5
SWARM_COLUMNS = 8
SWARM_REPEATS = 2
#: Unknowns of two solutions that differ by more than this are two roots.
SAME_ROOT = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """One timed solution of some columns: seconds of wall time and of CPU over all threads."""

    wall: float
    cpu: float
    columns: dict[int, Cells]


@dataclass(frozen=True, slots=True)
class FileTimes:
    """Seconds to write the checkpoint, to certify, and to write the table."""

    checkpoint: float
    certify: float
    table: float

    @property
    def writing(self) -> float:
        """All that goes to the disk."""
        return self.checkpoint + self.table


def timed_run(sweep: Sweep, columns: Sequence[int], jobs: int) -> Run:
    """Solve columns on a pool of threads that are already there."""
    with threads(jobs) as crew:
        wall, cpu = perf_counter(), process_time()
        done = dict(solve_columns(sweep, columns, crew))
        return Run(perf_counter() - wall, process_time() - cpu, done)


def print_rate(name: str, runs: Sequence[Run]) -> float:
    """Print the best of some runs; its wall time. [s]"""
    cells = sum(column.size for column in runs[0].columns.values())
    wall, cpu = min(run.wall for run in runs), min(run.cpu for run in runs)
    print(f"{name:28}{cells:>9}{wall:>9.3f}{cells / wall:>12,.0f}{cpu / cells * 1e6:>9.2f}")
    return wall


def print_shares(columns: dict[int, Cells]) -> None:
    """Print what the cells became."""
    cells = np.concatenate([column.ravel() for column in columns.values()])
    counts = np.bincount(cells["status"], minlength=len(Status))
    shares = ", ".join(f"{count / cells.size:.2%} {Status(k).name.lower()}" for k, count in enumerate(counts) if count)
    largest = cells["residual"][cells["status"] == Status.CONVERGED].max()
    print(f"cells: {shares}; {counts[Status.NOT_CONVERGED]} not converged; largest residual {largest:.1e}")


def print_agreement(swarm: dict[int, Cells], columns: dict[int, Cells]) -> None:
    """Print where a swarm in every cell and continuation disagree."""
    searched = np.concatenate([swarm[column].ravel() for column in swarm])
    continued = np.concatenate([columns[column].ravel() for column in swarm])
    both = (searched["status"] == Status.CONVERGED) & (continued["status"] == Status.CONVERGED)
    either = (searched["status"] == Status.CONVERGED) | (continued["status"] == Status.CONVERGED)
    apart = np.abs(searched["unknowns"] - continued["unknowns"])[both].max(axis=-1)
    print(
        f"swarm and continuation: {both.sum()} cells solved by both, {(either & ~both).sum()} by one only, "
        f"{(apart > SAME_ROOT).sum()} with another root; largest difference else "
        f"{apart[apart <= SAME_ROOT].max():.1e}"
    )


def time_file(request: TableRequest, steps: ChosenSteps, columns: dict[int, Cells]) -> FileTimes:
    """Write checkpoint and table as `compute-lut` does."""
    with TemporaryDirectory() as folder:
        output = Path(folder) / "lut.h5"
        with checkpoint(request, output, resume=False, force=False) as journal:
            started = perf_counter()
            for column, cells in columns.items():
                journal.append(column, cells.tobytes())
            kept = perf_counter()
            summary = summarise(journal, request, THREADS)
            certified = perf_counter()
            with whole_file(output, False) as path:
                write_table(path, journal, request, steps, summary, Provenance("", ""))
            return FileTimes(kept - started, certified - kept, perf_counter() - certified)


def main() -> None:
    request, steps = benchmark_table()
    sweep = request.sweep
    everything = range(sweep.column_count)
    print_machine()
    print(f"{request.vehicle.name} on {request.terrain.name}, {sweep.axes.shape} cells, warm, best of {REPEATS}")
    print(f"{'':28}{'cells':>9}{'wall s':>9}{'cells/s':>12}{'us CPU':>9}")
    columns = timed_run(sweep, everything, THREADS).columns  # compiles
    solving = 0.0
    for jobs in (1, 2):
        runs = [timed_run(sweep, everything, jobs) for _ in range(REPEATS)]
        solving = print_rate(f"continuation, {jobs} thread{'s'[: jobs > 1]}", runs)
    swarm = replace(sweep, seeding=Seeding.PSO)
    sample = np.random.default_rng(0).choice(sweep.column_count, SWARM_COLUMNS, replace=False).tolist()
    timed_run(swarm, sample[:1], 1)
    searches = [timed_run(swarm, sample, 2) for _ in range(SWARM_REPEATS)]
    print_rate(f"--seeding pso, {SWARM_COLUMNS} columns, 2 th.", searches)
    print_shares(columns)
    print_agreement(searches[0].columns, columns)
    files = min((time_file(request, steps, columns) for _ in range(REPEATS)), key=lambda times: times.writing)
    print(
        f"file: checkpoint {files.checkpoint:.3f} s + table {files.table:.3f} s = {files.writing / solving:.2f} "
        f"of the solving on 2 threads; certificate and swarm check {files.certify:.3f} s"
    )


if __name__ == "__main__":
    main()
