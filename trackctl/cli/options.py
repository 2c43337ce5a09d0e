"""Options that several commands share, each defined once.

A command annotates its parameter with one of these and states the default::

    def lookup(lut: Path, vehicle: options.Vehicle = options.DEFAULT_VEHICLE) -> None: ...
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from trackctl.files.profile_folders import ProfileKind, profile_files
from trackctl.machine import cores

DEFAULT_VEHICLE = "utv-61cm"
DEFAULT_TERRAIN = "asphalt"
DEFAULT_GRAVITY = 9.80665
DEFAULT_SEED = 0
#: All cores that this process may use.
DEFAULT_JOBS = cores()
MAX_GRAVITY = 100.0


def complete_vehicle(incomplete: str) -> list[str]:
    """Names of vehicle profiles that start so, for the shell."""
    return _complete(ProfileKind.VEHICLE, incomplete)


def complete_terrain(incomplete: str) -> list[str]:
    """Names of terrain profiles that start so, for the shell."""
    return _complete(ProfileKind.TERRAIN, incomplete)


def complete_profile(incomplete: str) -> list[str]:
    """Names of all profiles that start so, for the shell."""
    return complete_vehicle(incomplete) + complete_terrain(incomplete)


def _complete(kind: ProfileKind, incomplete: str) -> list[str]:
    return [name for name in profile_files(kind) if name.startswith(incomplete)]


def _checked_gravity(gravity: float) -> float:
    if not 0.0 < gravity <= MAX_GRAVITY:
        raise typer.BadParameter(f"{gravity:g} is not allowed; allowed: above 0, up to {MAX_GRAVITY:g}")
    return gravity


Vehicle = Annotated[
    str,
    typer.Option(
        "--vehicle",
        metavar="NAME|FILE",
        help="Vehicle profile; `trackctl profiles list` names them.",
        autocompletion=complete_vehicle,
    ),
]
Terrain = Annotated[
    str,
    typer.Option(
        "--terrain",
        metavar="NAME|FILE",
        help="Terrain profile; `trackctl profiles list` names them.",
        autocompletion=complete_terrain,
    ),
]
Gravity = Annotated[
    float,
    typer.Option("--gravity-mps2", metavar="FLOAT", help="Gravity, above 0, up to 100.", callback=_checked_gravity),
]
VelocityRange = Annotated[
    str | None,
    typer.Option(
        "--velocity-mps",
        metavar="MIN:MAX",
        help="Of the mass centre.",
        show_default="1/20 of the top speed up to it",
    ),
]
RadiusRange = Annotated[
    str | None,
    typer.Option(
        "--radius-m",
        metavar="MIN:MAX",
        help="Of turns; straight driving is always in a table.",
        show_default="the profile's least turn radius, or 0.6 gauges, to 60 gauges",
    ),
]
HeadingRange = Annotated[
    str | None,
    typer.Option(
        "--heading-deg", metavar="MIN:MAX", help="From up-slope, counter-clockwise.", show_default="the full circle"
    ),
]
Seed = Annotated[int, typer.Option("--seed", min=0, max=2**63 - 1, help="Seed of all random numbers.")]
Jobs = Annotated[
    int,
    typer.Option(
        "--jobs",
        min=1,
        show_default="all cores",
        help="Cores to use; the output does not depend on it.",
    ),
]
Output = Annotated[
    Path | None, typer.Option("--output", "-o", metavar="FILE", help="Write here; - is standard output.")
]
Force = Annotated[bool, typer.Option("--force", help="Replace an existing output file.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="No words and no progress bar on standard error.")]
Json = Annotated[bool, typer.Option("--json", help="Print a summary as one JSON object.")]
