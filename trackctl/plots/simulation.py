"""Picture of a simulated drive: path with its laps, track speeds, slips, loads."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from trackctl.geometry.circle import fitted_circle
from trackctl.plots import style
from trackctl.plots.laps import laps
from trackctl.plots.style import Columns

#: Points of a drawn circle.
POINTS = 181
#: Laps that the legend has room for.
NAMED_LAPS = 6
FORWARD: dict[str, Any] = {"color": style.BLACK, "linestyle": style.DASHES[2]}
LATERAL: dict[str, Any] = {"color": style.GREEN, "linestyle": style.DASHES[3]}


def draw_simulation(columns: Columns) -> Figure:
    """The path with a circle fitted to each lap, and what the tracks do over time.

    Parameters
    ----------
    columns
        `time`, `x`, `y`, `yaw`, `track_speed_left` and `_right`, `slip_left` and `_right`, `load_left` and `_right`.
        [SI]
    """
    figure = style.page("Simulated drive", 3, 6.2)
    path, legend, (tracks, body, slips, loads) = style.path_beside_times(figure, 4)
    draw_path(path, columns)
    style.caption(path, 0, "Path of the mass centre")
    style.legend_apart(legend, path)
    time = columns["time"]
    style.both_tracks(tracks, time, columns, "track_speed")
    style.both_tracks(slips, time, columns, "slip", 100.0)
    style.both_tracks(loads, time, columns, "load")
    body.plot(time, columns["forward_velocity"], label="forward", **FORWARD)
    body.plot(time, columns["lateral_velocity"], label="lateral", **LATERAL)
    texts = (
        (tracks, "Track speeds", "Speed [m/s]"),
        (body, "Body velocity", "Speed [m/s]"),
        (slips, "Slips, above 0 driving", "Slip [%]"),
        (loads, "Loads on the tracks", "Load [N]"),
    )
    for number, (axes, text, label) in enumerate(texts, start=1):
        style.caption(axes, number, text)
        axes.set_ylabel(label)
    loads.set_xlabel("Time [s]")
    style.legend_below(figure, [*tracks.get_lines(), *body.get_lines()])
    return figure


def draw_path(axes: Axes, columns: Columns) -> None:
    """The path, its start and direction, and circles fitted to its laps with their centres."""
    x, y = columns["x"], columns["y"]
    axes.plot(x, y, color=style.BLACK, linewidth=0.8, label="path")
    axes.plot(x[0], y[0], color=style.BLACK, marker="o", markersize=5, linestyle="", label="start")
    style.arrows(axes, x, y)
    angle = np.linspace(0.0, 2.0 * np.pi, POINTS)
    rows = laps(columns["yaw"])
    for number, lap in enumerate(rows, start=1):
        circle = fitted_circle(x[lap], y[lap])
        look = style.series(number)
        axes.plot(
            circle.x + circle.radius * np.cos(angle),
            circle.y + circle.radius * np.sin(angle),
            **(look | {"marker": "", "linewidth": 1.0}),
        )
        label = f"lap {number}: ({circle.x:.3f}, {circle.y:.3f}) m, R = {circle.radius:.3f} m"
        named = number < NAMED_LAPS or number == len(rows)
        axes.plot(circle.x, circle.y, label=label if named else "_", **look)
    style.plan_view(axes)
