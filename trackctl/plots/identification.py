"""Picture of a slip identification: turning centres, parameters with their bands, errors beside those without slip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from trackctl.plots import style
from trackctl.plots.style import Columns

#: Standard deviations to either side of an estimate that a band covers.
SPREAD = 2.0
#: Share of the rows after which bands determine what a panel shows: at first nothing is known.
SETTLED = 0.1


@dataclass(frozen=True, slots=True)
class Estimate:
    """A column, the columns that may hold its standard deviation, the first that is there being taken, and its line."""

    column: str
    deviations: tuple[str, ...]
    label: str
    look: dict[str, Any]


def parameters(*named: tuple[str, str]) -> tuple[Estimate, ...]:
    """Estimates of parameters with their units."""
    looks = (style.series(number) | {"marker": ""} for number in range(len(named)))
    return tuple(
        Estimate(name, (f"{name}_std",), f"{name} [{unit}]", look)
        for (name, unit), look in zip(named, looks, strict=True)
    )


#: By panel: turning centres (whose offsets p7 to p9 are all that is uncertain in straight driving), parameters.
ESTIMATES = (
    (
        Estimate("icr_left", ("icr_left_std", "p7_std"), "left track", style.LEFT),
        Estimate("icr_right", ("icr_right_std", "p8_std"), "right track", style.RIGHT),
    ),
    (Estimate("icr_x", ("icr_x_std", "p9_std"), "both tracks", {"color": style.BLACK}),),
    parameters(("p1", "s²"), ("p2", "m²"), ("p7", "m")),
    parameters(("p3", "s²"), ("p4", "m²"), ("p8", "m")),
    parameters(("p5", "s²"), ("p6", "m²"), ("p9", "m")),
)


def draw_identification(columns: Columns) -> Figure:
    """Turning centres, the parameters behind them, innovations, and errors over the horizon, all over time.

    Parameters
    ----------
    columns
        `time`, `icr_left`, `icr_right`, `icr_x`, `p1` to `p9`, `p1_std` to `p9_std`, `innovation_x`, `innovation_y`,
        `accepted`, `position_error`, `yaw_error`, `no_slip_position_error`, `no_slip_yaw_error`; may be NaN. Where
        there are `icr_left_std`, `icr_right_std` and `icr_x_std`, the turning centres' bands are theirs. [SI]
    """
    figure = style.page(
        f"Identified slip: bands of ±{SPREAD:g} standard deviations, bold running means of errors", 4, 7.8
    )
    panels = style.panels(figure, 4, 2, sharex=True)
    for axes, estimates in zip(panels, ESTIMATES, strict=False):
        draw_estimates(axes, columns, estimates)
    draw_innovations(panels[5], columns)
    draw_errors(panels[6], columns, "position_error")
    draw_errors(panels[7], columns, "yaw_error", float(np.degrees(1.0)))
    whose = "" if "icr_x_std" in columns else ", bands of the offsets"
    texts = (
        (f"Turning centres of the tracks{whose}", "y to the left [m]"),
        (f"Turning centre ahead{whose}", "x ahead [m]"),
        ("Parameters of the left track", "Value"),
        ("Parameters of the right track", "Value"),
        ("Parameters along the body", "Value"),
        ("Innovation of the position", "Distance [m]"),
        ("Position error over the horizon", "Error [m]"),
        ("Heading error over the horizon", "Error [°]"),
    )
    for number, (axes, (text, label)) in enumerate(zip(panels, texts, strict=True)):
        style.caption(axes, number, text)
        axes.set_ylabel(label)
    for axes in panels[-2:]:
        axes.set_xlabel("Time [s]")
    return figure


def draw_estimates(axes: Axes, columns: Columns, estimates: tuple[Estimate, ...]) -> None:
    """Estimates in their bands."""
    time = columns["time"]
    first = int(SETTLED * time.size)
    seen = []
    for estimate in estimates:
        values = columns[estimate.column]
        deviation = next(columns[name] for name in estimate.deviations if name in columns)
        low, high = values - SPREAD * deviation, values + SPREAD * deviation
        axes.plot(time, values, label=estimate.label, **estimate.look)
        axes.fill_between(time, low, high, color=estimate.look["color"], alpha=0.2, linewidth=0.0)
        seen += [values, low[first:], high[first:]]
    axes.legend(ncols=len(estimates))
    shown = np.concatenate(seen)
    if np.isfinite(shown).any():
        middle, half = 0.5 * (np.nanmax(shown) + np.nanmin(shown)), 0.55 * (np.nanmax(shown) - np.nanmin(shown))
        axes.set_ylim(middle - (half or 1.0), middle + (half or 1.0))


def draw_innovations(axes: Axes, columns: Columns) -> None:
    """How far each pose came from where it was expected; rejected ones crossed."""
    time = columns["time"]
    distance = np.hypot(columns["innovation_x"], columns["innovation_y"])
    axes.plot(time, distance, color=style.BLACK, linewidth=0.8, label="pose updates")
    rejected = columns["accepted"] == 0.0
    axes.plot(time[rejected], distance[rejected], color=style.VERMILION, marker="x", linestyle="", label="rejected")
    axes.legend()


def draw_errors(axes: Axes, columns: Columns, name: str, factor: float = 1.0) -> None:
    """Sizes of the errors with the model and without slip, with their running means and means."""
    for column, label, look in ((f"no_slip_{name}", "no slip", style.RIGHT), (name, "identified", style.LEFT)):
        error = factor * np.abs(columns[column])
        mean = f", mean {np.nanmean(error):.3g}" if np.isfinite(error).any() else ""
        style.noisy(axes, columns["time"], error, label + mean, look)
    axes.set_ylim(bottom=0.0)
    axes.legend()
