"""The command `compute-lut`."""

from __future__ import annotations

import math
import sys
import time
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trackctl.cli import options
from trackctl.cli.first_run import announce_compilation
from trackctl.cli.progress import bar, say
from trackctl.cli.ranges import list_of, named_numbers, range_of
from trackctl.errors import UsageError

if TYPE_CHECKING:
    from trackctl.workflows.compute_lut import TableRequest, TableSummary
    from trackctl.workflows.table_steps import ChosenSteps

DEFAULT_BUDGET = 200_000
LARGEST_REFINED = 5_000_000
STEP_NAMES = ("velocity", "radius", "heading")


class SeedingChoice(StrEnum):
    """Where a cell's solver starts."""

    CONTINUATION = "continuation"
    PSO = "pso"


def compute_lut(
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FILE", help="The table, HDF5 and netCDF4.")
    ] = Path("lut.h5"),
    vehicle: options.Vehicle = options.DEFAULT_VEHICLE,
    terrain: options.Terrain = options.DEFAULT_TERRAIN,
    slope_deg: Annotated[
        str, typer.Option("--slope-deg", metavar="A|A,B|MIN:MAX:STEP", help="Slope angles, below 45.")
    ] = "12.13",
    velocity_mps: Annotated[
        str | None,
        typer.Option("--velocity-mps", metavar="MIN:MAX", help="Default: 1/20 of the top speed up to it."),
    ] = None,
    radius_m: Annotated[
        str | None,
        typer.Option(
            "--radius-m",
            metavar="MIN:MAX",
            help="Default: the profile's least turn radius, or 0.6 gauges, to 60 gauges.",
        ),
    ] = None,
    heading_deg: Annotated[
        str, typer.Option("--heading-deg", metavar="MIN:MAX", help="From up-slope, counter-clockwise.")
    ] = "0:360",
    steps: Annotated[
        str | None,
        typer.Option(
            metavar="velocity=A,radius=B,heading=C",
            help="Explicit steps [m/s, m, deg], such as the paper's .5,1,1.",
        ),
    ] = None,
    budget: Annotated[
        int | None,
        typer.Option(
            min=1,
            help="Most cells; steps follow the sensitivity indices.",
            show_default=f"{DEFAULT_BUDGET}, or {LARGEST_REFINED} with --tolerance",
        ),
    ] = None,
    tolerance: Annotated[
        float | None,
        typer.Option(
            metavar="PERCENT",
            help="Refine until interpolated track speeds err less than this share of the speed.",
        ),
    ] = None,
    seeding: Annotated[
        SeedingChoice, typer.Option(help="Start from neighbours, or from a particle swarm in every cell.")
    ] = SeedingChoice.CONTINUATION,
    gravity_mps2: options.Gravity = options.DEFAULT_GRAVITY,
    seed: options.Seed = options.DEFAULT_SEED,
    jobs: options.Jobs = options.DEFAULT_JOBS,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Print cells, bytes and a time estimate only.")
    ] = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue the checkpoint beside the output.")
    ] = False,
    force: Annotated[
        bool, typer.Option("--force", help="Replace an existing output, and drop an old checkpoint.")
    ] = False,
    quiet: options.Quiet = False,
    as_json: options.Json = False,
) -> None:
    """Compile a look-up table of the sprocket speeds that make a vehicle really drive on a slope.

    For every speed, turn radius and heading the slope-steering model is solved; the steps follow a sensitivity analysis
    unless --steps or --tolerance says otherwise. The table states how it was made and how far it errs.

    Example:
      trackctl compute-lut --vehicle m113 --terrain hard-soil --slope-deg 0:12:4 -o m113.h5
    """
    import numpy as np

    from trackctl.files.atomic import check_output
    from trackctl.files.profile_yaml import load_terrain, load_vehicle
    from trackctl.workflows.compute_lut import new_request, refuse_streams
    from trackctl.workflows.sensitivity import ranges_within

    started = time.perf_counter()
    refuse_streams(output)
    refuse_contradictions(steps, budget, tolerance, resume, force)
    carrier, ground = load_vehicle(vehicle), load_terrain(terrain)
    slope = np.radians(list_of(slope_deg, "--slope-deg"))
    low, high = range_of(heading_deg, "--heading-deg")
    ranges = ranges_within(
        carrier,
        velocity=range_of(velocity_mps, "--velocity-mps") if velocity_mps else None,
        radius=range_of(radius_m, "--radius-m") if radius_m else None,
        heading=(math.radians(low), math.radians(high)),
    )
    blank = new_request(carrier, ground, gravity_mps2, slope, ranges, seeding.value, seed)
    if not dry_run:
        check_output(output, force)
    announce_compilation(quiet)
    chosen = choose_steps(blank, steps, budget, jobs, quiet)
    request = with_divisions(blank, chosen)
    if tolerance is not None:
        chosen = refine_steps(request, chosen, tolerance, budget, jobs, quiet)
        request = with_divisions(blank, chosen)
    tell_steps(request, chosen, quiet)
    if dry_run:
        tell_estimate(request, jobs, as_json)
        return
    summary = run(request, chosen, output, tolerance, budget, jobs, resume, force, quiet)
    tell_summary(summary, output, time.perf_counter() - started, quiet, as_json)


