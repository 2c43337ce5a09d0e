"""Paths as waypoints in a CSV table, with or without speeds."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from trackctl.errors import InputFileError
from trackctl.files.csv_table import CsvTable, cell_error, column, find_header, read_csv

Array = NDArray[np.float64]

X, Y = "x_m", "y_m"
#: The speed's column, and its name in the tables of `plan`.
SPEEDS = ("speed_mps", "velocity_mps")

#: Closer than this two waypoints in a row are one. [m]
SAME_PLACE = 1e-6
LARGEST_COORDINATE = 1e8
LARGEST_SPEED = 100.0
#: A path that turns by more from one waypoint to the next is taken to go back. [rad]
LARGEST_TURN = np.radians(150.0)


@dataclass(frozen=True, slots=True, eq=False)
class Waypoints:
    """Points of a path in the order of travel, arrays of shape (n,), n >= 2.

    Attributes
    ----------
    file
        Where they come from.
    x, y
        No two in a row at one place. [m]
    speed
        At the points, above 0 but perhaps at the ends; None where the table does not say. [m/s]
    repeated
        How many points stood where the one before did, and were left out.
    """

    file: str
    x: Array
    y: Array
    speed: Array | None
    repeated: int


def read_waypoints(source: Path | str) -> Waypoints:
    """The waypoints of a table, ``-`` for standard input.

    Raises
    ------
    InputFileError
        If the table cannot be read, lacks a column, holds a cell that is not allowed, is at one place, or turns
        back on itself.
    """
    table = read_csv(source)
    x, y = (coordinate(table, key) for key in (X, Y))
    speed = speeds(table)
    kept = apart(x, y)
    if kept.size < 2:
        raise InputFileError(table.file, f"has {len(table.lines)} waypoints at one place; allowed: 2 or more apart")
    check_turns(table, x[kept], y[kept], kept)
    kept_speed = None if speed is None else speed[kept]
    return Waypoints(table.file, x[kept], y[kept], kept_speed, x.size - kept.size)


def coordinate(table: CsvTable, key: str) -> Array:
    """A column of coordinates. [m]"""
    values = column(table, key)
    for row in np.flatnonzero(np.abs(values) > LARGEST_COORDINATE):
        allowed = f"-{LARGEST_COORDINATE:g} to {LARGEST_COORDINATE:g} m"
        raise cell_error(table, str(find_header(table, key)), int(row), allowed)
    return values


def speeds(table: CsvTable) -> Array | None:
    """The speeds, if there are any. [m/s]"""
    for key in SPEEDS:
        header = find_header(table, key)
        if header is None:
            continue
        values = column(table, key)
        inner = np.arange(values.size)[1:-1]
        for rows, refused, allowed in (
            (slice(None), (values < 0.0) | (values > LARGEST_SPEED), f"0 to {LARGEST_SPEED:g} m/s, forward only"),
            (inner, values[inner] == 0.0, "above 0 between the first and the last row"),
        ):
            for row in np.arange(values.size)[rows][refused]:
                raise cell_error(table, header, int(row), allowed)
        return values
    return None


def apart(x: Array, y: Array) -> NDArray[np.intp]:
    """Indices of the points that are not where the last such one is."""
    if (np.hypot(np.diff(x), np.diff(y)) > SAME_PLACE).all():
        return np.arange(x.size)
    kept = [0]
    for k in range(1, x.size):
        if np.hypot(x[k] - x[kept[-1]], y[k] - y[kept[-1]]) > SAME_PLACE:
            kept.append(k)
    return np.array(kept)


def check_turns(table: CsvTable, x: Array, y: Array, rows: NDArray[np.intp]) -> None:
    """Refuse points at which the path goes back: a cusp, or points out of order."""
    chords = np.diff(x + 1j * y)
    turns = np.abs(np.angle(chords[1:] * chords[:-1].conj()))
    for k in np.flatnonzero(turns > LARGEST_TURN):
        raise InputFileError(
            table.file,
            f"the path turns back here, by {np.degrees(turns[k]):.0f} deg; allowed: waypoints in order of travel "
            f"that turn by up to {np.degrees(LARGEST_TURN):.0f} deg, no cusps",
            table.lines[rows[k + 1]],
        )
