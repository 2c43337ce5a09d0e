"""Picture of predicted motion: where the vehicle will be, how surely, and how far off that was."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from trackctl.plots import style
from trackctl.plots.style import Columns

#: Standard deviations that an ellipse reaches.
SPREAD = 2.0
#: Ellipses along a path.
ELLIPSES = 30
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
    """Predicted positions with their ellipses, and deviations and errors over time.

    Parameters
    ----------
    columns
        `time`, `horizon`, `x`, `y`, `yaw`, `x_std`, `y_std`, `yaw_std`, and where known `position_error`, `yaw_error`,
        `no_slip_position_error`, `no_slip_yaw_error`; may be NaN. [SI]
    """
    figure = style.page("Predicted motion; bold lines are running means", 2, 4.6)
    path, legend, times = style.path_beside_times(figure, len(UNCERTAINTY))
    draw_path(path, columns)
    horizons = np.unique(columns["horizon"])
    ahead = f"{horizons[0]:g} s" if horizons.size == 1 else f"{horizons[0]:g} to {horizons[-1]:g} s"
    style.caption(path, 0, f"Positions {ahead} ahead")
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


def draw_path(axes: Axes, columns: Columns) -> None:
    """Predicted positions, some with the ellipse that they lie in."""
    x, y = columns["x"], columns["y"]
    axes.plot(x, y, color=style.BLUE, linewidth=0.8, label="predicted positions")
    label = f"{SPREAD:g} standard deviations"
    for row in np.unique(np.linspace(0, x.size - 1, ELLIPSES).round().astype(int)).tolist():
        width, height = 2.0 * SPREAD * columns["x_std"][row], 2.0 * SPREAD * columns["y_std"][row]
        ellipse = Ellipse((x[row], y[row]), width, height, facecolor="none", edgecolor=style.GREY, label=label)
        axes.add_patch(ellipse)
        label = "_"
    style.plan_view(axes)
