"""Logs as CSV, read in blocks as they come, also from a pipe that goes on."""

from __future__ import annotations

import csv
import math
import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import BufferedReader
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from trackctl.errors import InputFileError
from trackctl.files.csv_table import STDIN, STDIN_LABEL, CsvTable, checked_header, find_header
from trackctl.files.read_errors import read_errors
from trackctl.units import accepted_keys

Array = NDArray[np.float64]

# Enough to make the calls cheap, and few enough to stay in the processor's cache.
BLOCK_BYTES = 1 << 15
LONGEST_LINE = 1 << 20


@dataclass(frozen=True, slots=True)
class Source:
    """A column to be read: the keys that may stand for it, each with its factor to the quantity wanted.

    One that is optional is NaN where it is missing.
    """

    keys: tuple[tuple[str, float], ...]
    optional: bool = False


def log_sources(sprocket_radius: float) -> tuple[Source, ...]:
    """Time, track speeds, position and yaw, in the order of a filter's rows; rates times the radius [m] are speeds."""
    speeds = (
        Source(((f"track_speed_{side}_mps", 1.0), (f"sprocket_rate_{side}_radps", sprocket_radius)))
        for side in ("left", "right")
    )
    return (Source((("time_s", 1.0),)), *speeds, *(Source(((key, 1.0),)) for key in ("x_m", "y_m", "yaw_rad")))


def read_blocks(source: Path | str, sources: Sequence[Source]) -> Iterator[Array]:
    """Blocks of a log's rows, in SI, as soon as they can be read.

    Parameters
    ----------
    source
        A file, or ``-`` for standard input.
    sources
        The columns wanted; others are ignored.

    Yields
    ------
    ndarray, shape (n_rows, n_sources)
        NaN where a cell is empty.

    Raises
    ------
    InputFileError
        If the log cannot be read, is no UTF-8 text, has no rows, lacks a column or names one twice, has a row of
        another length than its header, or a cell that is no number; rows before it have been yielded then.
    """
    file = STDIN_LABEL if str(source) == STDIN else str(source)
    table, rows = None, 0
    for line, lines in numbered_lines(source, file):
        if table is None:
            header, lines, line = split_header(lines, line)
            if header is None:
                continue
            table = Columns.of(file, header, line - 1, sources)
        block = table.block(lines, line)
        rows += len(block)
        if len(block):
            yield block
    if table is None:
        raise InputFileError(file, "is empty; allowed: a CSV table with a header")
    if not rows:
        raise InputFileError(file, "has a header but no rows")


def split_header(lines: list[str], line: int) -> tuple[str | None, list[str], int]:
    """The first line that is not empty, those after it, and the number of the first of these."""
    for index, text in enumerate(lines):
        if text.strip():
            return text, lines[index + 1 :], line + index + 1
    return None, [], line + len(lines)


@dataclass(frozen=True, slots=True)
class Columns:
    """Where the wanted columns stand in a table's rows."""

    file: str
    delimiter: str
    width: int
    headers: tuple[str, ...]
    places: tuple[int | None, ...]
    factors: Array

    @staticmethod
    def of(file: str, header: str, line: int, sources: Sequence[Source]) -> Columns:
        """The columns that a header has for the sources."""
        delimiter = next((mark for mark in ",;\t" if mark in header), ",")
        names = checked_header(file, line, next(csv.reader([header], delimiter=delimiter)))
        table = CsvTable(file, {name: [] for name in names}, [])
        found = [column_of(table, source) for source in sources]
        headers = tuple(header for header, _ in found)
        factors = np.array([factor for _, factor in found])
        places = tuple(names.index(header) if header else None for header in headers)
        return Columns(file, delimiter, len(names), headers, places, factors)

    def block(self, lines: list[str], line: int) -> Array:
        """The numbers in lines, of which the first has this number."""
        try:
            rows = [row for row in csv.reader(lines, delimiter=self.delimiter, strict=True) if row]
        except csv.Error as error:
            raise InputFileError(self.file, f"is no CSV: {error}", line) from error
        if set(map(len, rows)) - {self.width}:
            self.refuse_lengths(lines, line)
        if not rows:
            return np.empty((0, len(self.places)))
        values = np.full((len(rows), len(self.places)), math.nan)
        cells = list(zip(*rows, strict=True))
        plain = "_" not in "".join(lines)  # which Python allows in numbers
        for k, place in enumerate(self.places):
            if place is None:
                continue
            quick = quick_numbers(cells[place]) if plain else None
            values[:, k] = quick or [self.number(cell, k, lines, line, row) for row, cell in enumerate(cells[place])]
        return values * self.factors

    def number(self, cell: str, column: int, lines: list[str], line: int, row: int) -> float:
        """The number in a cell, NaN if it is blank."""
        try:
            return float("" if "_" in cell else cell) if cell.strip() else math.nan
        except ValueError:
            problem = f"column {self.headers[column]}: {cell!r} is not allowed; allowed: a number, or nothing"
            at = [number for number, text in enumerate(lines, line) if text][row]
            raise InputFileError(self.file, problem, at) from None

    def refuse_lengths(self, lines: list[str], line: int) -> None:
        """Raise an error on the first row whose length differs from the header's."""
        for at, row in enumerate(csv.reader(lines, delimiter=self.delimiter), line):
            if row and len(row) != self.width:
                raise InputFileError(self.file, f"has {len(row)} cells; the header has {self.width}", at)


