"""A Dask cluster as the crew that solves a table; the only module that knows Dask."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Any

from trackctl.errors import MissingLibraryError, UsageError, WorkerError
from trackctl.lut.crew import Crew

INSTALL = "pip install 'trackctl[cluster]'"
#: How long a scheduler may take to answer. [s]
CONNECT_TIMEOUT = 5.0
#: How long a run goes on without any worker. [s]
WORKERLESS_TIMEOUT = 300.0
#: How often the scheduler is asked for its workers. [s]
REFRESH = 1.0
#: Where Dask and what it stands on report; those named beside their parent have a level of their own.
LOGGERS = ("distributed", "distributed.client", "distributed.gc", "tornado", "tornado.application", "asyncio")


class Roster:
    """How many threads the workers of a scheduler have; they may come and go.

    Parameters
    ----------
    address
        Of the scheduler, for messages.
    count
        Asks the scheduler.
    tell
        Told when there is no worker.
    """

    def __init__(self, address: str, count: Callable[[], int], tell: Callable[[str], None]) -> None:
        self._address = address
        self._count = count
        self._tell = tell
        self._size = 1
        self._asked = float("-inf")
        self._seen = time.monotonic()

    def __call__(self) -> int:
        """The number of threads, at most `REFRESH` old.

        Raises
        ------
        WorkerError
            If there has been none for `WORKERLESS_TIMEOUT`.
        """
        now = time.monotonic()
        if now - self._asked >= REFRESH:
            before, self._size, self._asked = self._size, self._count(), now
            if self._size:
                self._seen = now
            elif before:
                self._tell(f"no worker at {self._address}; waiting up to {WORKERLESS_TIMEOUT:g} s for one")
        if now - self._seen > WORKERLESS_TIMEOUT:
            raise WorkerError(f"no worker at {self._address} for {WORKERLESS_TIMEOUT:g} s; start one: dask worker")
        return self._size


def workers_of(scheduler: str | None, tell: Callable[[str], None]) -> AbstractContextManager[Crew | None]:
    """The workers of a Dask scheduler, see `cluster`; None without one."""
    return nullcontext() if scheduler is None else cluster(scheduler, tell)


@contextmanager
def cluster(address: str, tell: Callable[[str], None]) -> Iterator[Crew]:
    """The workers of a Dask scheduler.

    Parameters
    ----------
    address
        Of the scheduler: ``[tcp://]HOST:PORT``.
    tell
        Told when there is no worker.

    Raises
    ------
    MissingLibraryError
        If Dask is not installed.
    UsageError
        If no scheduler answers there.
    """
    try:
        from distributed import Client, KilledWorker
    except ModuleNotFoundError as error:
        raise MissingLibraryError("distributed", "--scheduler", INSTALL) from error

    with silence(LOGGERS):
        refuse_strangers(address)
        with Client(address, timeout=CONNECT_TIMEOUT, set_as_default=False) as client:
            roster = Roster(address, lambda: threads_of(client), tell)
            # Import and attribute errors, also wrapped, are those of machines without this trackctl.
            failures = (KilledWorker, RuntimeError, ImportError, AttributeError)
            yield Crew(client.get_executor(pure=False), roster, failures)


@contextmanager
def silence(names: Iterable[str]) -> Iterator[None]:
    """Let loggers say nothing for a while: what becomes of a run is told in our words, once.

    A run that is stopped or loses its scheduler leaves callbacks behind that log tracebacks of their own.
    """
    levels = {logger: logger.level for logger in map(logging.getLogger, names)}
    for logger in levels:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in levels.items():
            logger.setLevel(level)


def refuse_strangers(address: str) -> None:
    """Raise a `UsageError` unless a scheduler answers at the address; the client itself may wait for ever."""
    allowed = "the address of a running Dask scheduler, [tcp://]HOST:PORT"
    try:
        found = asyncio.run(asyncio.wait_for(identity(address), 1.2 * CONNECT_TIMEOUT))
    except (OSError, ValueError, TimeoutError) as error:
        raise UsageError("--scheduler", repr(address), f"{allowed} ({error})") from error
    if found["type"] != "Scheduler":
        raise UsageError("--scheduler", repr(address), f"{allowed}, no {found['type']}")


async def identity(address: str) -> Any:
    """What a Dask server says of itself."""
    from distributed.core import rpc

    async with rpc(address, timeout=CONNECT_TIMEOUT) as server:
        return await server.identity()


def threads_of(client: Any) -> int:
    """Number of threads that the workers have, 0 if the scheduler is lost, too."""
    try:
        return sum(client.nthreads().values())
    except (OSError, ValueError, RuntimeError):
        return 0
