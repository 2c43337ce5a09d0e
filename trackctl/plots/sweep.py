"""Pictures of a sweep over slopes, speeds and headings: the paper's figures 7 to 14 and tables 1 to 3."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.projections.polar import PolarAxes

from trackctl.plots import style
from trackctl.plots.style import Array, Columns

#: Quantities that tell curves apart, with symbol, unit and factor from SI.
KEYS = {
    "slope": ("θ", "°", float(np.degrees(1.0))),
    "velocity": ("v", " m/s", 1.0),
    "radius": ("R", " m", 1.0),
}
#: From SI to what people read on an axis.
FACTORS = {"heading": float(np.degrees(1.0))} | {name: factor for name, (_, _, factor) in KEYS.items()}
#: Radii beyond so many times the desired one run out of the picture: there the tracks run nearly equally fast.
SHOWN_RADII = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Rows of a sweep that make up one line.

    Attributes
    ----------
    number, label
        In the order of the legend.
    radius
        Of the turn, negative to the right. [m]
    place
        What they are drawn over, ascending; angles in degrees.
    columns
        The columns, in the same order.
    """

    number: int
    label: str
    radius: float
    place: Array
    columns: Columns

    def __getitem__(self, name: str) -> Array:
        """A column."""
        return self.columns[name]


def draw_sweep(columns: Columns) -> Figure:
    """Track speeds, slips and theoretical radius over the heading, one curve per slope, speed and radius.

    Parameters
    ----------
    columns
        `slope`, `velocity`, `radius`, `heading`, `track_speed_inner` and `_outer`, `body_speed_inner` and `_outer`,
        `slip_inner` and `_outer`, `theoretical_radius`; NaN without an answer. [SI]
    """
    curves = curves_over(columns, "heading")
    figure = style.page(title_of(columns), 3)
    grid = figure.add_gridspec(3, 2, height_ratios=(1.0, 1.0, 1.35))
    for column, side in enumerate(("outer", "inner")):
        speeds, slips = (figure.add_subplot(grid[row, column]) for row in (0, 1))
        draw_speeds(speeds, curves, side)
        draw_slips(slips, curves, side)
        style.caption(speeds, column, f"{side.capitalize()} track: output and driving speed")
        style.caption(slips, column + 2, f"{side.capitalize()} track: slip")
    cartesian = figure.add_subplot(grid[2, 0])
    polar: Any = figure.add_subplot(grid[2, 1], projection="polar")
    draw_radii(cartesian, curves)
    draw_polar_radii(polar, curves)
    style.caption(cartesian, 4, "Theoretical radius of the track speeds")
    style.caption(polar, 5, "The same on the slope, 0° up")
    style.legend_below(figure, handles(curves))
    return figure


def curves_over(columns: Columns, over: str) -> list[Curve]:
    """The rows as lines over one of the columns, one for each combination of the other keys."""
    names = [name for name in KEYS if name != over]
    keys, membership = np.unique(np.column_stack([columns[name] for name in names]), axis=0, return_inverse=True)
    varying = [name for name, values in zip(names, keys.T, strict=True) if np.ptp(values) > 0.0]
    curves = []
    for number, key in enumerate(keys):
        values = dict(zip(names, key.tolist(), strict=True))
        label = ", ".join(shown(name, values[name]) for name in varying) or "all rows"
        rows = np.flatnonzero(membership == number)
        rows = rows[np.argsort(columns[over][rows], kind="stable")]
        own = {name: column[rows] for name, column in columns.items()}
        curves.append(Curve(number, label, values["radius"], FACTORS[over] * own[over], own))
    return curves


def shown(name: str, value: float) -> str:
    """A quantity as people write it."""
    symbol, unit, factor = KEYS[name]
    return f"{symbol} = {value * factor:.4g}{unit}"


def title_of(columns: Columns) -> str:
    """What all turns of a sweep have in common."""
    common = [shown(name, abs(columns[name][0])) for name in KEYS if np.ptp(columns[name]) == 0.0]
    turns = {1.0: "left turns", -1.0: "right turns"}.get(float(np.sign(columns["radius"]).mean()), "turns")
    return f"Tracks in {turns} over all headings" + (": " + ", ".join(common) if common else "")


