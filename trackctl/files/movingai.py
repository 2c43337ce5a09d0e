"""Grid benchmarks of movingai.com (`type octile`)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from trackctl.errors import MapError
from trackctl.files.regular_file import read_bytes
from trackctl.planning.occupancy import FREE, OCCUPIED, UNKNOWN, GridFrame, Occupancy
from trackctl.planning.planning_map import MAX_CELLS, PlanningMap

#: The format knows no lengths. [m]
DEFAULT_RESOLUTION = 1.0
#: Ground, swamp, and what no one enters: out of bounds, trees, water.
PASSABLE, BARRED = b".GS", b"@OTW"
OCCUPANCY = np.full(256, UNKNOWN, np.int8)
OCCUPANCY[list(PASSABLE)], OCCUPANCY[list(BARRED)] = FREE, OCCUPIED
HEADER_LINES = 4
ALLOWED = "the lines `type octile`, `height N`, `width N`, `map`"


def read_movingai(path: Path) -> PlanningMap:
    """A map of one metre a cell, its lower left corner at (0, 0).

    Raises
    ------
    MapError
        If the file is none; names the line.
    """
    lines = read_bytes(path, 2 * MAX_CELLS).splitlines()
    n_rows, n_columns = _size(path, lines)
    rows = lines[HEADER_LINES:]
    while len(rows) > n_rows and not rows[-1].strip():
        rows.pop()
    if len(rows) != n_rows:
        raise MapError(path, f"has {len(rows)} rows; allowed: its height of {n_rows}")
    cells = np.stack([_row(path, line, row, n_columns) for line, row in enumerate(rows, start=HEADER_LINES + 1)])
    frame = GridFrame(n_rows, n_columns, DEFAULT_RESOLUTION, 0.0, 0.0)
    return PlanningMap(file=str(path), occupancy=Occupancy(cells[::-1], frame, str(path)))


def _size(path: Path, lines: list[bytes]) -> tuple[int, int]:
    """Height and width by the header."""
    header = [line.decode("latin-1").split() for line in lines[:HEADER_LINES]]
    names = [words[0] if words else "" for words in header]
    if names != ["type", "height", "width", "map"] or header[0] != ["type", "octile"]:
        raise MapError(path, f"is no MovingAI map; allowed: {ALLOWED}", 1)
    height, width = (_count(path, line, header[line - 1]) for line in (2, 3))
    if height * width > MAX_CELLS:
        raise MapError(path, f"has {width} x {height} cells; allowed: up to {MAX_CELLS}")
    return height, width


def _count(path: Path, line: int, words: list[str]) -> int:
    digits = words[1] if len(words) == 2 else ""
    if not (digits.isascii() and digits.isdigit() and len(digits) < 10 and int(digits) > 0):
        raise MapError(path, f"{' '.join(words)} is not allowed; allowed: {words[0]} and a number from 1", line)
    return int(digits)


def _row(path: Path, line: int, row: bytes, n_columns: int) -> NDArray[np.int8]:
    """Occupancy of a row."""
    if len(row) != n_columns:
        raise MapError(path, f"has {len(row)} cells; allowed: the width of {n_columns}", line)
    cells = OCCUPANCY[np.frombuffer(row, np.uint8)]
    if cells.min() == UNKNOWN:
        column = int(cells.argmin())
        allowed = " ".join((PASSABLE + BARRED).decode())
        raise MapError(path, f"{chr(row[column])!r} in column {column + 1} is no cell; allowed: {allowed}", line)
    return cells
