"""CSV tables with a header, written."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

#: Numbers (NaN becomes an empty cell), truth values (become 0 and 1), or text as it is.
Column = NDArray[np.float64] | NDArray[np.integer] | NDArray[np.bool_] | Sequence[str]

# Enough to make the calls cheap, and few enough to stay in the processor's cache.
ROWS_AT_ONCE = 256


def write_csv(stream: TextIO, columns: Mapping[str, Column]) -> None:
    """Write a header and columns.

    Numbers have the fewest digits that bring them back to the last bit.

    Parameters
    ----------
    stream
        Where to, opened with ``newline=""`` if it is a file.
    columns : mapping of columns, shape (n_rows,)
        By header.
    """
    write_header(stream, columns)
    write_rows(stream, columns)


def write_header(stream: TextIO, columns: Iterable[str]) -> None:
    """Write the first line alone, for rows that come bit by bit."""
    csv.writer(stream, lineterminator="\n").writerow(columns)


def write_rows(stream: TextIO, columns: Mapping[str, Column]) -> None:
    """Write columns without their header; see `write_csv`."""
    writer = csv.writer(stream, lineterminator="\n")
    count = max(map(len, columns.values()), default=0)
    for start in range(0, count, ROWS_AT_ONCE):
        batch = [cells(column[start : start + ROWS_AT_ONCE]) for column in columns.values()]
        writer.writerows(zip(*batch, strict=True))


def cells(part: Column) -> Sequence[object]:
    """A part of a column in types that `csv` writes well."""
    if not isinstance(part, np.ndarray):
        return part
    values: list[object] = (part.astype(np.int8) if part.dtype.kind == "b" else part).tolist()
    for row in np.flatnonzero(np.isnan(part)):
        values[row] = None
    return values
