"""Words and progress bars on standard error."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import typer


def say(text: str, quiet: bool) -> None:
    """A line on standard error, unless quiet."""
    if not quiet:
        typer.echo(text, err=True)


@contextmanager
def bar(what: str, unit: str, quiet: bool) -> Iterator[Callable[[int, int], None]]:
    """A progress bar that is told (done, total); it appears only on a terminal."""
    from tqdm import tqdm

    hidden = quiet or not sys.stderr.isatty()
    with tqdm(desc=what, unit=unit, disable=hidden, leave=False) as shown:

        def progress(done: int, total: int) -> None:
            shown.total = total
            shown.update(done - shown.n)

        yield progress
