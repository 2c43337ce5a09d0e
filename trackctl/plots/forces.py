"""Picture of nominal track forces along a path, after the figures 5 to 9 of Shiller, Serate and Hua (1993)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from trackctl.plots import style
from trackctl.plots.style import Columns

#: Column, factor, caption and label of the panels with one curve, in their order after the path.
SINGLE = (
    ("speed", 1.0, "Speed", "Speed [m/s]"),
    ("yaw_gradient", 1.0, "Yaw gradient", "dθ/ds [1/m]"),
    ("slip_angle", float(np.degrees(1.0)), "Slip angle: tangent minus yaw", "Angle [°]"),
)


def draw_forces(columns: Columns) -> Figure:
    """Path, speed, attitude and track forces over the arc length; stations that are not feasible are hatched.

    Parameters
    ----------
    columns
        `arc_length`, `x`, `y`, `speed`, `yaw_gradient`, `slip_angle`, `icr_offset`, `force_total`, `force_difference`,
        `force_left`, `force_right`, `friction_moment`, `feasible`; NaN where there is no solution. [SI]
    """
    figure = style.page("Nominal track forces", 4, 7.6)
    path, *others = style.panels(figure, 4, 2)
    way = columns["arc_length"]
    draw_path(path, columns)
    style.caption(path, 0, "Path")
    singles, (sums, tracks, offset, moment) = others[:3], others[3:]
    for axes, (name, factor, _, _) in zip(singles, SINGLE, strict=True):
        axes.plot(way, factor * columns[name], color=style.BLACK)
    sums.plot(way, columns["force_total"], color=style.BLACK, label="total")
    sums.plot(way, columns["force_difference"], color=style.GREEN, linestyle=style.DASHES[2], label="right minus left")
    style.both_tracks(tracks, way, columns, "force")
    offset.plot(way, columns["icr_offset"], color=style.BLACK)
    moment.plot(way, columns["friction_moment"], color=style.BLACK)
    texts = [(text, label) for _, _, text, label in SINGLE] + [
        ("Sum and difference of the track forces", "Force [N]"),
        ("Track forces", "Force [N]"),
        ("Turning centre ahead of the mass centre", "Offset [m]"),
        ("Moment of the lateral friction", "Moment [N m]"),
    ]
    for number, (axes, (text, label)) in enumerate(zip(others, texts, strict=True), start=1):
        style.shade(axes, way, columns["feasible"] == 0.0, "not feasible")
        style.caption(axes, number, text)
        axes.set_ylabel(label)
        axes.set_xlabel("Arc length [m]")
    hatched = [patch for patch in moment.patches if patch.get_label() == "not feasible"]
    style.legend_below(figure, [*sums.get_lines(), *tracks.get_lines(), *hatched])
    return figure


def draw_path(axes: Axes, columns: Columns) -> None:
    """The path with its start and direction."""
    x, y = columns["x"], columns["y"]
    axes.plot(x, y, color=style.BLACK)
    axes.plot(x[0], y[0], color=style.BLACK, marker="o", markersize=5)
    style.arrows(axes, x, y)
    style.plan_view(axes)
