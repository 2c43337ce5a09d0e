"""Picture of a look-up table: surfaces, slices, and where there is no answer."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from trackctl.lut.table import Status, Table
from trackctl.plots import style
from trackctl.plots.style import Array

SIDES = ("left", "right")
#: Turns that slices are shown of.
SLICES = 5
#: Cells along a side of a surface; more only make the file large.
SURFACE_CELLS = 60
#: Half the width of the cell of a heading that is the only one. [deg]
ALONE = 5.0
#: How cells without an answer are filled.
FILLS: dict[Status, dict[str, Any]] = {
    Status.INFEASIBLE_GRIP: {"facecolor": "#E4E4E4", "hatch": "////"},
    Status.INFEASIBLE_LIFTOFF: {"facecolor": "#CFCFCF", "hatch": "\\\\\\\\"},
    Status.INFEASIBLE_PITCHOVER: {"facecolor": "#BDBDBD", "hatch": "----"},
    Status.OUTSIDE_MODEL: {"facecolor": "#F4F4F4", "hatch": "...."},
    Status.NOT_CONVERGED: {"facecolor": "#F0B9A8", "hatch": "xxxx"},
}
FILLED: dict[str, Any] = {"levels": [0.5, 1.5]}
NEVER: dict[str, Any] = {"facecolor": style.PALE, "hatch": "||||"}
WORDS = {status: status.name.lower().replace("_", ": ", 1).replace("not: ", "not ") for status in Status} | {
    Status.OUTSIDE_MODEL: "outside the model"
}


def draw_table(table: Table, slope: int, velocity: int) -> Figure:
    """Both sprocket rates over heading and curvature at one slope and speed, and where the table has no answer.

    Parameters
    ----------
    table
        The table.
    slope, velocity
        Indices of the slope and of the speed that is shown.
    """
    axes = table.axes
    speed, angle = axes.velocity[velocity], np.degrees(axes.slope[slope])
    figure = style.page(f"{table.vehicle.name} on {table.terrain.name}, slope {angle:.4g}°", 3, 7.6)
    grid = figure.add_gridspec(3, 2, height_ratios=(1.35, 1.0, 1.0))
    for column, side in enumerate(SIDES):
        rates = table.values[f"sprocket_rate_{side}"][slope, velocity]
        surface: Any = figure.add_subplot(grid[0, column], projection="3d", computed_zorder=False)
        draw_surface(surface, table, rates)
        slices = figure.add_subplot(grid[1, column])
        draw_slices(slices, table, rates)
        style.caption(surface, column, f"{side.capitalize()} sprocket rate at {speed:.4g} m/s [rad/s]")
        style.caption(slices, column + 2, f"Slices: {side} sprocket rate at {speed:.4g} m/s")
    reasons, fastest = (figure.add_subplot(grid[2, column]) for column in (0, 1))
    draw_reasons(reasons, table, slope, velocity)
    draw_fastest(figure, fastest, table, slope)
    style.caption(reasons, 4, f"No answer at {speed:.4g} m/s")
    style.caption(fastest, 5, "Fastest turn with an answer")
    style.legend_below(figure, handles(table, slope, velocity))
    return figure


def draw_surface(axes: Any, table: Table, rates: Array) -> None:
    """A surface over heading and curvature, and its shadow on the floor where it has a gap."""
    heading, values = closed(table, rates)
    if heading.size == 1:  # a ribbon
        heading, values = edges(heading), np.repeat(values, 2, axis=1)
    x, y = np.meshgrid(heading, table.axes.curvature)
    gap = np.isnan(rates)
    low, high = (0.0, 1.0) if gap.all() else (float(np.nanmin(rates)), float(np.nanmax(rates)))
    floor = low - 0.15 * (high - low) - 1e-9
    colours = mpl.colormaps[style.SEQUENTIAL](mpl.colors.Normalize(low, high)(values))
    settings = {"rcount": SURFACE_CELLS, "ccount": SURFACE_CELLS, "shade": False, "antialiased": False}
    if gap.any():
        axes.contourf(*stepped(table, gap), **FILLED, colors=[style.GREY], zdir="z", offset=floor)
    axes.plot_surface(x, y, values, facecolors=colours, linewidth=0.0, **settings)
    for row in shown_turns(table.axes.curvature, rates):
        axes.plot(x[row], y[row], values[row], color=style.BLACK, linewidth=0.6, zorder=3)
    axes.set_zlim(floor, high)
    axes.set_xlabel("Heading [°]", labelpad=-4)
    axes.set_ylabel("Curvature [1/m]", labelpad=-3)
    axes.set_xticks(range(0, 361, 90))
    axes.tick_params(pad=-2)
    axes.view_init(elev=28.0, azim=-52.0)
    axes.set_box_aspect((1.25, 1.25, 0.8), zoom=1.05)


def draw_slices(axes: Axes, table: Table, rates: Array) -> None:
    """Rates over the heading at a few turns from straight to the tightest."""
    heading, values = closed(table, rates)
    for number, row in enumerate(shown_turns(table.axes.curvature, rates)):
        styled = style.series(number)
        axes.plot(heading, values[row], markevery=style.markers_every(heading.size, number), **styled)
    style.heading_axis(axes)
    axes.set_ylabel("Rate [rad/s]")


def draw_reasons(axes: Axes, table: Table, slope: int, velocity: int) -> None:
    """Why there is no answer, over heading and curvature at one speed."""
    status = table.status[slope, velocity]
    for reason in present(status):
        draw_cells(axes, table, status == reason, FILLS[reason])
    map_axes(axes, table)


def draw_fastest(figure: Figure, axes: Axes, table: Table, slope: int) -> None:
    """The highest speed that has an answer, over heading and curvature."""
    solved = table.status[slope] == Status.CONVERGED
    fastest = np.where(solved, table.axes.velocity[:, None, None], -np.inf).max(axis=0)
    heading, speeds = closed(table, fastest)
    x, y = edges(heading), edges(table.axes.curvature)
    mesh = axes.pcolormesh(
        x, y, np.ma.masked_invalid(speeds), vmin=0.0, vmax=float(table.axes.velocity[-1]), rasterized=True
    )
    draw_cells(axes, table, np.isinf(fastest), NEVER)
    map_axes(axes, table)
    figure.colorbar(mesh, ax=axes, label="Speed [m/s]", pad=0.02)


def draw_cells(axes: Axes, table: Table, where: NDArray[np.bool_], fill: dict[str, Any]) -> None:
    """Fill the cells where something holds."""
    if not where.any():
        return
    axes.contourf(*stepped(table, where), **FILLED, colors=[fill["facecolor"]], hatches=[fill["hatch"]])


def stepped(table: Table, where: NDArray[np.bool_]) -> tuple[Array, Array, Array]:
    """Headings, curvatures and a function that is 1 in the cells where something holds and 0 in the others.

    It jumps at the borders of the cells, so that a contour follows them.
    """
    heading, inside = closed(table, where.astype(np.float64))
    x, y = np.repeat(edges(heading), 2)[1:-1], np.repeat(edges(table.axes.curvature), 2)[1:-1]
    grid_x, grid_y = np.meshgrid(x, y)
    return grid_x, grid_y, np.repeat(np.repeat(inside, 2, axis=0), 2, axis=1)


def map_axes(axes: Axes, table: Table) -> None:
    """Heading and curvature of a map."""
    style.heading_axis(axes)
    curvature = edges(table.axes.curvature)
    axes.set_ylim(curvature[0], curvature[-1])
    axes.set_ylabel("Curvature [1/m]")
    axes.grid(False)


def edges(nodes: Array) -> Array:
    """Borders of the cells around nodes, halfway between them."""
    if nodes.size == 1:
        return np.array([nodes[0] - ALONE, nodes[0] + ALONE])
    middle = 0.5 * (nodes[1:] + nodes[:-1])
    return np.concatenate(([2.0 * nodes[0] - middle[0]], middle, [2.0 * nodes[-1] - middle[-1]]))


def closed(table: Table, values: Array) -> tuple[Array, Array]:
    """Headings in degrees and values over (curvature, heading), on to 360 degrees where they go full circle."""
    heading = np.degrees(table.axes.heading)
    if not table.axes.heading_is_periodic:
        return heading, values
    return np.append(heading, heading[0] + 360.0), np.concatenate((values, values[:, :1]), axis=1)


def shown_turns(curvature: Array, rates: Array) -> list[int]:
    """Indices of straight driving and of a few left turns, evenly spread on to the tightest that has an answer."""
    answered = curvature[np.isfinite(rates).any(axis=1)]
    wanted = np.linspace(0.0, max(answered.max(initial=0.0), 0.0), SLICES)
    nearest = [int(np.abs(curvature - value).argmin()) for value in wanted]
    return list(dict.fromkeys(nearest))


def present(status: NDArray[np.uint8]) -> list[Status]:
    """Reasons for no answer among cells."""
    return [each for each in Status if each is not Status.CONVERGED and np.any(status == each)]


def handles(table: Table, slope: int, velocity: int) -> list[Line2D | Patch]:
    """The legend: the turns of the slices, and the reasons for no answer."""
    found: list[Line2D | Patch] = []
    rates = table.values["sprocket_rate_left"][slope, velocity]
    for number, row in enumerate(shown_turns(table.axes.curvature, rates)):
        radius = table.axes.radius[row]
        label = f"R = {radius:.4g} m" if np.isfinite(radius) else "straight"
        found.append(Line2D([], [], label=label, **style.series(number)))
    for reason in present(table.status[slope, velocity]):
        found.append(Patch(label=WORDS[reason], edgecolor=style.GREY, linewidth=0.4, **FILLS[reason]))
    if np.any(table.status[slope, velocity] != Status.CONVERGED):
        found.append(Patch(label="no answer (floor of a, b)", facecolor=style.GREY))
    if np.any(np.all(table.status[slope] != Status.CONVERGED, axis=0)):
        found.append(Patch(label="no answer at any speed", edgecolor=style.GREY, linewidth=0.4, **NEVER))
    return found
