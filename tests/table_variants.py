"""Small solved tables of every shape that a writer has to mind."""

from dataclasses import replace

import numpy as np
from solved_tables import SLOPE, VEHICLE, solved_table

from trackctl.lut.axes import FULL_CIRCLE, Axes
from trackctl.lut.table import Table


def part(table, **kept):
    """A table of some nodes of its axes, in slices by axis; headings that are left out end the circle."""
    names = ("slope", "velocity", "curvature", "heading")
    places = tuple(kept.get(name, slice(None)) for name in names)
    nodes = [getattr(table.axes, name)[place] for name, place in zip(names, places, strict=True)]
    axes = Axes(*nodes, heading_is_periodic=table.axes.heading_is_periodic and "heading" not in kept)
    values = {name: array[places] for name, array in table.values.items()}
    return replace(table, axes=axes, values=values, status=table.status[places])


def variants() -> dict[str, Table]:
    """Tables by what is special about them."""
    symmetric, off_centre = solved_table(), solved_table(cog_left=0.05)
    return {
        "symmetric": symmetric,
        "two slopes": solved_table(slopes=(0.0, SLOPE)),
        "off centre": off_centre,
        "off centre, left turns only": part(off_centre, curvature=slice(5, None)),
        "half a circle": part(symmetric, heading=slice(2, 8)),
        "one speed and heading": part(symmetric, velocity=slice(1, 2), heading=slice(0, 1)),
        "slow sprockets": replace(symmetric, vehicle=replace(VEHICLE, max_sprocket_rate=9.0)),
    }


def scattered(table, rng, count, turns=0.0):
    """Operating points in a table and a little beyond, none at a node but on axes of one; shape (4, count)."""
    axes = table.axes
    margins = (0.01, 0.05, 0.05)
    ends = [
        (nodes[0] - margin * (nodes.size > 1), nodes[-1] + margin * (nodes.size > 1))
        for nodes, margin in zip((axes.slope, axes.velocity, axes.curvature), margins, strict=True)
    ]
    ends[2] = (-ends[2][1], ends[2][1])
    ends.append((0.0, FULL_CIRCLE) if axes.heading.size > 1 else (axes.heading[0],) * 2)
    points = np.stack([rng.uniform(*each, count) for each in ends])
    points[3] += FULL_CIRCLE * np.round(turns * rng.uniform(-1.0, 1.0, count))
    return points


def snapped(table, points, rng):
    """The same with most coordinates moved to nodes, of right turns, too."""
    axes, points = table.axes, points.copy()
    for row, nodes in enumerate((axes.slope, axes.velocity, axes.curvature, axes.heading)):
        chosen = rng.choice(nodes, points.shape[1]) * (rng.choice((-1.0, 1.0), points.shape[1]) if row > 1 else 1.0)
        points[row] = np.where(rng.random(points.shape[1]) < 0.7, chosen, points[row])
    return points


def queries(table, count, seed=1):
    """Operating points of all kinds, shape (4, 2 count): headings of several turns, nodes, straight driving."""
    rng = np.random.default_rng(seed)
    points = scattered(table, rng, count, turns=3.0)
    points[2, : count // 8] = rng.choice((0.0, -0.0), count // 8)
    return np.concatenate((points, snapped(table, points, rng)), axis=1)
