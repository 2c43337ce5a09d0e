"""``trackctl calibrate``: the ground, from a log."""

from __future__ import annotations

import json

import typer

from trackctl.cli import options
from trackctl.cli.csv_output import STDOUT, CsvOutput
from trackctl.cli.first_run import compile_first
from trackctl.cli.identify import Log, log_or_stdin
from trackctl.cli.progress import say


def calibrate(
    log: Log = None,
    vehicle: options.Vehicle = options.DEFAULT_VEHICLE,
    terrain: options.Terrain = options.DEFAULT_TERRAIN,
    gravity_mps2: options.Gravity = options.DEFAULT_GRAVITY,
    output: options.Output = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    as_json: options.Json = False,
) -> None:
    """Fit friction, shear modulus K and motion resistance of the ground to a log made on level ground.

    Stretches with steady track speeds are compared with the slope-steering model. A log may hold
    forward_velocity_mps, lateral_velocity_mps and yaw_rate_radps in place of time and pose; each row is a steady
    motion then. What the log does not determine is as in --terrain, where that fits, and the terrain says so.

    Example:
      trackctl calibrate log.csv --vehicle utv-61cm -o terrain.yaml
    """
    from trackctl.files.atomic import write_text
    from trackctl.files.profile_yaml import load_terrain, load_vehicle
    from trackctl.workflows.calibrate import CalibrateRequest, calibrated_terrain, calibration_summary, in_words
    from trackctl.workflows.calibrate import calibrate as fit

    CsvOutput(output, force, as_json).check()
    request = CalibrateRequest(log_or_stdin(log), load_vehicle(vehicle), load_terrain(terrain), gravity_mps2)
    compile_first(quiet, "calibrate")
    result = fit(request)
    text = calibrated_terrain(request, result)
    if output is not None and str(output) != STDOUT:
        write_text(output, text, force)
    elif not as_json:
        typer.echo(text, nl=False)
    if as_json:
        typer.echo(json.dumps(calibration_summary(result)))
    else:
        say(f"{result.windows} steady motions: {in_words(result)}", quiet)
