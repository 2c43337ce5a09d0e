"""``trackctl plot``: pictures of what the other commands write."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Annotated

import typer

from trackctl.cli import options
from trackctl.cli.progress import say
from trackctl.errors import MissingLibraryError, UsageError

STDIN = "-"
SUFFIXES = (".png", ".svg", ".pdf")
INSTALL = "pip install 'matplotlib>=3.8'"


def plot(
    file: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="A look-up table or a CSV table; - is standard input.", show_default=False),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="The picture: .png, .svg or .pdf.",
            show_default="beside the input, .png",
        ),
    ] = None,
    slope_deg: Annotated[
        float | None, typer.Option("--slope-deg", help="Of a look-up table: its slope next to this.")
    ] = None,
    velocity_mps: Annotated[
        float | None, typer.Option("--velocity-mps", help="Of a look-up table: its speed next to this.")
    ] = None,
    sensitivity: Annotated[
        bool, typer.Option("--sensitivity", help="Of a look-up table: the analysis that its steps come from.")
    ] = False,
    force: options.Force = False,
    quiet: options.Quiet = False,
    as_json: options.Json = False,
) -> None:
    """The right picture for any file that the tool writes, told by its content.

    A look-up table, the CSV of sensitivity, sweep (with or without --summary), simulate, plan, forces or identify.
    Needs matplotlib: the extra `plot`.

    Example:
      trackctl plot lut.h5 -o lut.pdf
    """
    from trackctl.files.atomic import check_output

    picture = picture_path(file, output)
    check_output(picture, force)
    try:
        from trackctl.workflows.plot import PlotRequest
        from trackctl.workflows.plot import plot as draw
    except ModuleNotFoundError as error:
        raise missing(error) from error
    slope = None if slope_deg is None else math.radians(slope_deg)
    kind = draw(PlotRequest(file, picture, force, slope, velocity_mps, sensitivity))
    say(f"{file}: {kind}, drawn to {picture}", quiet)
    if as_json:
        typer.echo(json.dumps({"file": str(file), "kind": kind.value, "output": str(picture)}))


def picture_path(file: Path, output: Path | None) -> Path:
    """Where the picture goes, its suffix checked."""
    if output is None:
        if str(file) == STDIN:
            raise UsageError("--output", None, "a file, as the input is standard input")
        return file.with_suffix(SUFFIXES[0])
    if output.suffix.lower() not in SUFFIXES:
        raise UsageError("--output", output, f"a file that ends in {', '.join(SUFFIXES)}")
    return output


def missing(error: ModuleNotFoundError) -> Exception:
    """What to tell of a library that is not there; a module of our own would be a defect."""
    name = str(error.name).partition(".")[0]
    return error if name == "trackctl" else MissingLibraryError(name, "drawing", INSTALL)
