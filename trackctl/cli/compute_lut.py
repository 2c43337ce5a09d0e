"""The command `compute-lut`."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trackctl.cli import options
from trackctl.cli.first_run import compile_first
from trackctl.cli.progress import bar, say
from trackctl.cli.ranges import given_ranges, list_of, named_numbers
from trackctl.cli.table_report import tell_bound, tell_estimate, tell_shrunk, tell_steps, tell_summary
from trackctl.errors import UsageError
from trackctl.workflows.step_budgets import DEFAULT_BUDGET, LARGEST_REFINED

if TYPE_CHECKING:
    from trackctl.workflows.table_request import TableRequest
    from trackctl.workflows.table_steps import ChosenSteps

STEP_NAMES = ("velocity", "radius", "heading")
#: What the command does, to `trackctl.workflows.warm_up`.
COMPILING = "compile a table"


class SeedingChoice(StrEnum):
    """Where a cell's solver starts."""

    CONTINUATION = "continuation"
    PSO = "pso"


def compute_lut(
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="The table, HDF5 and netCDF4.")] = Path(
        "lut.h5"
    ),
    vehicle: options.Vehicle = options.DEFAULT_VEHICLE,
    terrain: options.Terrain = options.DEFAULT_TERRAIN,
    slope_deg: Annotated[
        str, typer.Option("--slope-deg", metavar="A|A,B|MIN:MAX:STEP", help="Slope angles, below 45.")
    ] = "12.13",
    velocity_mps: options.VelocityRange = None,
    radius_m: options.RadiusRange = None,
    heading_deg: options.HeadingRange = None,
    steps: Annotated[
        str | None,
        typer.Option(
            metavar="velocity=A,radius=B,heading=C", help="Explicit steps [m/s, m, deg], such as the paper's .5, 1, 1."
        ),
    ] = None,
    budget: Annotated[
        int | None,
        typer.Option(
            min=1,
            metavar="CELLS",
            help="Most cells; steps follow the sensitivity indices.",
            show_default=f"{DEFAULT_BUDGET}, or {LARGEST_REFINED} with --tolerance",
        ),
    ] = None,
    tolerance: Annotated[
        float | None,
        typer.Option(
            metavar="PERCENT",
            help="Refine until interpolated track speeds err by less, in percent of the speed, at 99 of 100 points.",
        ),
    ] = None,
    seeding: Annotated[
        SeedingChoice, typer.Option(help="Start from neighbours, or from a particle swarm in every cell.")
    ] = SeedingChoice.CONTINUATION,
    gravity_mps2: options.Gravity = options.DEFAULT_GRAVITY,
    seed: options.Seed = options.DEFAULT_SEED,
    jobs: options.Jobs = options.DEFAULT_JOBS,
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="Solve the cells on the workers of this Dask scheduler, [tcp://]HOST:PORT.",
            show_default="this machine",
        ),
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Print cells, bytes and a time estimate only.")] = False,
    resume: Annotated[bool, typer.Option("--resume", help="Continue the checkpoint beside the output.")] = False,
    force: Annotated[
        bool,
        typer.Option("--force", help="Replace an existing output and, without --resume, drop an old checkpoint."),
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
    from trackctl.workflows.cluster import workers_of
    from trackctl.workflows.compute_lut import compute_lut as compile_table
    from trackctl.workflows.compute_lut import refuse_streams
    from trackctl.workflows.provenance import provenance
    from trackctl.workflows.sensitivity import ranges_within
    from trackctl.workflows.table_request import new_request
    from trackctl.workflows.warm_up import missing

    started = time.perf_counter()
    refuse_contradictions(steps, budget, tolerance)
    carrier, ground = load_vehicle(vehicle), load_terrain(terrain)
    slope = np.radians(list_of(slope_deg, "--slope-deg"))
    ranges = ranges_within(carrier, **given_ranges(velocity_mps, radius_m, heading_deg))
    blank = new_request(carrier, ground, gravity_mps2, slope, ranges, seeding.value, seed)
    made = provenance(sys.argv[1:])
    if not dry_run:
        refuse_streams(output)
        check_output(output, force)
        compile_first(quiet, COMPILING)
    elif missing((COMPILING,)):
        tell_most(blank, steps, budget, tolerance, jobs, quiet, as_json)
        return
    with workers_of(None if dry_run else scheduler, lambda text: say(text, quiet)) as crew:
        chosen = choose_steps(blank, steps, budget, tolerance, jobs, quiet)
        request = blank.divided(chosen.divisions)
        tell_steps(request, chosen, quiet)
        if dry_run:
            tell_estimate(request, chosen, jobs, as_json)
            return
        with checkpoint_told(output), bar("solving", "column", quiet) as progress:
            summary = compile_table(
                request, chosen, output, made, jobs=jobs, resume=resume, force=force, progress=progress, crew=crew
            )
    tell_summary(summary, output, time.perf_counter() - started, quiet, as_json)


def refuse_contradictions(steps: str | None, budget: int | None, tolerance: float | None) -> None:
    """Refuse options that exclude each other."""
    if steps is not None and (budget is not None or tolerance is not None):
        raise UsageError("--steps", steps, "no --budget or --tolerance beside it")
    if tolerance is not None and not 0.0 < tolerance < 100.0:
        raise UsageError("--tolerance", f"{tolerance:g}", "a percentage above 0, below 100")


def tell_most(
    blank: TableRequest,
    steps: str | None,
    budget: int | None,
    tolerance: float | None,
    jobs: int,
    quiet: bool,
    as_json: bool,
) -> None:
    """Print what is known of a table's cost while nothing is compiled: with a budget, no more than its bound."""
    chosen = choose_steps(blank, steps, budget, tolerance, jobs, quiet) if steps is not None else None
    if chosen is not None:
        cells = blank.divided(chosen.divisions).axes.size
    else:
        cells = most_cells(budget, tolerance)
        say("steps are drawn once kernels are compiled, which `trackctl warm-up` does beforehand", quiet)
    tell_bound(cells, blank, chosen, jobs, as_json)


def most_cells(budget: int | None, tolerance: float | None) -> int:
    """Most cells that a table may have."""
    if budget is not None:
        return budget
    return DEFAULT_BUDGET if tolerance is None else LARGEST_REFINED


def choose_steps(
    blank: TableRequest, steps: str | None, budget: int | None, tolerance: float | None, jobs: int, quiet: bool
) -> ChosenSteps:
    """Explicit steps, or those that the sensitivity indices give under the budget, refined to a tolerance."""
    from trackctl.workflows.step_choice import steps_to_tolerance, steps_within
    from trackctl.workflows.table_steps import explicit_steps

    if steps is not None:
        step = named_numbers(steps, STEP_NAMES, "--steps")
        chosen = explicit_steps(blank.ranges, step["velocity"], step["radius"], math.radians(step["heading"]))
        tell_shrunk(chosen, step, quiet)
        return chosen
    if tolerance is None:
        return steps_within(blank, most_cells(budget, tolerance), jobs)
    most = most_cells(budget, tolerance)
    return steps_to_tolerance(blank, tolerance / 100.0, most, jobs, lambda text: say(text, quiet))


@contextmanager
def checkpoint_told(output: Path) -> Iterator[None]:
    """Say where the checkpoint lies if the block is interrupted."""
    from trackctl.files.journal import journal_path

    try:
        yield
    except KeyboardInterrupt:
        path = journal_path(output)
        if path.exists():
            say(f"stopped; {path} keeps what is done, --resume continues", False)
        raise
