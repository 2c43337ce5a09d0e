"""What `compute-lut` says about a table: its steps, its cost, what became of it."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from trackctl.cli.progress import say

if TYPE_CHECKING:
    from trackctl.workflows.table_request import TableRequest
    from trackctl.workflows.table_steps import ChosenSteps
    from trackctl.workflows.table_summary import ErrorCertificate, TableSummary


def tell_shrunk(chosen: ChosenSteps, asked: dict[str, float], quiet: bool) -> None:
    """Say which explicit steps [m/s, m, deg] do not divide their range."""
    for axis, step in asked.items():
        given = math.radians(step) if axis == "heading" else step
        low, high = getattr(chosen.ranges, axis)
        if high > low and not math.isclose(chosen.step(axis), given, rel_tol=1e-9):
            shown = math.degrees(chosen.step(axis)) if axis == "heading" else chosen.step(axis)
            say(f"the {axis} step {step:g} does not divide its range and becomes {shown:g}", quiet)


def tell_steps(request: TableRequest, chosen: ChosenSteps, quiet: bool) -> None:
    """Say what the table will hold, and why."""
    ranges, axes = request.ranges, request.axes
    shape = " x ".join(str(count) for count in axes.shape)
    velocity = spread(ranges.velocity, chosen.step("velocity"), "m/s")
    radius = spread(ranges.radius, chosen.step("radius"), "m")
    low, high = ranges.heading
    heading = spread((math.degrees(low), math.degrees(high)), math.degrees(chosen.step("heading")), "deg")
    dropped = "" if axes.heading_is_periodic or not ranges.ends_at_start else ", 360 itself left out"
    say(
        f"{request.vehicle.name} on {request.terrain.name}: {axes.size} cells "
        f"({shape}: slope, velocity, curvature, heading)\n"
        f"  velocity {velocity}\n"
        f"  radius   {radius}, and straight\n"
        f"  heading  {heading}{dropped}\n"
        f"  {chosen.reason}",
        quiet,
    )


def spread(ends: tuple[float, float], step: float, unit: str) -> str:
    """A range with its step, or its only value."""
    low, high = ends
    return f"{low:g} to {high:g} {unit} by {step:.4g}" if high > low else f"{low:g} {unit}"


def tell_estimate(request: TableRequest, chosen: ChosenSteps, jobs: int, as_json: bool) -> None:
    """Print cells, bytes and a time estimate."""
    from trackctl.workflows.estimate import estimate

    tell_cost(estimate(request, jobs), "", chosen, as_json)


def tell_bound(cells: int, blank: TableRequest, chosen: ChosenSteps | None, jobs: int, as_json: bool) -> None:
    """Print cells, bytes and time without a measurement, and the most of them where no steps are chosen."""
    from trackctl.workflows.estimate import rough_estimate

    tell_cost(rough_estimate(cells, blank.seeding, jobs), "" if chosen else "at most ", chosen, as_json)


def tell_cost(found: dict[str, float], bound: str, chosen: ChosenSteps | None, as_json: bool) -> None:
    """Print what a table costs; the steps are null where none are chosen."""
    if as_json:
        axes = {"velocity": "step_velocity_mps", "radius": "step_radius_m", "heading": "step_heading_rad"}
        steps = {key: chosen.step(axis) if chosen else None for axis, key in axes.items()}
        typer.echo(json.dumps({**found, **steps}))
    else:
        typer.echo(f"{bound}{found['cells']} cells, {found['bytes'] / 1e6:.1f} MB, about {found['seconds']:.1f} s")


def tell_summary(summary: TableSummary, output: Path, seconds: float, quiet: bool, as_json: bool) -> None:
    """Say, and if asked print as JSON, what became of the table."""
    counts = {status.name.lower(): count for status, count in summary.status_counts.items()}
    if as_json:
        typer.echo(json.dumps(json_summary(summary, counts, output, seconds)))
    shares = ", ".join(f"{count} {name}" for name, count in counts.items() if count)
    check = summary.swarm_check
    say(
        f"{output}: {summary.cells} cells in {seconds:.1f} s ({shares})\n"
        f"  interpolated track speeds err by {error_of(summary.certificate)}\n"
        f"  between the largest radius and straight driving by {error_of(summary.near_straight)}\n"
        f"  independent swarms disagree on {check.disagreements} of {check.cells} cells",
        quiet,
    )


def json_summary(summary: TableSummary, counts: dict[str, int], output: Path, seconds: float) -> dict[str, object]:
    """The summary as JSON; null where there is no number."""
    from dataclasses import asdict

    return {
        "output": str(output),
        "cells": summary.cells,
        "status": counts,
        "certificate": numbers(summary.certificate),
        "certificate_near_straight": numbers(summary.near_straight),
        "swarm_check": asdict(summary.swarm_check),
        "seconds": round(seconds, 3),
    }


def numbers(certificate: ErrorCertificate) -> dict[str, float | None]:
    """Fields of a certificate, None for NaN."""
    from dataclasses import asdict

    return {name: None if math.isnan(value) else value for name, value in asdict(certificate).items()}


def error_of(certificate: ErrorCertificate) -> str:
    """The error in words."""
    if not certificate.points:
        return "an unknown amount: no sampled point has an answer"
    rms, most, largest = (
        f"{100.0 * error:.2g} %"
        for error in (certificate.rms_error, certificate.certified_error, certificate.max_error)
    )
    return f"{rms} (RMS), {most} (all but 1 in 100), {largest} (largest of {certificate.points})"
