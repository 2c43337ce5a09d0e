"""Elevation grids in ESRI ASCII (`.asc`)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from trackctl.errors import MapError
from trackctl.files.height_grid import MAX_NODES, HeightGrid, check_size, known_heights
from trackctl.files.regular_file import read_bytes

Array = NDArray[np.float64]
Lines = list[tuple[int, str]]
Header = dict[str, tuple[int, float]]

#: Generous, to refuse what is none before it is read.
BYTES_PER_HEIGHT = 40
#: What ESRI takes where the file tells none.
DEFAULT_NODATA = -9999.0
KEYS = (
    "ncols", "nrows", "xllcorner", "xllcenter", "yllcorner", "yllcenter", "cellsize", "dx", "dy", "nodata_value",
)  # fmt: skip


def read_esri(path: Path) -> HeightGrid:
    """An elevation grid; keys in capitals or not, `dx` and `dy` in place of `cellsize` as GDAL writes them.

    Raises
    ------
    MapError
        If the file is none; names line, key, value and what is allowed.
    """
    try:
        text = read_bytes(path, BYTES_PER_HEIGHT * MAX_NODES).decode("ascii")
    except UnicodeDecodeError as error:
        raise MapError(path, f"is no text; allowed: an ESRI grid beginning with {KEYS[0]}") from error
    lines = [(number, line) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    header = _header(path, lines)
    n_columns, n_rows = _count(path, header, "ncols"), _count(path, header, "nrows")
    check_size(path, n_rows, n_columns)
    spacing = _length(path, header, "dx", "cellsize"), _length(path, header, "dy", "cellsize")
    corner = _corner(path, header, "x", spacing[0]), _corner(path, header, "y", spacing[1])
    values = _values(path, lines[len(header) :], n_rows * n_columns).reshape(n_rows, n_columns)
    nodata = header.get("nodata_value", (0, DEFAULT_NODATA))[1]
    return HeightGrid(known_heights(path, values, nodata), spacing, corner)


def _header(path: Path, lines: Lines) -> Header:
    """Line number and value of each key, in small letters, up to the first line that begins with a number."""
    header: Header = {}
    for line, text in lines:
        key, *values = text.lower().split()
        if _number(key) is not None:
            return header
        if key not in KEYS or key in header:
            raise MapError(path, f"{key[:40]!r} is unknown or there twice; allowed: {', '.join(KEYS)}", line, key)
        value = _number(values[0]) if len(values) == 1 else None
        if value is None or (np.isnan(value) and key != "nodata_value"):
            raise MapError(path, f"{key}: {' '.join(values)[:40]!r} is no number", line, key)
        header[key] = line, value
    return header


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _given(path: Path, header: Header, *keys: str) -> tuple[str, int, float]:
    """Key, line and value of the one of some keys that is there."""
    for key in keys:
        if key in header:
            return key, *header[key]
    raise MapError(path, f"missing key: {' or '.join(keys)}")


def _count(path: Path, header: Header, key: str) -> int:
    _, line, value = _given(path, header, key)
    if not 1.0 <= value <= MAX_NODES or value != int(value):
        raise MapError(path, f"{key}: {value:g} is not allowed; allowed: a whole number up to {MAX_NODES}", line, key)
    return int(value)


def _length(path: Path, header: Header, *keys: str) -> float:
    key, line, value = _given(path, header, *keys)
    if not 0.0 < value < np.inf:
        raise MapError(path, f"{key}: {value:g} is not allowed; allowed: above 0", line, key, value)
    return value


def _corner(path: Path, header: Header, axis: str, spacing: float) -> float:
    """Lower end of the grid along an axis."""
    key, line, value = _given(path, header, f"{axis}llcorner", f"{axis}llcenter")
    if not abs(value) < np.inf:
        raise MapError(path, f"{key}: {value:g} is not allowed; allowed: a finite number", line, key, value)
    return value if key.endswith("corner") else value - 0.5 * spacing


def _values(path: Path, lines: Lines, count: int) -> Array:
    """All heights in file order, however they are broken into lines."""
    parts = [np.empty(0)]
    for line, text in lines:
        try:
            parts.append(np.array(text.split(), np.float64))
        except ValueError as error:
            raise MapError(path, f"holds what is no number: {error}", line) from error
    values = np.concatenate(parts)
    if values.size != count:
        raise MapError(path, f"holds {values.size} heights; allowed: ncols times nrows, {count}")
    return values
