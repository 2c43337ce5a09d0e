"""``trackctl predict``: where track speeds lead, by a learned slip model."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from trackctl.cli import options
from trackctl.cli.csv_output import CsvOutput
from trackctl.cli.csv_stream import csv_stream
from trackctl.cli.first_run import compile_first
from trackctl.cli.identify import Horizon, Log, log_or_stdin


def predict(
    log: Log = None,
    slip: Annotated[
        str, typer.Option("--slip", metavar="FILE", help="Slip model, as `identify --save` writes it.")
    ] = "slip.yaml",
    horizon_s: Horizon = 2.0,
    vehicle: Annotated[
        str | None,
        typer.Option(
            "--vehicle",
            metavar="NAME|FILE",
            help="Refuse a slip model of another track gauge.",
            autocompletion=options.complete_vehicle,
        ),
    ] = None,
    output: options.Output = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    as_json: options.Json = False,
) -> None:
    """Predict the pose one horizon after each pose of a log, from the track speeds in between.

    Where the log ends before, its last track speeds hold on. Standard deviations come from the learned model's
    covariance and own error, and from the sensors; errors where the log has the later pose.

    Example:
      trackctl predict log.csv --slip slip.yaml --horizon-s 2
    """
    from trackctl.files.profile_yaml import load_vehicle
    from trackctl.files.slip_yaml import read_slip
    from trackctl.workflows.predict import PredictRequest
    from trackctl.workflows.predict import predict as look_ahead

    destination = CsvOutput(output, force, as_json)
    destination.check()
    profile = None if vehicle is None else load_vehicle(vehicle)
    request = PredictRequest(log_or_stdin(log), read_slip(slip), horizon_s, profile)
    compile_first(quiet, "filter a log")
    with csv_stream(destination) as emit:
        result = look_ahead(request, emit)
    if as_json:
        typer.echo(json.dumps({"horizon_s": horizon_s, "predictions": result.predictions, **result.errors}))
