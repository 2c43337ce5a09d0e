"""``trackctl sweep``: the paper's analyses over slope, speed and heading."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from trackctl.cli import options
from trackctl.cli.csv_output import CsvOutput
from trackctl.cli.first_run import compile_first
from trackctl.cli.progress import bar, say
from trackctl.cli.ranges import list_of
from trackctl.errors import UsageError

if TYPE_CHECKING:
    from trackctl.workflows.sweep import SweepResult

LISTS = "A|A,B|MIN:MAX:STEP"
MOST_HEADINGS = 100_000
FULL_TURN = 360.0


def sweep(
    vehicle: options.Vehicle = options.DEFAULT_VEHICLE,
    terrain: options.Terrain = options.DEFAULT_TERRAIN,
    gravity_mps2: options.Gravity = options.DEFAULT_GRAVITY,
    slope_deg: Annotated[
        str, typer.Option("--slope-deg", metavar=LISTS, help="Slope angles, below 45.")
    ] = "3,5,8,10,12",
    velocity_mps: Annotated[
        str, typer.Option("--velocity-mps", metavar=LISTS, help="Speeds of the mass centre, above 0.")
    ] = "2",
    radius_m: Annotated[
        float, typer.Option("--radius-m", help="Of the turn, above half the gauge; negative to the right.")
    ] = 20.0,
    heading_deg: Annotated[
        str,
        typer.Option("--heading-deg", metavar=LISTS, help="Counter-clockwise from up-slope; an end of 360 is dropped."),
    ] = "0:360:1",
    summary: Annotated[
        bool, typer.Option("--summary", help="One row per slope and speed: RMSE and extreme no-slip radii.")
    ] = False,
    seed: options.Seed = options.DEFAULT_SEED,
    jobs: options.Jobs = options.DEFAULT_JOBS,
    output: options.Output = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    as_json: options.Json = False,
) -> None:
    """What the tracks do over the headings of a turn: their speeds, those without slip, the no-slip radius, as CSV.

    One row per slope, speed and heading, or with --summary one per slope and speed: the paper's figures 7 to 14 and
    tables 1 to 3. The default is its sweep over slopes.

    Example:
      trackctl sweep --slope-deg 5 --velocity-mps 1:4:1 --radius-m 20 --summary
    """
    import numpy as np

    from trackctl.files.profile_yaml import load_terrain, load_vehicle
    from trackctl.workflows.sweep import SweepRequest, rows_of, status_counts, summary_columns, tidy_columns
    from trackctl.workflows.sweep import sweep as solve

    destination = CsvOutput(output, force, as_json)
    destination.check()
    request = SweepRequest(
        load_vehicle(vehicle),
        load_terrain(terrain),
        gravity_mps2,
        np.radians(list_of(slope_deg, "--slope-deg")),
        np.array(list_of(velocity_mps, "--velocity-mps")),
        radius_m,
        np.radians(headings(heading_deg)),
        seed,
        jobs,
    )
    compile_first(quiet, "solve columns")
    with bar("solving", "slope", quiet) as progress:
        found = solve(request, progress)
    tell(found, quiet)
    extremes = summary_columns(found)
    destination.write(
        extremes if summary else tidy_columns(found),
        {"rows": request.rows, "status": status_counts(found), "summary": list(rows_of(extremes))},
    )


def headings(text: str) -> list[float]:
    """Headings in degrees, an end of 360 dropped, being the same as 0."""
    degrees = list_of(text, "--heading-deg", MOST_HEADINGS)
    if degrees == [FULL_TURN]:
        raise UsageError("--heading-deg", text, "0 or more, below 360")
    return degrees[:-1] if degrees[-1] == FULL_TURN else degrees


def tell(found: SweepResult, quiet: bool) -> None:
    """Say what was solved, and how much of it has no answer."""
    from trackctl.workflows.sweep import reasons

    request = found.request
    counts = f"{request.slope.size} x {request.velocity.size} x {request.heading.size} slopes, speeds and headings"
    missing = reasons(found)
    say(
        f"{request.vehicle.name} on {request.terrain.name}, radius {request.radius:g} m: {counts}"
        + (f"; without an answer: {missing}" if missing else ""),
        quiet,
    )
