"""Where a command's CSV table and its JSON summary go."""

from __future__ import annotations

import io
import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, cast

import typer

from trackctl.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from typing import TextIO

    from trackctl.files.csv_writer import Column

    Form = Callable[[TextIO, Mapping[str, Column]], None]

STDOUT = "-"


@dataclass(frozen=True, slots=True)
class CsvOutput:
    """What a user asked for by ``--output``, ``--force`` and ``--json``.

    The table goes to the output file, or else to standard output, which a summary takes for itself; as CSV, unless
    another `form` writes it.
    """

    output: Path | None
    force: bool
    as_json: bool
    form: Form | None = None

    def check(self) -> None:
        """Refuse an output that could not be written, before the work starts."""
        from trackctl.files.atomic import check_output

        if self.output is None:
            return
        if str(self.output) != STDOUT:
            check_output(self.output, self.force)
        elif self.as_json:
            raise UsageError("--output", STDOUT, "a file, as --json prints its summary on standard output")

    def write(self, columns: Mapping[str, Column], summary: Mapping[str, object]) -> None:
        """Write the table, and the summary if it was asked for."""
        if self.output is not None and str(self.output) != STDOUT:
            write_file(self.output, self.force, columns, self.form)
        elif not self.as_json:
            write_standard_output(columns, self.form)
        if self.as_json:
            typer.echo(json.dumps(summary))


def write_file(output: Path, force: bool, columns: Mapping[str, Column], form: Form | None = None) -> None:
    """Write a table to a file that appears whole or not at all."""
    from trackctl.files.atomic import whole_file
    from trackctl.files.csv_writer import write_csv

    with whole_file(output, force) as path, path.open("w", encoding="utf-8", newline="") as stream:
        (form or write_csv)(stream, columns)


def write_standard_output(columns: Mapping[str, Column], form: Form | None = None) -> None:
    """Write a table to standard output, with the line ends of files whatever the system's."""
    from trackctl.files.csv_writer import write_csv

    stream = cast(io.TextIOWrapper, sys.stdout)
    stream.reconfigure(newline="")
    (form or write_csv)(stream, columns)
