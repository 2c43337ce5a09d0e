"""Picture of nominal track forces along a path, after the figures 5 to 9 of Shiller, Serate and Hua (1993)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from trackctl.plots import style
from trackctl.plots.style import Array, Columns

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
        `force_left`, `force_right`, `friction_moment`, `feasible`; NaN where there is no solution. With `simulated_x`,
        `simulated_y`, `simulated_speed`, `simulated_yaw_rate` and `simulated_slip_angle`, the simulated motion is drawn
        beside the nominal one. [SI]
    """
    figure = style.page("Nominal track forces", 4, 7.6)
    path, *others = style.panels(figure, 4, 2)
    way = columns["arc_length"]
    draw_path(path, columns)
    style.caption(path, 0, path_caption(columns))
    singles, (sums, tracks, offset, moment) = others[:3], others[3:]
    for axes, (name, factor, _, _) in zip(singles, SINGLE, strict=True):
        axes.plot(way, factor * columns[name], color=style.BLACK)
    for axes, x, y in simulated_curves((path, *singles), columns):
        axes.plot(x, y, color=style.ORANGE, linestyle=style.DASHES[1], label="simulated")
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
    simulated = [line for line in path.get_lines() if line.get_label() == "simulated"]
    style.legend_below(figure, [*simulated, *sums.get_lines(), *tracks.get_lines(), *hatched])
    return figure


def path_caption(columns: Columns) -> str:
    """What the path's panel shows, and how far the simulated mass centre strays from the nominal one."""
    if not is_simulated(columns):
        return "Path"
    strayed = np.hypot(columns["simulated_x"] - columns["x"], columns["simulated_y"] - columns["y"])
    return f"Path, simulated within {np.nanmax(strayed):.1e} m"


def is_simulated(columns: Columns) -> bool:
    """Whether the simulated motion is among the columns."""
    return all(f"simulated_{name}" in columns for name in ("x", "y", "speed", "yaw_rate", "slip_angle"))


def simulated_curves(panels: Sequence[Axes], columns: Columns) -> list[tuple[Axes, Array, Array]]:
    """Simulated curves of the panels of path, speed, yaw gradient and slip angle; none without a simulation."""
    if not is_simulated(columns):
        return []
    way, speed = columns["arc_length"], columns["simulated_speed"]
    # The gradient of a vehicle at rest is not defined.
    gradient = columns["simulated_yaw_rate"] / np.where(speed > 0.0, speed, np.nan)
    angle = np.degrees(columns["simulated_slip_angle"])
    curves = ((columns["simulated_x"], columns["simulated_y"]), (way, speed), (way, gradient), (way, angle))
    return [(axes, x, y) for axes, (x, y) in zip(panels, curves, strict=True)]


def draw_path(axes: Axes, columns: Columns) -> None:
    """The path with its start and direction."""
    x, y = columns["x"], columns["y"]
    axes.plot(x, y, color=style.BLACK)
    axes.plot(x[0], y[0], color=style.BLACK, marker="o", markersize=5)
    style.arrows(axes, x, y)
    style.plan_view(axes)
