"""``trackctl info``: what a look-up table holds, and how it was made."""

from __future__ import annotations

import json
import math
import textwrap
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trackctl.cli import options
from trackctl.units import split_suffix

if TYPE_CHECKING:
    from trackctl.workflows.describe_lut import AxisDescription, LutDescription

WIDTH = 110
INDENT = "  "
#: How people read the units of axes.
SHOWN_UNITS = {"rad": "deg", "mps": "m/s", "m": "m", "1pm": "1/m"}
RIGHT_TURNS = {
    "stored": "right turns stored, as the mass centre is off the centreline",
    "mirrored": "right turns read as mirrored left turns",
    "missing": "left turns only",
}


def info(
    lut: Annotated[Path, typer.Argument(metavar="LUT", help="The table.", show_default=False)],
    as_json: options.Json = False,
) -> None:
    """What a look-up table holds, how it was made, and how far it can be trusted.

    Example:
      trackctl info lut.h5
    """
    from trackctl.workflows.describe_lut import describe_lut, document

    found = describe_lut(lut)
    if as_json:
        typer.echo(json.dumps(document(found)))
        return
    for line in description(found):
        typer.echo(line)


def description(found: LutDescription) -> Iterator[str]:
    """The lines that describe a table to people."""
    attributes = found.header.attributes
    yield f"{found.file}: {attributes.get('title')}"
    yield from paragraph(f"created {attributes.get('created')} by trackctl {attributes.get('trackctl_version')}")
    yield from paragraph(f"history {attributes.get('history')}")
    yield from axes_lines(found)
    yield from cell_lines(found)
    yield from profile_lines(found)
    yield from step_lines(found)
    for name in ("certificate", "certificate_near_straight", "swarm_check", "settings"):
        entries = found.sections[name]
        yield from section(name.replace("_", " "), {key: shown(value) for key, value in entries.items()})


def paragraph(text: str) -> list[str]:
    """A text in lines of `WIDTH`."""
    return textwrap.wrap(text, WIDTH, initial_indent=INDENT, subsequent_indent=2 * INDENT, break_on_hyphens=False)


def section(title: str, rows: Mapping[str, str]) -> Iterator[str]:
    """A title and rows of two columns, nothing if there are no rows."""
    if rows:
        yield title
    width = max(map(len, rows), default=0)
    for name, value in rows.items():
        yield f"{INDENT}{name:<{width}}  {value}"


def shown(value: object) -> str:
    """An attribute of a file in few digits."""
    return f"{value:.6g}" if isinstance(value, float) else " ".join(str(value).split())


def axes_lines(found: LutDescription) -> Iterator[str]:
    """The axes with nodes, ends and steps."""
    rows = {
        split_suffix(key)[0]: axis_row(axis, split_suffix(key)[1])
        for key, axis in found.axes.items()
        if key != "curvature_1pm"
    }
    rows["radius"] += f"; straight ahead; {RIGHT_TURNS[found.right_turns.value]}"
    if found.header.axes.heading_is_periodic:
        rows["heading"] += ", full circle"
    yield from section("axes", rows)


def axis_row(axis: AxisDescription, suffix: str) -> str:
    """Nodes, ends and step of one axis."""
    unit = SHOWN_UNITS[suffix]
    low, high, step = (
        None if value is None else math.degrees(value) if unit == "deg" else value
        for value in (axis.low, axis.high, axis.step)
    )
    if low is None or high is None:
        return "no nodes"
    if axis.count == 1:
        return f"1 node: {low:.6g} {unit}"
    by = "uneven" if step is None else f"by {step:.6g}"
    return f"{axis.count} nodes: {low:.6g} to {high:.6g} {unit} {by}"


def cell_lines(found: LutDescription) -> Iterator[str]:
    """Cells of each status, and those beyond the actuator limits."""
    header, vehicle = found.header, found.header.vehicle
    cells = header.axes.size
    rows = {status.name.lower(): share(count, cells) for status, count in header.status_counts.items() if count}
    yield from section(f"cells: {cells}", rows)
    limits = {f"max_sprocket_rate {vehicle.max_sprocket_rate:g} rad/s": share(found.beyond_rate, cells)}
    if found.beyond_force is not None:
        limits[f"max_track_force {vehicle.max_track_force:g} N"] = share(found.beyond_force, cells)
    yield from section("cells beyond the actuator limits", limits)


def share(count: int, total: int) -> str:
    """A count and its share."""
    return f"{count} ({100.0 * count / total:.3g} %)"


def profile_lines(found: LutDescription) -> Iterator[str]:
    """What the table was made for."""
    from trackctl.workflows.describe_lut import profile_numbers

    for kind, profile in (("vehicle", found.header.vehicle), ("terrain", found.header.terrain)):
        yield f"{kind}: {profile.name}"
        yield from paragraph(profile.description)
        yield from paragraph(", ".join(f"{key} {value:g}" for key, value in profile_numbers(profile).items()))
    yield f"gravity: {found.header.gravity:g} m/s2"


def step_lines(found: LutDescription) -> Iterator[str]:
    """Why the steps are what they are, and the indices that they were drawn from."""
    reason = found.sections["steps"].get("reason")
    if reason:
        yield "steps"
        yield from paragraph(str(reason))
    if found.sensitivity is None:
        return
    rows = {
        f"{index.output} {index.input} {index.statistic}": (
            f"{index.index:.3f} ({index.ci_low:.3f} to {index.ci_high:.3f}), dummy {index.dummy:.3f}"
        )
        for index in found.sensitivity.indices
    }
    yield from section("sensitivity (PAWN index, its interval, threshold of no influence)", rows)
