"""A command's CSV table that grows row by row."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TextIO, cast

from trackctl.cli.csv_output import STDOUT, CsvOutput

if TYPE_CHECKING:
    from collections.abc import Mapping

    from trackctl.files.csv_writer import Column


@contextmanager
def csv_stream(destination: CsvOutput) -> Iterator[Callable[[Mapping[str, Column]], None]]:
    """What takes batches of rows and writes them at once; a file appears only when the block ends well."""
    from trackctl.files.atomic import whole_file

    output = destination.output
    if output is not None and str(output) != STDOUT:
        with (
            whole_file(output, destination.force) as path,
            path.open("w", encoding="utf-8", newline="") as stream,
        ):
            yield appender(stream)
    elif destination.as_json:
        yield lambda columns: None
    else:
        standard = cast(io.TextIOWrapper, sys.stdout)
        standard.reconfigure(newline="")
        yield appender(standard)


def appender(stream: TextIO) -> Callable[[Mapping[str, Column]], None]:
    """What writes the header before its first batch."""
    from trackctl.files.csv_writer import write_header, write_rows

    started = False

    def append(columns: Mapping[str, Column]) -> None:
        nonlocal started
        if not started:
            write_header(stream, columns)
            started = True
        write_rows(stream, columns)
        stream.flush()

    return append
