"""``trackctl sensitivity``: how much each input matters to the sprocket rates."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

import typer

from trackctl.cli import options
from trackctl.cli.csv_output import CsvOutput
from trackctl.cli.first_run import compile_first
from trackctl.cli.progress import bar, say
from trackctl.cli.ranges import given_ranges

if TYPE_CHECKING:
    from trackctl.files.csv_writer import Column
    from trackctl.workflows.sensitivity import SensitivityRequest, SensitivityResult

COLUMNS = ("output", "input", "statistic", "index", "ci_low", "ci_high", "dummy")


def sensitivity(
    vehicle: options.Vehicle = options.DEFAULT_VEHICLE,
    terrain: options.Terrain = options.DEFAULT_TERRAIN,
    gravity_mps2: options.Gravity = options.DEFAULT_GRAVITY,
    slope_deg: Annotated[float, typer.Option("--slope-deg", help="Slope angle, below 45.")] = 12.13,
    velocity_mps: options.VelocityRange = None,
    radius_m: options.RadiusRange = None,
    heading_deg: options.HeadingRange = None,
    samples: Annotated[int, typer.Option("--samples", min=1, help="Operating points to solve.")] = 4096,
    slices: Annotated[int, typer.Option("--slices", help="Of each input's range, 2 or more.")] = 10,
    resamples: Annotated[int, typer.Option("--resamples", help="For the intervals and the dummy.")] = 1000,
    confidence: Annotated[
        float, typer.Option("--confidence", help="Of the intervals and the dummy, between 0 and 1.")
    ] = 0.95,
    seed: options.Seed = options.DEFAULT_SEED,
    jobs: options.Jobs = options.DEFAULT_JOBS,
    output: options.Output = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    as_json: options.Json = False,
) -> None:
    """PAWN sensitivity of both sprocket rates to speed, turn radius and heading, as CSV.

    An index above its `dummy` tells an input from one without influence, at the confidence given.

    Example:
      trackctl sensitivity --vehicle m113 --terrain hard-soil --slope-deg 10
    """
    from trackctl.files.profile_yaml import load_terrain, load_vehicle
    from trackctl.workflows.sensitivity import (
        SensitivityRequest,
        ranges_within,
        slope_steering_sensitivity,
    )

    destination = CsvOutput(output, force, as_json)
    destination.check()
    carrier = load_vehicle(vehicle)
    ranges = ranges_within(carrier, **given_ranges(velocity_mps, radius_m, heading_deg))
    request = SensitivityRequest(
        carrier,
        load_terrain(terrain),
        gravity_mps2,
        math.radians(slope_deg),
        ranges,
        samples,
        slices,
        resamples,
        confidence,
        seed,
        jobs,
    )
    compile_first(quiet, "indices")
    with bar("solving", "point", quiet) as progress:
        found = slope_steering_sensitivity(request, progress)
    tell(request, found, quiet)
    destination.write(index_columns(found), summary_of(request, found))


def index_columns(found: SensitivityResult) -> dict[str, Column]:
    """The indices as columns of a CSV table."""
    import numpy as np

    columns: dict[str, Column] = {}
    for name in COLUMNS:
        values = [getattr(index, name) for index in found.result.indices]
        columns[name] = np.array(values) if isinstance(values[0], float) else values
    return columns


def summary_of(request: SensitivityRequest, found: SensitivityResult) -> dict[str, object]:
    """The indices and what they were drawn from, for JSON."""
    return {
        "samples": request.samples,
        "rows": found.result.rows,
        "dropped_share": found.result.dropped_share,
        "confidence": request.confidence,
        "seed": request.seed,
        "indices": [{name: getattr(index, name) for name in COLUMNS} for index in found.result.indices],
    }


def tell(request: SensitivityRequest, found: SensitivityResult, quiet: bool) -> None:
    """Say what was analysed."""
    ranges = request.ranges
    low, high = (math.degrees(angle) for angle in ranges.heading)
    say(
        f"{request.vehicle.name} on {request.terrain.name}, slope {math.degrees(request.slope):g} deg: "
        f"velocity {ranges.velocity[0]:g} to {ranges.velocity[1]:g} m/s, "
        f"radius {ranges.radius[0]:g} to {ranges.radius[1]:g} m, heading {low:g} to {high:g} deg\n"
        f"{request.samples} operating points, {100.0 * found.result.dropped_share:.1f} % without an answer left out",
        quiet,
    )
