"""Picture of looked-up commands: what was asked, row by row, and what was answered."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from trackctl.plots import style
from trackctl.plots.style import Columns

DEGREES = float(np.degrees(1.0))


def draw_lookup(columns: Columns) -> Figure:
    """Operating points on the left, commands on the right, both over the rows; rows without an answer are hatched.

    Parameters
    ----------
    columns
        `velocity`, `curvature`, `heading`, `sprocket_rate_left` and `_right`, `slip_left` and `_right`, `sideslip`; NaN
        without an answer. [SI]
    """
    figure = style.page("Looked-up commands", 3)
    grid = style.panels(figure, 3, 2, sharex=True)
    velocity, rates, curvature, slips, heading, sideslip = grid
    row = np.arange(1.0, columns["velocity"].size + 1.0)
    alone: dict[str, Any] = {"color": style.BLACK, "marker": "."}
    velocity.plot(row, columns["velocity"], **alone)
    curvature.plot(row, columns["curvature"], **alone)
    heading.plot(row, DEGREES * columns["heading"], **alone)
    sideslip.plot(row, DEGREES * columns["sideslip"], **alone)
    for axes, name, factor in ((rates, "sprocket_rate", 1.0), (slips, "slip", 100.0)):
        style.both_tracks(axes, row, columns, name, factor)
        for line, marker in zip(axes.get_lines(), style.MARKERS, strict=False):
            line.set_marker(marker)
    texts = (
        ("Asked: speed", "Speed [m/s]"),
        ("Answered: sprocket rates", "Rate [rad/s]"),
        ("Asked: curvature, left above 0", "Curvature [1/m]"),
        ("Answered: slips, above 0 driving", "Slip [%]"),
        ("Asked: heading from up-slope", "Heading [°]"),
        ("Answered: sideslip", "Angle [°]"),
    )
    for number, (axes, (text, label)) in enumerate(zip(grid, texts, strict=True)):
        style.shade(axes, row, np.isnan(columns["sprocket_rate_left"]), "no answer")
        style.caption(axes, number, text)
        axes.set_ylabel(label)
        axes.margins(x=0.03)
    for axes in (heading, sideslip):
        axes.set_xlabel("Row")
    style.legend_below(figure, [*rates.get_lines(), *rates.patches[:1]])
    return figure
