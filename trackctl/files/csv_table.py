"""CSV tables with a header: columns of raw text read, converted to SI one at a time, and written."""

from __future__ import annotations

import csv
import io
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from trackctl.errors import InputFileError
from trackctl.units import accepted_keys, split_suffix

Array = NDArray[np.float64]
#: What a column to be written may be.
Column = NDArray[np.generic] | Sequence[str]

STDIN = "-"
STDIN_LABEL = "<stdin>"
DELIMITERS = ",;\t"
ROWS_PER_WRITE = 2**16


@dataclass(frozen=True, slots=True, eq=False)
class CsvTable:
    """A table as it stands in its file.

    Attributes
    ----------
    file
        Where it comes from, for messages.
    columns
        Text of all cells by header, in file order.
    lines
        Line number of each row, from 1.
    """

    file: str
    columns: dict[str, tuple[str, ...]]
    lines: tuple[int, ...]


def read_csv(source: Path | str) -> CsvTable:
    """Read a table.

    The delimiter is a comma, or else a semicolon or tab if the header has one of these instead. Empty lines are
    skipped; nothing is a comment.

    Parameters
    ----------
    source
        A file, or ``-`` for standard input.

    Raises
    ------
    InputFileError
        If the file cannot be read, is no UTF-8 text, has no header or no rows, names a column twice, or has a
        row of another length than its header.
    """
    file = STDIN_LABEL if str(source) == STDIN else str(source)
    text = read_text(source, file)
    lines, rows = [], []
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter_of(text), strict=True)
    try:
        for row in reader:
            if row:
                rows.append(row)
                lines.append(reader.line_num)
    except csv.Error as error:
        raise InputFileError(file, f"is no valid CSV: {error}", reader.line_num) from error
    if not rows:
        raise InputFileError(file, "is empty; a header line and rows are needed")
    header = checked_header(file, rows[0], lines[0])
    if len(rows) == 1:
        raise InputFileError(file, "holds a header but no rows")
    for row, line in zip(rows, lines, strict=True) if set(map(len, rows)) != {len(header)} else ():
        if len(row) != len(header):
            raise InputFileError(file, f"{len(row)} cells; the header has {len(header)}", line)
    return CsvTable(file, dict(zip(header, zip(*rows[1:], strict=True), strict=True)), tuple(lines[1:]))
