"""Operating points as rows of a CSV table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trackctl.errors import InputFileError
from trackctl.files.csv_table import CsvTable, cell_error, column, find_header
from trackctl.lut.axes import Array

VELOCITY, RADIUS, CURVATURE, HEADING, SLOPE = (
    "velocity_mps",
    "radius_m",
    "curvature_1pm",
    "heading_rad",
    "slope_rad",
)


@dataclass(frozen=True, slots=True, eq=False)
class OperatingPoints:
    """What a vehicle is asked to do, arrays of shape (n_points,).

    Attributes
    ----------
    velocity
        Of the mass centre, positive. [m/s]
    curvature
        Yaw rate over speed, left positive; may be infinite. [1/m]
    heading
        From the up-slope direction to the body's x axis, counter-clockwise. [rad]
    slope
        None where the points do not say. [rad]
    """

    velocity: Array
    curvature: Array
    heading: Array
    slope: Array | None = None


def curvature_of(radius: Array) -> Array:
    """Curvature of turn radii, negative to the right; 0 for an infinite one, infinite for 0. [1/m]"""
    with np.errstate(divide="ignore", over="ignore"):
        return np.asarray(1.0 / radius) + 0.0  # no negative zero


def read_points(table: CsvTable) -> OperatingPoints:
    """The operating points of a table's rows.

    Raises
    ------
    InputFileError
        If a column is missing or there twice, or holds a cell that is not allowed.
    """
    velocity = column(table, VELOCITY)
    for row in np.flatnonzero(velocity <= 0.0):
        raise cell_error(table, str(find_header(table, VELOCITY)), int(row), "above 0")
    has_slope = find_header(table, SLOPE) is not None
    return OperatingPoints(
        velocity, read_curvature(table), column(table, HEADING), column(table, SLOPE) if has_slope else None
    )


def read_curvature(table: CsvTable) -> Array:
    """Curvature of each row, from its column or from the radius."""
    radius, curvature = find_header(table, RADIUS), find_header(table, CURVATURE)
    if radius and curvature:
        raise InputFileError(table.file, f"columns {radius} and {curvature} mean the same; allowed: one of them")
    if curvature:
        return column(table, CURVATURE)
    if radius:
        return curvature_of(column(table, RADIUS, may_be_infinite=True))
    raise InputFileError(
        table.file, f"column {RADIUS} or {CURVATURE} is missing; there are: {', '.join(table.columns)}"
    )
