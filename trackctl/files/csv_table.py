"""CSV tables with a header: read as columns of text, converted to SI one at a time."""

from __future__ import annotations

import csv
import io
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from trackctl.errors import InputFileError
from trackctl.files.read_errors import read_errors
from trackctl.units import accepted_keys

Array = NDArray[np.float64]

STDIN = "-"
STDIN_LABEL = "<stdin>"
# Enough to make the calls cheap, and few enough to stay in the processor's cache.
ROWS_AT_ONCE = 256


@dataclass(frozen=True, slots=True, eq=False)
class CsvTable:
    """A table as it stands in its file.

    Attributes
    ----------
    file
        Where it comes from, for messages.
    columns
        Cells as text, by header, in file order.
    lines
        Line number of each row, from 1.
    """

    file: str
    columns: dict[str, list[str]]
    lines: list[int]


def read_csv(source: Path | str) -> CsvTable:
    """Read a table.

    Cells are parted by commas; where the header has none, by the semicolons or tabs that it has. Empty lines
    are skipped.

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
    rows = numbered_rows(file, read_text_bytes(source, file))
    line, header = next(rows, (1, []))
    names = checked_header(file, line, header)
    columns: list[list[str]] = [[] for _ in names]
    lines: list[int] = []
    while batch := list(islice(rows, ROWS_AT_ONCE)):
        for line, row in batch:
            if len(row) != len(names):
                raise InputFileError(file, f"has {len(row)} cells; the header has {len(names)}", line)
            lines.append(line)
        for column, cells in zip(columns, zip(*(row for _, row in batch), strict=True), strict=True):
            column.extend(cells)
    if not lines:
        raise InputFileError(file, "has a header but no rows")
    return CsvTable(file, dict(zip(names, columns, strict=True)), lines)


def column(table: CsvTable, key: str, *, may_be_empty: bool = False, may_be_infinite: bool = False) -> Array:
    """A column of numbers, in SI.

    Parameters
    ----------
    table
        The table.
    key
        Its header, for which one with another unit of the same quantity may stand.
    may_be_empty
        Whether empty and ``nan`` cells are allowed; they become NaN.
    may_be_infinite
        Whether ``inf`` and ``-inf`` are allowed.

    Returns
    -------
    ndarray, shape (n_rows,)

    Raises
    ------
    InputFileError
        If the column is missing, there twice in different units, in no unit of the quantity, or holds a cell
        that is not allowed.
    """
    header = find_header(table, key)
    if header is None:
        raise InputFileError(
            table.file,
            f"column {' or '.join(accepted_keys(key))} is missing; there are: {', '.join(table.columns)}",
        )
    values = numbers(table, header)
    for refused, allowed in (
        (np.isnan(values) & (not may_be_empty), "a number"),
        (np.isinf(values) & (not may_be_infinite), "a finite number"),
    ):
        for row in np.flatnonzero(refused):
            raise cell_error(table, header, int(row), allowed)
    return values * accepted_keys(key)[header]


def find_header(table: CsvTable, key: str) -> str | None:
    """The header of a column that stands for a key in any of its units, or None; errors as of `column`."""
    accepted = accepted_keys(key)
    found = [header for header in table.columns if header in accepted]
    if len(found) > 1:
        raise InputFileError(table.file, f"columns {' and '.join(found)} mean the same; allowed: one of them")
    if found:
        return found[0]
    name = key.rpartition("_")[0] if len(accepted) > 1 else ""
    for header in table.columns:
        if name and name in (header, header.rpartition("_")[0]):
            raise InputFileError(table.file, f"column {header!r} has no unit of {name}; allowed: {', '.join(accepted)}")
    return None


def numbers(table: CsvTable, header: str) -> Array:
    """The numbers of a column in its own unit, NaN where a cell is empty."""
    cells = table.columns[header]
    if "_" in "".join(cells):  # which Python allows in numbers
        row = next(row for row, cell in enumerate(cells) if "_" in cell)
        raise cell_error(table, header, row, "a number")
    try:
        return np.fromiter(map(float, cells), np.float64, len(cells))
    except ValueError:
        return np.fromiter((number(table, header, row) for row in range(len(cells))), np.float64, len(cells))


def number(table: CsvTable, header: str, row: int) -> float:
    """The number in a cell, NaN if it is empty."""
    cell = table.columns[header][row]
    try:
        return float(cell) if cell.strip() else np.nan
    except ValueError:
        raise cell_error(table, header, row, "a number") from None


def cell_error(table: CsvTable, header: str, row: int, allowed: str) -> InputFileError:
    """The error of a cell that is not allowed."""
    cell = table.columns[header][row]
    problem = f"column {header}: {cell!r} is not allowed; allowed: {allowed}"
    return InputFileError(table.file, problem, table.lines[row])


def read_text_bytes(source: Path | str, file: str) -> bytes:
    """Content of a file or standard input, checked to be UTF-8 text."""
    with read_errors(file):
        content = sys.stdin.buffer.read() if str(source) == STDIN else Path(source).read_bytes()
    if b"\0" in content:
        raise InputFileError(file, "is binary or UTF-16; allowed: a CSV table in UTF-8")
    try:
        content.decode()
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputFileError(file, "is no UTF-8 text; allowed: a CSV table in UTF-8", line) from error
    return content


def numbered_rows(file: str, content: bytes) -> Iterator[tuple[int, list[str]]]:
    """The lines that are not empty, split into cells, each with its number."""
    first_line = re.split(rb"[\r\n]", content[: 2**16].lstrip(), maxsplit=1)[0]
    delimiter = next((mark for mark in ",;\t" if mark.encode() in first_line), ",")
    stream = io.TextIOWrapper(io.BytesIO(content), "utf-8-sig", newline="")
    reader = csv.reader(stream, delimiter=delimiter, strict=True)
    try:
        for row in reader:
            if row:
                yield reader.line_num, row
    except csv.Error as error:
        raise InputFileError(file, f"is no CSV: {error}", reader.line_num) from error


def checked_header(file: str, line: int, header: list[str]) -> list[str]:
    """The names in a header, without blanks around them."""
    names = [name.strip() for name in header]
    if not any(names):
        raise InputFileError(file, "is empty; allowed: a CSV table with a header", line)
    if all(is_number(name) for name in names):
        raise InputFileError(file, f"begins with numbers ({','.join(names)}); allowed: a header", line)
    for name in names:
        if names.count(name) > 1:
            raise InputFileError(file, f"column {name!r} is there twice; allowed: once", line)
    return names


def is_number(text: str) -> bool:
    """Whether a text is a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True