def quick_numbers(cells: Sequence[str]) -> list[float] | None:
    """The numbers in cells, NaN where they are empty, or None if one is no number."""
    try:
        return [float(cell) if cell else math.nan for cell in cells]
    except ValueError:
        return None


def column_of(table: CsvTable, source: Source) -> tuple[str, float]:
    """The header that stands for a source, empty if there is none, and its factor."""
    found = [(key, factor, find_header(table, key)) for key, factor in source.keys]
    present = [(header, factor * accepted_keys(key)[header]) for key, factor, header in found if header]
    if len(present) == 1:
        return present[0]
    if present:
        names = " and ".join(header for header, _ in present)
        raise InputFileError(table.file, f"columns {names} mean the same; allowed: one of them")
    if source.optional:
        return "", 1.0
    wanted = " or ".join(name for key, _ in source.keys for name in accepted_keys(key))
    raise InputFileError(table.file, f"column {wanted} is missing; there are: {', '.join(table.columns)}")


def numbered_lines(source: Path | str, file: str) -> Iterator[tuple[int, list[str]]]:
    """Whole lines as they come, without their ends, and the number of the first."""
    line, rest = 1, b""
    for chunk in chunks(source, file):
        content = rest + chunk
        # A carriage return at the end may be half a line end.
        cut = max(content.rfind(b"\n"), content.rfind(b"\r", 0, -1)) + 1
        content, rest = content[:cut], content[cut:]
        if len(rest) > LONGEST_LINE:
            raise InputFileError(file, f"has a line longer than {LONGEST_LINE} bytes; allowed: a CSV table", line)
        if content:
            lines = text_of(content, file, line).split("\n")[:-1]
            yield line, lines
            line += len(lines)
    if rest:
        yield line, text_of(rest, file, line).rstrip("\n").split("\n")


def text_of(content: bytes, file: str, line: int) -> str:
    """Text of whole lines, each ended by a line feed."""
    if b"\0" in content:
        raise InputFileError(file, "is binary or UTF-16; allowed: a CSV table in UTF-8", line)
    try:
        text = content.decode("utf-8-sig" if line == 1 else "utf-8")
    except UnicodeDecodeError as error:
        at = line + content.count(b"\n", 0, error.start)
        raise InputFileError(file, "is no UTF-8 text; allowed: a CSV table in UTF-8", at) from error
    return re.sub("\r\n?", "\n", text) if "\r" in text else text


def chunks(source: Path | str, file: str) -> Iterator[bytes]:
    """Bytes as they come."""
    with read_errors(file), opened(source) as stream:
        while chunk := stream.read1(BLOCK_BYTES):
            yield chunk


@contextmanager
def opened(source: Path | str) -> Iterator[BufferedReader]:
    """A file or standard input, which stays open."""
    if str(source) == STDIN:
        yield cast(BufferedReader, sys.stdin.buffer)
        return
    with Path(source).open("rb") as stream:
        yield stream