def refuse_contradictions(
    steps: str | None, budget: int | None, tolerance: float | None, resume: bool, force: bool
) -> None:
    """Refuse options that exclude each other."""
    if steps is not None and (budget is not None or tolerance is not None):
        raise UsageError("--steps", steps, "no --budget or --tolerance beside it")
    if tolerance is not None and not 0.0 < tolerance < 100.0:
        raise UsageError("--tolerance", f"{tolerance:g}", "a percentage above 0, below 100")
    if resume and force:
        raise UsageError("--resume", "with --force", "one of them: --force starts afresh")


def with_divisions(request: TableRequest, chosen: ChosenSteps) -> TableRequest:
    """The request with the divisions chosen."""
    from dataclasses import replace

    return replace(request, divisions=chosen.divisions)


def choose_steps(
    blank: TableRequest, steps: str | None, budget: int | None, jobs: int, quiet: bool
) -> ChosenSteps:
    """Explicit steps, or those that the sensitivity indices give under the budget."""
    from trackctl.workflows.sensitivity import SensitivityRequest, slope_steering_sensitivity
    from trackctl.workflows.table_steps import explicit_steps, steps_from_sensitivity

    if steps is not None:
        step = named_numbers(steps, STEP_NAMES, "--steps")
        chosen = explicit_steps(blank.ranges, step["velocity"], step["radius"], math.radians(step["heading"]))
        tell_shrunk(chosen, step, quiet)
        return chosen
    steepest = float(blank.slope[-1])
    asked = SensitivityRequest(
        blank.vehicle, blank.terrain, blank.gravity, steepest, blank.ranges, seed=blank.seed, jobs=jobs
    )  # fmt: skip
    found = slope_steering_sensitivity(asked)
    each = max((budget or DEFAULT_BUDGET) // blank.slope.size, 1)
    return steps_from_sensitivity(blank.vehicle, blank.ranges, each, found)


def tell_shrunk(chosen: ChosenSteps, asked: dict[str, float], quiet: bool) -> None:
    """Say which explicit steps do not divide their range."""
    for axis, step in asked.items():
        given = math.radians(step) if axis == "heading" else step
        low, high = getattr(chosen.ranges, axis)
        if high > low and not math.isclose(chosen.step(axis), given, rel_tol=1e-9):
            shown = math.degrees(chosen.step(axis)) if axis == "heading" else chosen.step(axis)
            say(f"step of {axis} {step:g} does not divide its range: {shown:g}", quiet)


def refine_steps(
    request: TableRequest, chosen: ChosenSteps, tolerance: float, budget: int | None, jobs: int, quiet: bool
) -> ChosenSteps:
    """Refine until the axes' measured errors meet the tolerance."""
    from trackctl.workflows.refinement import refine

    most = budget or LARGEST_REFINED
    return refine(request, chosen, tolerance / 100.0, most, jobs, lambda text: say(text, quiet))


def tell_steps(request: TableRequest, chosen: ChosenSteps, quiet: bool) -> None:
    """Say what the table will hold, and why."""
    ranges, axes = request.ranges, request.axes
    shape = " x ".join(str(count) for count in axes.shape)
    low, high = (math.degrees(angle) for angle in ranges.heading)
    say(
        f"{request.vehicle.name} on {request.terrain.name}: {axes.size} cells "
        f"({shape}: slope, velocity, curvature, heading)\n"
        f"  velocity {ranges.velocity[0]:g} to {ranges.velocity[1]:g} m/s by {chosen.step('velocity'):.4g}\n"
        f"  radius   {ranges.radius[0]:g} to {ranges.radius[1]:g} m by {chosen.step('radius'):.4g}, and straight\n"
        f"  heading  {low:g} to {high:g} deg by {math.degrees(chosen.step('heading')):.4g}\n"
        f"  {chosen.reason}",
        quiet,
    )


def tell_estimate(request: TableRequest, jobs: int, as_json: bool) -> None:
    """Print cells, bytes and a time estimate."""
    import json

    from trackctl.workflows.estimate import estimate

    found = estimate(request, jobs)
    if as_json:
        typer.echo(json.dumps(found))
    else:
        typer.echo(
            f"{found['cells']} cells, {found['bytes'] / 1e6:.1f} MB, about {found['seconds']:.1f} s with {jobs} jobs"
        )


def run(
    request: TableRequest,
    chosen: ChosenSteps,
    output: Path,
    tolerance: float | None,
    budget: int | None,
    jobs: int,
    resume: bool,
    force: bool,
    quiet: bool,
) -> TableSummary:
    """Compile the table; with a tolerance, again with finer steps while the held-out sample does not meet it."""
    from trackctl.files.journal import journal_path
    from trackctl.workflows.compute_lut import ToleranceError, compute_lut
    from trackctl.workflows.provenance import provenance
    from trackctl.workflows.refinement import refined_further

    share = None if tolerance is None else tolerance / 100.0
    while True:
        try:
            with bar("solving", "column", quiet) as progress:
                return compute_lut(
                    request, chosen, output, provenance(sys.argv), tolerance=share, jobs=jobs, resume=resume,
                    force=force, progress=progress,
                )  # fmt: skip
        except ToleranceError as missed:
            say(f"held-out error {100.0 * missed.error:.3g} %: refining further", quiet)
            most = budget or LARGEST_REFINED
            chosen = refined_further(request, chosen, share or 0.0, missed.error, most, jobs)
            request = with_divisions(request, chosen)
            tell_steps(request, chosen, quiet)
        except KeyboardInterrupt:
            say(f"stopped; {journal_path(output)} keeps what is done, --resume continues", False)
            raise


def tell_summary(summary: TableSummary, output: Path, seconds: float, quiet: bool, as_json: bool) -> None:
    """Say, or print as JSON, what became of the table."""
    import json
    from dataclasses import asdict

    counts = {status.name.lower(): count for status, count in summary.status_counts.items()}
    if as_json:
        typer.echo(
            json.dumps(
                {
                    "output": str(output),
                    "cells": summary.cells,
                    "status": counts,
                    "certificate": asdict(summary.certificate),
                    "certificate_near_straight": asdict(summary.near_straight),
                    "swarm_check": asdict(summary.swarm_check),
                    "seconds": round(seconds, 3),
                }
            )
        )
    shares = ", ".join(f"{count} {name}" for name, count in counts.items() if count)
    certificate, check = summary.certificate, summary.swarm_check
    say(
        f"{output}: {summary.cells} cells in {seconds:.1f} s ({shares})\n"
        f"  interpolated track speeds err by {100.0 * certificate.rms_error:.2g} % (RMS), "
        f"{100.0 * certificate.max_error:.2g} % (largest of {certificate.points})\n"
        f"  beyond the largest radius by {100.0 * summary.near_straight.rms_error:.2g} %, "
        f"{100.0 * summary.near_straight.max_error:.2g} %\n"
        f"  independent swarms disagree on {check.disagreements} of {check.cells} cells",
        quiet,
    )