def draw_speeds(axes: Axes, curves: list[Curve], side: str) -> None:
    """Speed of a track over the hull, and that of the hull over the ground beneath it."""
    for curve in curves:
        axes.plot(curve.place, curve[f"body_speed_{side}"], **style.REFERENCE)
        plot(axes, curve, curve[f"track_speed_{side}"])
    style.heading_axis(axes)
    axes.set_ylabel("Speed [m/s]")


def draw_slips(axes: Axes, curves: list[Curve], side: str) -> None:
    """Slip of a track."""
    for curve in curves:
        plot(axes, curve, 100.0 * curve[f"slip_{side}"])
    axes.axhline(0.0, color=style.BLACK, linewidth=0.6)
    style.heading_axis(axes)
    axes.set_ylabel("Slip [%], above 0 driving")


def draw_radii(axes: Axes, curves: list[Curve]) -> None:
    """Radius of the turn that the track speeds would give without slip."""
    for curve in curves:
        heading, radius = without_jumps(curve.place, turn_radius(curve))
        plot(axes, curve, radius, heading)
    desired = desired_radii(curves)
    for wanted in desired:
        axes.axhline(wanted, **style.REFERENCE)
    style.heading_axis(axes)
    axes.set_ylabel("Radius [m]")
    low, high = axes.get_ylim()
    axes.set_ylim(max(low, -SHOWN_RADII * desired[-1]), min(high, SHOWN_RADII * desired[-1]))


def draw_polar_radii(axes: PolarAxes, curves: list[Curve]) -> None:
    """The same over the headings as they lie on the slope."""
    for curve in curves:
        angle, radius = curve["heading"], turn_radius(curve)
        if np.isclose(angle[-1] + angle[1 % angle.size] - angle[0], 2.0 * np.pi):
            angle, radius = np.append(angle, angle[0]), np.append(radius, radius[0])
        styled = style.series(curve.number) | {"marker": ""}
        axes.plot(angle, np.where(radius > 0.0, radius, np.nan), **styled)
    circle = np.linspace(0.0, 2.0 * np.pi, 181)
    desired = desired_radii(curves)
    for wanted in desired:
        axes.plot(circle, np.full(circle.size, wanted), **style.REFERENCE)
    style.compass(axes)
    axes.set_rlim(0.0, min(axes.get_rmax(), SHOWN_RADII * desired[-1]))
    axes.yaxis.set_major_formatter("{x:g} m")


def desired_radii(curves: list[Curve]) -> list[float]:
    """Radii of the turns, ascending. [m]"""
    return sorted({abs(curve.radius) for curve in curves})


def turn_radius(curve: Curve) -> Array:
    """Theoretical radius, positive into the turn, NaN where the tracks run equally fast. [m]"""
    radius = curve["theoretical_radius"] * np.sign(curve.radius)
    return np.where(np.isfinite(radius), radius, np.nan)


def without_jumps(x: Array, values: Array) -> tuple[Array, Array]:
    """A curve with a gap wherever a radius changes its sign, which it does by way of infinity."""
    jumps = np.flatnonzero(values[1:] * values[:-1] < 0.0)
    return np.insert(x, jumps + 1, x[jumps]), np.insert(values, jumps + 1, np.nan)


def plot(axes: Axes, curve: Curve, values: Array, heading: Array | None = None) -> None:
    """A curve over the heading."""
    axes.plot(
        curve.place if heading is None else heading,
        values,
        label=curve.label,
        markevery=style.markers_every(values.size, curve.number),
        **style.series(curve.number),
    )


def handles(curves: list[Curve]) -> list[Line2D]:
    """The legend: the curves, what they are compared with, and what a gap means."""
    lines = [Line2D([], [], label=curve.label, **style.series(curve.number)) for curve in curves]
    lines.append(Line2D([], [], label="driving speed; desired radius", **style.REFERENCE))
    if any(np.isnan(curve["track_speed_outer"]).any() for curve in curves):
        lines.append(Line2D([], [], linestyle="", label="gap: no equilibrium"))
    return lines
