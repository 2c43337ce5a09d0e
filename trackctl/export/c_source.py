"""A look-up table as C99: a header, and a source with constant arrays and a look-up function."""

from __future__ import annotations

import re
import textwrap
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from string import Template

import numpy as np

from trackctl import __version__
from trackctl.export.c_choices import CMethod, Precision
from trackctl.export.c_numbers import literal, literals, rounded, rows
from trackctl.lut.axes import FULL_CIRCLE, Array, Axes
from trackctl.lut.interpolation import Grid, LookupStatus, interpolant
from trackctl.lut.shape_functions import SNAP
from trackctl.lut.table import Table

AXES = ("slope", "velocity", "curvature", "heading")
#: Longer ones would leave less than the 31 characters by which C99 tells external names apart.
LONGEST_PREFIX = 24
#: Rounding of a coordinate, in units in the last place of the largest.
ROUNDING = 4.0
COMMENT_WIDTH = 117


@dataclass(frozen=True, slots=True)
class CTarget:
    """How a table becomes C.

    Attributes
    ----------
    precision
        Of the numbers and of the arithmetic.
    prefix
        That public names begin with; see `is_prefix`.
    header
        File name of the header.
    method
        How to interpolate.
    """

    precision: Precision
    prefix: str
    header: str
    method: CMethod = CMethod.LINEAR


@dataclass(frozen=True, slots=True)
class CSource:
    """A table as C.

    Attributes
    ----------
    header, source
        Texts of the two files, ASCII.
    size
        Of the constant data. [bytes]
    """

    header: str
    source: str
    size: int


@dataclass(frozen=True, slots=True, eq=False)
class Borders:
    """An axis as the source holds it.

    Attributes
    ----------
    nodes
        Ascending; headings that go round the full circle end with the first one again.
    lower, upper
        The range, with a margin for rounding.
    snap
        A point this close to a node is at the node. [steps]
    wraps
        Whether the nodes go round.
    bends
        Whether no stencil of four nodes reaches across 0.
    """

    nodes: Array
    lower: float
    upper: float
    snap: float
    wraps: bool
    bends: bool


def is_prefix(text: str) -> bool:
    """Whether names in C may begin so: a letter, then letters, digits and underscores, not too many."""
    return len(text) <= LONGEST_PREFIX and re.fullmatch("[A-Za-z][A-Za-z0-9_]*", text) is not None


def c_source(table: Table, target: CTarget, description: Mapping[str, str]) -> CSource:
    """A table as C.

    Parameters
    ----------
    table
        Cells without an answer become zeros that are never read.
    target
        How.
    description
        What the header says of the table, by topic.

    Raises
    ------
    ValueError
        If two nodes of an axis are one in this precision.
    """
    grid = interpolant(table).grid
    borders = {name: border_nodes(table.axes, name, target.precision) for name in AXES}
    size = data_size(grid, borders.values(), target.precision)
    fields = data_fields(grid, table.axes, borders, target.precision)
    table_id = zlib.crc32(repr((target.precision.value, target.method.value, fields)).encode())
    fields |= {
        "version": __version__,
        "description": comment({**description, "size": f"{size} bytes of constant data, {target.precision.value}"}),
        "statuses": ",\n".join(f"    {target.prefix.upper()}_{each.name} = {each.value}" for each in LookupStatus),
        "prefix": target.prefix,
        "PREFIX": target.prefix.upper(),
        "header": target.header,
        "method": target.method.value,
        "weigh": template(f"{target.method.value}.c.in").substitute(target.precision.words),
        "table_id": f"0x{table_id:08X}UL",
        "table_bytes": str(size),
        **end_fields(grid, borders, target.precision),
        **target.precision.words,
    }
    header, source = (template(name).substitute(fields) for name in ("lookup.h.in", "lookup.c.in"))
    return CSource(header, source, size)


def template(name: str) -> Template:
    """A text beside this module, with places for `fields`."""
    return Template(Path(__file__).with_name(name).read_text(encoding="ascii"))


