"""``trackctl lookup``: sprocket commands for operating points."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trackctl.cli import options
from trackctl.cli.csv_output import CsvOutput
from trackctl.cli.first_run import compile_first
from trackctl.cli.progress import bar, say
from trackctl.errors import NoAnswerError, UsageError
from trackctl.units import accepted_keys
from trackctl.workflows.lookup_method import LookupMethod

if TYPE_CHECKING:
    from collections.abc import Iterable

    from trackctl.files.csv_writer import Column
    from trackctl.workflows.operating_points import OperatingPoints

STDIN = "-"


def lookup(
    lut: Annotated[Path, typer.Argument(metavar="LUT", help="The table.", show_default=False)],
    csv: Annotated[
        str | None,
        typer.Argument(
            metavar="CSV",
            help="velocity_mps, radius_m (negative to the right, inf straight ahead) or curvature_1pm, "
            "heading_rad, optionally slope_rad; other units by their suffix, such as heading_deg. "
            "- is standard input, as is nothing at all.",
            show_default=False,
        ),
    ] = None,
    velocity_mps: Annotated[
        float | None, typer.Option("--velocity-mps", help="Of a single point, in place of a CSV; above 0.")
    ] = None,
    radius_m: Annotated[
        float | None,
        typer.Option("--radius-m", help="Of a single point; negative to the right, inf straight ahead."),
    ] = None,
    heading_deg: Annotated[
        float | None,
        typer.Option("--heading-deg", help="Of a single point; from up-slope, counter-clockwise."),
    ] = None,
    slope_deg: Annotated[
        float | None,
        typer.Option("--slope-deg", help="Of a single point; needed if the table has several."),
    ] = None,
    method: Annotated[
        LookupMethod, typer.Option("--method", help="How to interpolate; exact solves the model instead.")
    ] = LookupMethod.MLS,
    vehicle: Annotated[
        str | None,
        typer.Option(
            "--vehicle",
            metavar="NAME|FILE",
            help="Refuse a table of another vehicle, and apply the actuator limits of this profile.",
            autocompletion=options.complete_vehicle,
        ),
    ] = None,
    terrain: Annotated[
        str | None,
        typer.Option(
            "--terrain",
            metavar="NAME|FILE",
            help="Refuse a table of another terrain.",
            autocompletion=options.complete_terrain,
        ),
    ] = None,
    gravity_mps2: Annotated[
        float | None, typer.Option("--gravity-mps2", help="Refuse a table of another gravity.")
    ] = None,
    jobs: options.Jobs = options.DEFAULT_JOBS,
    output: options.Output = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    as_json: options.Json = False,
) -> None:
    """Sprocket commands for operating points: CSV in, CSV out with the commands as further columns.

    Nothing is extrapolated: `status` says why a row has no answer, and its numbers stay empty.

    Example:
      trackctl lookup lut.h5 --velocity-mps 1 --radius-m 5 --heading-deg 90
    """
    from trackctl.files.profile_yaml import load_terrain, load_vehicle
    from trackctl.workflows.lookup import LookupRequest, answer_columns, is_short, status_counts
    from trackctl.workflows.lookup import lookup as look_up

    destination = CsvOutput(output, force, as_json)
    destination.check()
    single = {"velocity-mps": velocity_mps, "radius-m": radius_m, "heading-deg": heading_deg}
    if all(value is None for value in (*single.values(), slope_deg)):
        source, columns, points = points_of_file(csv)
    else:
        source, columns, points = single_point(csv, single | {"slope-deg": slope_deg})
    request = LookupRequest(
        lut,
        points,
        method,
        None if vehicle is None else load_vehicle(vehicle),
        None if terrain is None else load_terrain(terrain),
        gravity_mps2,
        jobs,
    )
    if not is_short(request):
        compile_first(quiet, "solve points" if method is LookupMethod.EXACT else "look up")
    with bar("looking up", "row", quiet) as progress:
        result = look_up(request, progress)
    answers, counts = answer_columns(result), status_counts(result)
    kept = without_answers(columns, answers, source, quiet)
    summary = {"rows": len(result.status), "method": method.value, "status": counts}
    destination.write(kept | answers, summary)
    report(counts, source, lut, quiet)


def is_terminal() -> bool:
    """Whether nothing is piped in."""
    return sys.stdin.isatty()


def points_of_file(csv: str | None) -> tuple[str, dict[str, Column], OperatingPoints]:
    """Where the points come from, their columns as they stand there, and the points."""
    from trackctl.files.csv_table import read_csv
    from trackctl.workflows.operating_points import read_points

    if csv is None and is_terminal():
        raise UsageError("CSV", None, "a file, - for standard input, or --velocity-mps, --radius-m and --heading-deg")
    table = read_csv(csv or STDIN)
    return table.file, dict(table.columns), read_points(table)


def single_point(csv: str | None, given: dict[str, float | None]) -> tuple[str, dict[str, Column], OperatingPoints]:
    """The point that the options describe, in the form of `points_of_file`."""
    import numpy as np

    from trackctl.workflows.operating_points import OperatingPoints, curvature_of

    if csv is not None:
        raise UsageError("CSV", csv, "no file beside the options of a single point")
    columns: dict[str, Column] = {}
    for option, value in given.items():
        if value is not None:
            check_number(option, value)
            columns[option.replace("-", "_")] = np.array([value])
        elif option != "slope-deg":
            raise UsageError(f"--{option}", None, "a number, beside the other options of a single point")
    velocity, radius, heading, *slope = (np.asarray(column) for column in columns.values())
    points = OperatingPoints(
        velocity, curvature_of(radius), np.radians(heading), np.radians(slope[0]) if slope else None
    )
    return "the point", columns, points


def check_number(option: str, value: float) -> None:
    """Refuse what is no number, and infinite ones other than a radius."""
    if option == "velocity-mps" and not 0.0 < value < math.inf:
        raise UsageError(f"--{option}", value, "above 0")
    if math.isnan(value) or (math.isinf(value) and option != "radius-m"):
        raise UsageError(f"--{option}", value, "a number" if option == "radius-m" else "a finite number")


def without_answers(columns: dict[str, Column], answers: Iterable[str], source: str, quiet: bool) -> dict[str, Column]:
    """The columns of the input but those that the answers replace, in whatever unit; says which."""
    headers = {header for answer in answers for header in accepted_keys(answer)}
    replaced = [header for header in columns if header in headers]
    if replaced:
        say(f"{source}: replacing {', '.join(replaced)}", quiet)
    return {header: cells for header, cells in columns.items() if header not in headers}


def report(counts: dict[str, int], source: str, lut: Path, quiet: bool) -> None:
    """Say how many rows have no answer, and raise a `NoAnswerError` if none has one."""
    reasons = ", ".join(f"{count} {word}" for word, count in counts.items() if count and word != "converged")
    rows = sum(counts.values())
    if not counts["converged"]:
        raise NoAnswerError(f"{source}: no row has an answer: {reasons}{hints(counts, lut)}")
    if reasons:
        say(f"{source}: {rows - counts['converged']} of {rows} rows have no answer: {reasons}", quiet)


def hints(counts: dict[str, int], lut: Path) -> str:
    """What to try where there is no answer."""
    outside = f"; `trackctl info {lut}` shows the ranges of the table" if counts["outside_table"] else ""
    near = "; --method exact solves the model next to infeasible cells" if counts["near_infeasible"] else ""
    return outside + near
