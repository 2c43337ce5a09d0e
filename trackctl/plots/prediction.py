"""Picture of predicted motion: where the vehicle will be, how surely, and how far off that was."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from numpy.typing import NDArray

from trackctl.plots import style
from trackctl.plots.style import Array, Columns

#: Standard deviations that an ellipse reaches.
SPREAD = 2.0
#: Ellipses along a path.
ELLIPSES = 30
#: Two times are one within this. [s]
SAME_TIME = 1e-6
#: Horizons whose motion is shown; of a longer log those in its middle.
HORIZONS = 12
#: Where a motion over the horizon ends: prefix of the columns, label and look.
ENDS: tuple[tuple[str, str, dict[str, Any]], ...] = (
    ("no_slip_", "predicted without slip", style.RIGHT | {"marker": "s", "markerfacecolor": "white"}),
    ("", "predicted", style.LEFT | {"marker": "o"}),
    ("actual_", "where it was", {"color": style.BLACK, "linestyle": style.DASHES[3], "marker": "^", "markersize": 5.0}),
)
#: What it takes to show motions rather than where they end.
MOTIONS = {f"{pose}{axis}" for pose in ("start_", *(prefix for prefix, _, _ in ENDS)) for axis in "xy"}
#: Caption, label, factor, deviations and errors of each panel, those being shown that are known.
UNCERTAINTY: tuple[tuple[str, str, float, dict[str, str], dict[str, str]], ...] = (
    (
        "Position",
        "Distance [m]",
        1.0,
        {"x_std": "standard deviation of x", "y_std": "standard deviation of y"},
        {"no_slip_position_error": "error without slip", "position_error": "error"},
    ),
    (
        "Heading",
        "Angle [°]",
        float(np.degrees(1.0)),
        {"yaw_std": "standard deviation"},
        {"no_slip_yaw_error": "error without slip", "yaw_error": "error"},
    ),
)
ERRORS = {"error": style.LEFT, "error without slip": style.RIGHT}
DEVIATIONS: tuple[dict[str, Any], ...] = (
    {"color": style.BLACK, "linestyle": style.DASHES[2]},
    {"color": style.GREEN, "linestyle": style.DASHES[3]},
)


def draw_prediction(columns: Columns) -> Figure:
    """Predicted motions or positions with their ellipses, and deviations and errors over time.

    Parameters
    ----------
    columns
        `time`, `horizon`, `x`, `y`, `yaw`, `x_std`, `y_std`, `yaw_std`, and where known `position_error`, `yaw_error`,
        `no_slip_position_error`, `no_slip_yaw_error`; may be NaN. With `start_x`, `start_y`, `no_slip_x`, `no_slip_y`,
        `actual_x` and `actual_y` motions are shown as in figure 14 of the paper on ICRs. [SI]
    """
    figure = style.page("Predicted motion; bold lines are running means", 2, 5.2)
    path, legend, times = style.path_beside_times(figure, len(UNCERTAINTY))
    if columns.keys() >= MOTIONS and np.isfinite(columns["start_x"]).any():
        style.caption(path, 0, draw_motions(path, columns))
    else:
        style.caption(path, 0, draw_path(path, columns))
    style.legend_apart(legend, path)
    for number, (axes, panel) in enumerate(zip(times, UNCERTAINTY, strict=True), start=1):
        text, label, factor, deviations, errors = panel
        for name in (name for name in errors if name in columns):
            error = factor * np.abs(columns[name])
            style.noisy(axes, columns["time"], error, errors[name], ERRORS[errors[name]])
        for (name, words), look in zip(deviations.items(), DEVIATIONS, strict=False):
            style.noisy(axes, columns["time"], factor * columns[name], words, look)
        axes.set_ylim(bottom=0.0)
        axes.legend()
        style.caption(axes, number, text)
        axes.set_ylabel(label)
    times[-1].set_xlabel("Time [s]")
    return figure


def draw_motions(axes: Axes, columns: Columns) -> str:
    """One motion after the other, from its start to where it was to end and did; returns the caption."""
    starts = successive(columns["time"], columns["horizon"])
    first = max(0, (starts.size - HORIZONS) // 2)
    shown = starts[first : first + HORIZONS]
    span = slice(shown[0], shown[-1] + 1)
    axes.plot(columns["start_x"][span], columns["start_y"][span], color=style.GREY, linewidth=0.6, label="log")
    x, y = columns["start_x"][shown], columns["start_y"][shown]
    axes.plot(x, y, color=style.BLACK, marker="+", markersize=7.0, linestyle="", zorder=3.0, label="start")
    apart = np.full(shown.size, np.nan)
    for prefix, label, look in ENDS:
        ends = (columns[f"{prefix}{axis}"][shown] for axis in "xy")
        joined = [np.stack((start, end, apart), axis=1).ravel() for start, end in zip((x, y), ends, strict=True)]
        axes.plot(*joined, label=label, markevery=(1, 3), **({"linewidth": 0.9} | look))
    draw_ellipses(axes, columns, shown)
    style.plan_view(axes)
    return f"Motions over {ahead(columns)}, from {columns['time'][shown[0]]:g} to {columns['time'][shown[-1]]:g} s"


def successive(time: Array, horizon: Array) -> NDArray[np.intp]:
    """Rows each of which starts where the one before ends, or where the clock was set back."""
    rows, last, end = [0], float(time[0]), float(time[0] + horizon[0])
    for row, (now, ahead) in enumerate(zip(time.tolist(), horizon.tolist(), strict=True)):
        if now < last or now >= end - SAME_TIME:
            rows.append(row)
            end = now + ahead
        last = now
    return np.array(rows)


def draw_path(axes: Axes, columns: Columns) -> str:
    """Predicted positions, some with the ellipse that they lie in; returns the caption."""
    x, y = columns["x"], columns["y"]
    axes.plot(x, y, color=style.BLUE, linewidth=0.8, label="predicted positions")
    draw_ellipses(axes, columns, np.unique(np.linspace(0, x.size - 1, ELLIPSES).round().astype(int)))
    style.plan_view(axes)
    return f"Positions {ahead(columns)} ahead"


def draw_ellipses(axes: Axes, columns: Columns, rows: NDArray[np.intp]) -> None:
    """Ellipses that predicted positions lie in."""
    label = f"{SPREAD:g} standard deviations"
    for row in rows.tolist():
        width, height = 2.0 * SPREAD * columns["x_std"][row], 2.0 * SPREAD * columns["y_std"][row]
        place = columns["x"][row], columns["y"][row]
        axes.add_patch(
            Ellipse(place, width, height, facecolor="none", edgecolor=style.GREY, linewidth=0.6, label=label)
        )
        label = "_"


def ahead(columns: Columns) -> str:
    """The horizon."""
    horizons = np.unique(columns["horizon"])
    return f"{horizons[0]:g} s" if horizons.size == 1 else f"{horizons[0]:g} to {horizons[-1]:g} s"
