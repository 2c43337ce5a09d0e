"""Who solves the columns of a table: threads, or any executor, on this machine or on others."""

from __future__ import annotations

import functools
import platform
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice

from trackctl import __version__
from trackctl.compiled import kernel_folder
from trackctl.errors import WorkerError
from trackctl.lut.cells import Cells
from trackctl.lut.sweep import Sweep, solve

#: Columns handed out ahead of those that are done, per worker: keeps memory constant and workers busy.
AHEAD = 4
#: How often the size of a crew is asked for while no column gets done. [s]
PATROL = 1.0


@dataclass(frozen=True, slots=True)
class Crew:
    """Who solves the columns of a table.

    Attributes
    ----------
    executor
        Of threads, processes or machines; only its `submit` is used.
    size
        How many columns it solves at a time, which may change while it works. It may raise a `WorkerError`.
    failures
        Errors of its own that tell of workers, not of the work.
    """

    executor: Executor
    size: Callable[[], int]
    failures: tuple[type[Exception], ...] = ()


@contextmanager
def threads(jobs: int) -> Iterator[Crew]:
    """A crew of threads of this process."""
    with ThreadPoolExecutor(jobs) as pool:
        yield Crew(pool, lambda: jobs)


@functools.cache
def build() -> str:
    """What must be the same for the same bytes to come out: version, kernels and numba."""
    return f"trackctl {__version__} ({kernel_folder().name})"


def solve_for(asking: str, sweep: Sweep, column: int) -> Cells:
    """Cells of one column for a run of another process, which must be of the same build.

    Raises
    ------
    WorkerError
        If it is not.
    """
    if asking != build():
        problem = f"runs {build()}, this is {asking}; install the same trackctl and numba on all machines"
        raise WorkerError(f"the worker on {platform.node()} {problem}")
    return solve(sweep, column)


def solve_columns(sweep: Sweep, columns: Iterable[int], crew: Crew) -> Generator[tuple[int, Cells]]:
    """Columns as they get done, with their cells; few are under way at a time, whatever their number.

    Raises
    ------
    WorkerError
        If the crew fails; the columns before have come.
    """
    waiting = iter(columns)
    running: dict[Future[Cells], int] = {}
    try:
        while True:
            room = AHEAD * max(crew.size(), 1) - len(running)
            for column in islice(waiting, max(room, 0)):
                with worker_errors(RuntimeError):
                    running[crew.executor.submit(solve_for, build(), sweep, column)] = column
            if not running:
                return
            done, _ = wait(running, PATROL, FIRST_COMPLETED)
            for future in sorted(done, key=running.__getitem__):
                with worker_errors(BrokenExecutor, CancelledError, *crew.failures):
                    cells = future.result()
                yield running.pop(future), cells
    finally:
        for future in running:
            future.cancel()


@contextmanager
def worker_errors(*failures: type[Exception]) -> Iterator[None]:
    """Turn failures of a crew into a `WorkerError`."""
    try:
        yield
    except failures as error:
        reason = str(error).partition("\n")[0]
        raise WorkerError(f"the workers failed: {type(error).__name__}{reason and f': {reason}'}") from error
