"""Picture of a sweep's summary: the paper's tables 1 to 3."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from trackctl.plots import style
from trackctl.plots.style import Columns
from trackctl.plots.sweep import Curve, curves_over, desired_radii, title_of

LABELS = {"slope": "Slope [°]", "velocity": "Speed [m/s]"}
#: The pair of each panel: names of the upper and the lower one, their words.
ERRORS = (("rmse_outer", "outer track"), ("rmse_inner", "inner track"))
RADII = (("max_radius", "largest"), ("min_radius", "smallest"))
HEADINGS = (("max_radius_heading", "of the largest"), ("min_radius_heading", "of the smallest"))


def draw_sweep_summary(columns: Columns) -> Figure:
    """Errors and extreme theoretical radii over the slope, or where there is one only, over the speed.

    Parameters
    ----------
    columns
        `slope`, `velocity`, `radius`, `rmse_inner`, `rmse_outer`, `max_radius`, `max_radius_heading`, `min_radius`,
        `min_radius_heading`, NaN without an answer, and `infeasible_count`. [SI]
    """
    over = "slope" if np.ptp(columns["slope"]) > 0.0 or np.ptp(columns["velocity"]) == 0.0 else "velocity"
    curves = curves_over(columns, over)
    figure = style.page(title_of(columns), 2)
    errors, radii, headings, missing = style.panels(figure, 2, 2)
    draw_pair(errors, curves, ERRORS)
    errors.set_ylim(bottom=0.0)
    errors.set_ylabel("RMSE [m/s]")
    draw_pair(radii, curves, RADII)
    for radius in desired_radii(curves):
        radii.axhline(radius, **style.REFERENCE)
    radii.set_ylabel("Radius [m]")
    draw_pair(headings, curves, HEADINGS, factor=float(np.degrees(1.0)))
    headings.set_ylim(0.0, 360.0)
    headings.set_yticks(range(0, 361, 45))
    headings.set_ylabel("Heading from up-slope [°]")
    draw_pair(missing, curves, (("infeasible_count", "headings"),))
    missing.set_ylim(0.0, max(1.0, missing.get_ylim()[1]))
    missing.yaxis.set_major_locator(MaxNLocator(integer=True))
    missing.set_ylabel("Headings")
    texts = (
        "Error between driving and output speed",
        "Extremes of the theoretical radius",
        "Headings of these extremes",
        "Headings without an answer",
    )
    for number, (axes, text) in enumerate(zip((errors, radii, headings, missing), texts, strict=True)):
        style.caption(axes, number, text)
        axes.set_xlabel(LABELS[over])
        axes.margins(x=0.05)
    style.legend_below(figure, handles(curves))
    return figure


def draw_pair(axes: Axes, curves: list[Curve], pair: tuple[tuple[str, str], ...], factor: float = 1.0) -> None:
    """One or two values of each curve: the first with full markers, the second with empty ones."""
    for curve in curves:
        for (name, words), fill in zip(pair, ("full", "none"), strict=False):
            styled = style.series(curve.number) | {"fillstyle": fill, "label": f"{words}, {curve.label}"}
            axes.plot(curve.place, np.abs(curve[name]) * factor, **styled)


def handles(curves: list[Curve]) -> list[Line2D]:
    """The legend: the curves, and what the markers tell."""
    several = curves if len(curves) > 1 else []
    lines = [Line2D([], [], label=curve.label, **style.series(curve.number)) for curve in several]
    plain: dict[str, Any] = {"color": style.GREY, "linestyle": "", "marker": "o"}
    lines.append(Line2D([], [], label="outer track; largest radius", **plain))
    lines.append(Line2D([], [], label="inner track; smallest radius", fillstyle="none", **plain))
    lines.append(Line2D([], [], label="desired radius", **style.REFERENCE))
    return lines
