"""`export`: a look-up table as C source, MATLAB file or NumPy archive."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from trackctl import __version__
from trackctl.errors import NoAnswerError, UsageError
from trackctl.export.array_files import write_mat, write_npz
from trackctl.export.c_source import LONGEST_PREFIX, CTarget, c_source, is_prefix
from trackctl.export.gridded import gridded
from trackctl.files.atomic import check_output, whole_files
from trackctl.files.lut_reader import read_lut
from trackctl.files.profile_yaml import terrain_to_yaml, vehicle_to_yaml
from trackctl.lut.axes import Array
from trackctl.lut.table import Status, Table
from trackctl.workflows.export_options import CMethod, ExportFormat, Precision

#: Compilers take long over the constants of more cells.
MANY_CELLS = 1_000_000
ALL_SUFFIXES = tuple(suffix for kind in ExportFormat for suffix in kind.suffixes)
#: File names that `#include "..."` takes everywhere.
INCLUDABLE = re.compile(r"[A-Za-z0-9_+.\-][A-Za-z0-9_+. \-]*")

README = """\
Sprocket commands of a tracked vehicle on a slope. The arrays are over velocity [m/s], curvature [1/m, positive to the \
left], heading [rad, from up-slope to the body's x axis, counter-clockwise] and slope [rad], in this order. Headings \
that go round are closed: the last node repeats the first. Cells without an answer are NaN (not the residual), \
feasible is false and status says why: the number of a word in status_meanings, from 0. To interpolate as \
`trackctl lookup --method linear`: rate = speed_ratio * velocity / sprocket_radius; rates above max_sprocket_rate are \
beyond the actuators. No stencil should reach across curvature 0, where the sideslip bends.
"""


@dataclass(frozen=True, slots=True)
class ExportRequest:
    """What to export, and how.

    Attributes
    ----------
    lut
        The table's file.
    output
        File to write, None for one beside the table; of the two files of C either.
    kind
        None to go by the suffix of the output.
    precision, method, prefix
        Of C; a prefix of None is the name of the output.
    force
        Whether existing files may be replaced.
    """

    lut: Path
    output: Path | None = None
    kind: ExportFormat | None = None
    precision: Precision = Precision.DOUBLE
    method: CMethod = CMethod.LINEAR
    prefix: str | None = None
    force: bool = False


@dataclass(frozen=True, slots=True)
class ExportResult:
    """What was written.

    Attributes
    ----------
    kind
        Its format.
    files
        In which files.
    cells
        Of the table, or nodes of the arrays, mirrored and repeated ones counted.
    size
        Of the constant data of C, or of the file. [bytes]
    notes
        What a user should know.
    """

    kind: ExportFormat
    files: tuple[Path, ...]
    cells: int
    size: int
    notes: tuple[str, ...] = ()


def export_table(request: ExportRequest) -> ExportResult:
    """Export a table; its files appear whole, all or none.

    Raises
    ------
    UsageError
        If output, format, prefix or precision do not suit.
    OutputError
        If a file cannot be written.
    LutFormatError
        If the file is no table.
    NoAnswerError
        If no cell of the table has an answer.
    """
    kind, output = destination(request)
    files = tuple(output.with_suffix(suffix) for suffix in kind.suffixes)
    prefix = checked_prefix(request, output) if kind is ExportFormat.C else ""
    for file in files:
        check_output(file, request.force)
    table = read_lut(request.lut)
    if not (table.status == Status.CONVERGED).any():
        raise NoAnswerError(f"{request.lut}: no cell of the table has an answer")
    if kind is ExportFormat.C:
        return export_c(table, files, prefix, request)
    return export_arrays(table, kind, files, request)


def destination(request: ExportRequest) -> tuple[ExportFormat, Path]:
    """Format and file of an export, either of which tells the other."""
    kind, output = request.kind, request.output
    if output is None:
        if kind is None:
            raise UsageError("--format", None, f"one of {', '.join(ExportFormat)}, or --output FILE")
        return kind, request.lut.with_suffix(kind.suffixes[0])
    allowed = ALL_SUFFIXES if kind is None else kind.suffixes
    if output.suffix not in allowed:
        beside = "" if kind is None else f" beside --format {kind.value}"
        raise UsageError("--output", output, f"a file that ends in {', '.join(allowed)}{beside}")
    return next(each for each in ExportFormat if output.suffix in each.suffixes), output


def checked_prefix(request: ExportRequest, output: Path) -> str:
    """The prefix asked for, or the name of the output."""
    if not INCLUDABLE.fullmatch(output.stem):
        raise UsageError("--output", output, "a name of letters, digits, spaces and . _ + -, as C is to include it")
    if request.prefix is None and is_prefix(output.stem):
        return output.stem
    prefix, allowed = request.prefix, f"a letter, then letters, digits and _, at most {LONGEST_PREFIX} in all"
    if prefix is None:
        raise UsageError("--prefix", None, f"{allowed}, as the name of {output.name} is no such")
    if not is_prefix(prefix):
        raise UsageError("--prefix", prefix, allowed)
    return prefix


def export_c(table: Table, files: tuple[Path, ...], prefix: str, request: ExportRequest) -> ExportResult:
    """Write header and source."""
    target = CTarget(request.precision, prefix, files[0].name, request.method)
    try:
        found = c_source(table, target, c_description(table))
    except ValueError as error:
        raise UsageError("--precision", request.precision, f"double, as {error}") from error
    with whole_files(files, request.force) as paths:
        for path, text in zip(paths, (found.header, found.source), strict=True):
            path.write_text(text, encoding="ascii", newline="\n")
    cells = table.axes.size
    notes = (f"compilers take long over the constants of {cells} cells",) if cells > MANY_CELLS else ()
    return ExportResult(ExportFormat.C, files, cells, found.size, notes)


def c_description(table: Table) -> dict[str, str]:
    """What the header says of a table."""
    axes = table.axes
    shape = " x ".join(map(str, axes.shape))
    turns = "both turns" if not table.stores_left_turns_only else "left turns, right ones mirrored"
    if table.stores_left_turns_only and table.vehicle.cog_left != 0.0:
        turns = "left turns only"
    around = "full circle" if axes.heading_is_periodic else spread(axes.heading, "rad")
    return {
        "vehicle": f"{table.vehicle.name}: {table.vehicle.description}",
        "terrain": f"{table.terrain.name}: {table.terrain.description}",
        "gravity": f"{table.gravity:g} m/s2",
        "table": str(table.attributes.get("history", "")),
        "cells": f"{axes.size} ({shape}: slope, velocity, curvature, heading)",
        "ranges": f"slope {spread(axes.slope, 'rad')}, velocity {spread(axes.velocity, 'm/s')}, "
        f"curvature {spread(axes.curvature, '1/m')} ({turns}), heading {around}",
    }


def spread(nodes: Array, unit: str) -> str:
    """Ends of an axis."""
    low, high = float(nodes[0]), float(nodes[-1])
    return f"{low:g} {unit}" if low == high else f"{low:g} to {high:g} {unit}"


def export_arrays(table: Table, kind: ExportFormat, files: tuple[Path, ...], request: ExportRequest) -> ExportResult:
    """Write a MATLAB file or a NumPy archive."""
    arrays, write = gridded(table), write_mat if kind is ExportFormat.MAT else write_npz
    vehicle = table.vehicle
    numbers = {
        "track_gauge": vehicle.track_gauge,
        "sprocket_radius": vehicle.sprocket_radius,
        "max_sprocket_rate": vehicle.max_sprocket_rate,
        "gravity": table.gravity,
    }
    texts = {
        "title": f"{vehicle.name} on {table.terrain.name}, exported by trackctl {__version__}",
        "readme": README,
        "history": str(table.attributes.get("history", "")),
        "vehicle_profile": vehicle_to_yaml(vehicle),
        "terrain_profile": terrain_to_yaml(table.terrain),
    }
    with whole_files(files, request.force) as (path,):
        try:
            write(path, arrays, numbers, texts)
        except ValueError as error:
            raise UsageError("--format", kind.value, f"npz, as {error}") from error
        size = path.stat().st_size
    notes = () if arrays.right_turns else ("left turns only: the headings are not their own mirror image",)
    return ExportResult(kind, files, arrays.status.size, size, notes)
