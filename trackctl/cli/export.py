"""``trackctl export``: a look-up table for controllers, MATLAB and NumPy."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trackctl.cli import options
from trackctl.cli.progress import say
from trackctl.workflows.export_options import CMethod, ExportFormat, Precision

if TYPE_CHECKING:
    from trackctl.workflows.export import ExportResult


def export(
    lut: Annotated[Path, typer.Argument(metavar="LUT", help="The table.", show_default=False)],
    kind: Annotated[
        ExportFormat | None,
        typer.Option(
            "--format",
            help="C99 header and source, MATLAB and Simulink, or NumPy.",
            show_default="by the suffix of the output",
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="File that ends in .c or .h (both are written), .mat or .npz.",
            show_default="beside the table",
        ),
    ] = None,
    precision: Annotated[Precision, typer.Option("--precision", help="Of C: numbers and arithmetic.")] = (
        Precision.DOUBLE
    ),
    method: Annotated[
        CMethod, typer.Option("--method", help="Of C: how to interpolate, as `lookup` does.")
    ] = CMethod.LINEAR,
    prefix: Annotated[
        str | None,
        typer.Option("--prefix", metavar="NAME", help="Of C: of its names.", show_default="the name of the output"),
    ] = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    as_json: options.Json = False,
) -> None:
    """A look-up table for controllers, Simulink and scripts: C99 header and source, MATLAB .mat or NumPy .npz.

    C has one function that answers as `lookup --method linear` (or mls), without allocation or global state. The arrays
    of .mat and .npz hold both turns and the full circle of headings, NaN where there is no answer.

    Example:
      trackctl export lut.h5 --format c --precision float --prefix robot -o robot.c
    """
    from trackctl.workflows.export import ExportRequest, export_table

    result = export_table(ExportRequest(lut, output, kind, precision, method, prefix, force))
    for note in result.notes:
        say(f"{lut}: {note}", quiet)
    say(in_words(result, precision), quiet)
    if as_json:
        typer.echo(json.dumps(summary(result)))


def in_words(result: ExportResult, precision: Precision) -> str:
    """A line on what was written."""
    files = " and ".join(map(str, result.files))
    if result.kind is ExportFormat.C:
        return f"{files}: {result.cells} cells, {result.size} bytes of constant data, {precision.value}"
    return f"{files}: arrays of {result.cells} nodes, {result.size} bytes"


def summary(result: ExportResult) -> dict[str, object]:
    """The result for a script."""
    return {
        "format": result.kind.value,
        "files": [str(file) for file in result.files],
        "cells": result.cells,
        "bytes": result.size,
        "notes": list(result.notes),
    }
