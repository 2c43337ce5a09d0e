"""``trackctl identify``: learn slip from a log."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trackctl.cli import options
from trackctl.cli.csv_output import STDOUT, CsvOutput
from trackctl.cli.csv_stream import csv_stream
from trackctl.cli.first_run import compile_first
from trackctl.cli.progress import say
from trackctl.errors import UsageError
from trackctl.workflows.slip_choices import FilterKind, SlipModel

if TYPE_CHECKING:
    from trackctl.workflows.identify import IdentifyRequest, IdentifyResult

STDIN = "-"

Log = Annotated[
    str | None,
    typer.Argument(
        metavar="LOG",
        help="CSV: time_s, track_speed_left_mps, track_speed_right_mps (or sprocket_rate_left_radps, ...), x_m, y_m, "
        "yaw_rad; pose cells may be empty. - is standard input, as is nothing at all.",
        show_default=False,
    ),
]
Horizon = Annotated[float, typer.Option("--horizon-s", help="How far ahead motions are predicted, up to 60.")]


def identify(
    log: Log = None,
    vehicle: options.Vehicle = options.DEFAULT_VEHICLE,
    model: Annotated[
        SlipModel,
        typer.Option(
            "--model",
            help="What is learned: p1 to p9, the paper's p1 to p6, constant ICRs p7 to p9, "
            "p1 to p9 and a factor on each track speed, or nothing.",
        ),
    ] = SlipModel.PARAMETRIC,
    kind: Annotated[
        FilterKind,
        typer.Option("--filter", help="Compare motions over a window, or velocities between two poses."),
    ] = FilterKind.WINDOW,
    window_s: Annotated[
        float | None,
        typer.Option("--window-s", help="Time over which motions are compared.", show_default="three poses, 1 to 4"),
    ] = None,
    horizon_s: Horizon = 2.0,
    save: Annotated[
        Path | None, typer.Option("--save", metavar="FILE", help="Write a slip model of the log, for `predict`.")
    ] = None,
    output: options.Output = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    as_json: options.Json = False,
) -> None:
    """Learn a vehicle's slip from its track speeds and poses, by a Kalman filter on the ICRs of its tracks.

    One row for each new pose, as soon as the pose one horizon later is known (with --horizon-s 0: at once):
    ICRs of the tracks, parameters with standard deviations, innovations, and how far predictions by what was
    learned until then, and without slip, are from that later pose.

    Example:
      trackctl identify log.csv --vehicle utv-61cm --save slip.yaml -o updates.csv --json
    """
    from trackctl.files.atomic import check_output
    from trackctl.files.profile_yaml import load_vehicle
    from trackctl.workflows.identify import IdentifyRequest, slip_summary
    from trackctl.workflows.identify import identify as learn

    destination = CsvOutput(output, force, as_json)
    destination.check()
    if save is not None:
        if output is not None and save.absolute() == output.absolute():
            raise UsageError("--save", save, "another file than --output")
        check_output(save, force)
    request = IdentifyRequest(
        log_or_stdin(log), load_vehicle(vehicle), model, kind, window_s, horizon_s, save is not None
    )
    compile_first(quiet, "filter a log")
    with csv_stream(destination) as emit:
        result = learn(request, emit)
    if save is not None:
        write_slip(save, force, request, result)
    if as_json:
        typer.echo(json.dumps(slip_summary(request, result)))
    elif str(output or STDOUT) != STDOUT or save is not None:
        say(in_words(result), quiet)


def log_or_stdin(log: str | None) -> str:
    """The log, or ``-`` where something is piped in."""
    if log is None and sys.stdin.isatty():
        raise UsageError("LOG", None, "a file, or - for standard input")
    return log or STDIN


def write_slip(save: Path, force: bool, request: IdentifyRequest, result: IdentifyResult) -> None:
    """Write what was learned."""
    from trackctl.files.atomic import write_text
    from trackctl.files.slip_yaml import SlipFile, slip_to_yaml
    from trackctl.workflows.provenance import provenance

    made = provenance(sys.argv[1:])
    vehicle = request.vehicle
    slip = SlipFile(
        vehicle.name,
        vehicle.track_gauge,
        vehicle.sprocket_radius,
        request.model,
        result.lasting,
        request.log,
        result.updates,
        made.created,
        made.history,
    )
    write_text(save, slip_to_yaml(slip), force)


def in_words(result: IdentifyResult) -> str:
    """A line on what was learned."""
    parts = [f"{result.updates} updates, {result.rejected} rejected"]
    for name, key, unit in (("position", "position_error_m", "m"), ("heading", "heading_error_rad", "rad")):
        means = result.errors[key]
        if isinstance(means, dict) and means["reduction_percent"] is not None:
            parts.append(
                f"{name} error {means['model']:.3g} {unit}, without slip {means['no_slip']:.3g} "
                f"({-means['reduction_percent']:+.0f} %)"
            )
    return "; ".join(parts)