def border_nodes(axes: Axes, name: str, precision: Precision) -> Borders:
    """An axis rounded to a precision, with margins as of `look_up` or of the rounding, whichever is more."""
    nodes: Array = getattr(axes, name)
    wraps, bends = name == "heading" and axes.heading_is_periodic, name == "curvature"
    if wraps:
        nodes = np.append(nodes, nodes[0] + FULL_CIRCLE)
    nodes = rounded(nodes, precision)
    steps = np.diff(nodes)
    if not (steps > 0.0).all():
        raise ValueError(f"two nodes of {name} are one in this precision")
    rounding = ROUNDING * precision.epsilon * float(np.abs(nodes).max())
    if not steps.size:
        margin = max(SNAP * abs(float(nodes[0])), rounding)
        return Borders(nodes, float(nodes[0]) - margin, float(nodes[0]) + margin, SNAP, wraps, bends)
    snap = max(SNAP, rounding / float(steps.min()))
    lower, upper = float(nodes[0] - snap * steps[0]), float(nodes[-1] + snap * steps[-1])
    return Borders(nodes, lower, upper, snap, wraps, bends)


def data_size(grid: Grid, borders: Iterable[Borders], precision: Precision) -> int:
    """Bytes of all arrays: values, nodes, and a byte of status for each cell."""
    numbers = grid.values.size + sum(axis.nodes.size for axis in borders)
    return numbers * precision.size + grid.status.size


def data_fields(grid: Grid, axes: Axes, borders: Mapping[str, Borders], precision: Precision) -> dict[str, str]:
    """All that answers depend on."""
    slopes, velocities, curvatures, headings = axes.shape
    constants = {
        "full_circle": FULL_CIRCLE,
        "half_gauge": grid.half_gauge,
        "cog_left": grid.cog_left,
        "sprocket_radius": grid.sprocket_radius,
        "max_sprocket_rate": grid.max_sprocket_rate,
    }
    values = np.nan_to_num(grid.values, nan=0.0)
    return {
        "velocities": str(velocities),
        "curvatures": str(curvatures),
        "headings": str(headings),
        "cells": f"{slopes * velocities * curvatures * headings}L",
        "mirrored": str(int(grid.mirrored)),
        **{name: literal(value, precision) for name, value in constants.items()},
        "nodes": "\n".join(node_array(name, axis, precision) for name, axis in borders.items()),
        "axes": ",\n".join(axis_entry(name, axis, precision) for name, axis in borders.items()),
        "values": ",\n".join(f"    {{{row}}}" for row in rows(literals(values.ravel(), precision), 3)),
        "cell_status": ",\n".join(f"    {row}" for row in rows(map(str, grid.status.tolist()), 32)),
    }


def node_array(name: str, axis: Borders, precision: Precision) -> str:
    """The definition of an axis' nodes."""
    lines = ",\n".join(f"    {row}" for row in rows(literals(axis.nodes, precision), 6))
    return f"static const real {name}_nodes[{axis.nodes.size}] = {{\n{lines}\n}};\n"


def axis_entry(name: str, axis: Borders, precision: Precision) -> str:
    """The entry of an axis in the table of axes."""
    lower, upper, snap = (literal(value, precision) for value in (axis.lower, axis.upper, axis.snap))
    return f"    {{{name}_nodes, {axis.nodes.size}, {lower}, {upper}, {snap}, {axis.wraps:d}, {axis.bends:d}}}"


def end_fields(grid: Grid, borders: Mapping[str, Borders], precision: Precision) -> dict[str, str]:
    """First and last node of the axes that do not go round; mirrored turns are inside."""
    fields = {}
    for name in AXES[:3]:
        nodes = borders[name].nodes
        first = -nodes[-1] if name == "curvature" and grid.mirrored else nodes[0]
        fields[f"{name}_min"], fields[f"{name}_max"] = (literal(end, precision) for end in (first, nodes[-1]))
    return fields


def comment(description: Mapping[str, str]) -> str:
    """Lines inside a block comment that no user's text can end, nor upset the strictest compiler."""
    width = max(map(len, description))
    lines = []
    for topic, text in description.items():
        plain = " ".join(text.encode("ascii", "xmlcharrefreplace").decode().split())
        for mark, harmless in (("*/", "* /"), ("/*", "/ *"), ("?", "&#63;")):
            plain = plain.replace(mark, harmless)
        lines += textwrap.wrap(
            plain, COMMENT_WIDTH, initial_indent=f"{topic:<{width}}  ", subsequent_indent=" " * (width + 2)
        ) or [topic]
    return "\n".join(f" * {line}" for line in lines)
