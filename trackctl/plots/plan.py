"""Picture of a planned trajectory: path on its map, speeds, commands, slips."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.transforms import Affine2D
from numpy.typing import NDArray

from trackctl.plots import style
from trackctl.plots.style import Array, Columns

#: Poses of the body that are marked along a path, and places with an arrow up-slope.
POSES, SLOPES = 25, 7
#: Ground less steep than this is level. [rad]
LEVEL = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class MapImage:
    """A map to lay under a path.

    Attributes
    ----------
    lightness : ndarray, shape (n_rows, n_columns)
        0 occupied to 1 free, the top row first.
    resolution
        Width of a pixel. [m]
    origin
        x [m], y [m] and yaw [rad] of the lower left corner.
    """

    lightness: Array
    resolution: float
    origin: tuple[float, float, float]


def draw_plan(columns: Columns, ground: MapImage | None = None, outline: Array | None = None) -> Figure:
    """The path, with the body's heading, and over time what the tracks are told and do.

    Parameters
    ----------
    columns
        `time`, `x`, `y`, `yaw`, `velocity`, `sprocket_rate_left` and `_right`, `sideslip`, `slip_left` and `_right`,
        `segment`, and `slope` and `heading` where the slope is to be shown. [SI]
    ground
        The map, if there is one.
    outline : ndarray, shape (n, 2)
        The body's about its mass centre, to be drawn at intervals, if it is known. [m]
    """
    figure = style.page("Planned trajectory", 3, 6.2)
    path, legend, (speed, rates, slips, sideslip) = style.path_beside_times(figure, 4)
    time = columns["time"]
    draw_path(path, columns, ground)
    if outline is not None:
        draw_outlines(path, columns, outline)
    style.caption(path, 0, "Path of the mass centre")
    style.legend_apart(legend, path)
    speed.plot(time, columns["velocity"], color=style.BLACK)
    style.both_tracks(rates, time, columns, "sprocket_rate")
    style.both_tracks(slips, time, columns, "slip", 100.0)
    sideslip.plot(time, np.degrees(columns["sideslip"]), color=style.BLACK)
    texts = (
        (speed, "Speed", "Speed [m/s]"),
        (rates, "Sprocket commands", "Rate [rad/s]"),
        (slips, "Slips, above 0 driving", "Slip [%]"),
        (sideslip, "Sideslip", "Angle [°]"),
    )
    for number, (axes, text, label) in enumerate(texts, start=1):
        style.caption(axes, number, text)
        axes.set_ylabel(label)
        for border in segment_borders(columns):
            axes.axvline(time[border], **style.REFERENCE)
    sideslip.set_xlabel("Time [s]")
    style.legend_below(figure, rates.get_lines()[:2])
    return figure


def draw_path(axes: Axes, columns: Columns, ground: MapImage | None) -> None:
    """The path on its map, with start, goal, the body's heading, and where segments meet."""
    if ground is not None:
        draw_map(axes, ground)
    x, y, yaw = columns["x"], columns["y"], columns["yaw"]
    axes.plot(x, y, color=style.BLUE, label="path")
    marked = poses_marked(columns)
    axes.quiver(
        x[marked],
        y[marked],
        np.cos(yaw[marked]),
        np.sin(yaw[marked]),
        color=style.VERMILION,
        width=0.004,
        scale=25.0,
        zorder=3,
        label="heading of the body",
    )
    draw_slope(axes, columns)
    axes.plot(x[0], y[0], color=style.BLACK, marker="o", markersize=6, linestyle="", label="start")
    axes.plot(x[-1], y[-1], color=style.BLACK, marker="*", markersize=9, linestyle="", label="goal")
    borders = segment_borders(columns)
    if borders.size:
        axes.plot(x[borders], y[borders], color=style.GREY, marker="|", linestyle="", label="end of a segment")
    style.plan_view(axes)


def draw_slope(axes: Axes, columns: Columns) -> None:
    """Arrows up-slope along the path, where the ground is not level."""
    if "slope" not in columns or "heading" not in columns or columns["slope"].max() < LEVEL:
        return
    low, high = np.degrees((columns["slope"].min(), columns["slope"].max()))
    steepness = f"{high:.3g}°" if high - low < 0.05 else f"{low:.3g} to {high:.3g}°"
    marked = np.unique(np.linspace(0, columns["x"].size - 1, SLOPES).round().astype(np.intp))
    uphill = (columns["yaw"] - columns["heading"])[marked]
    axes.quiver(
        *(columns[name][marked] for name in ("x", "y")),
        np.cos(uphill),
        np.sin(uphill),
        color=style.GREY,
        width=0.003,
        scale=12.0,
        zorder=2,
        label=f"up-slope, {steepness}",
    )


def draw_outlines(axes: Axes, columns: Columns, outline: Array) -> None:
    """The body's outline at intervals of the path."""
    marked = poses_marked(columns)
    closed = np.append(outline, outline[:1], axis=0)
    places = [
        np.stack(
            (
                x + np.cos(yaw) * closed[:, 0] - np.sin(yaw) * closed[:, 1],
                y + np.sin(yaw) * closed[:, 0] + np.cos(yaw) * closed[:, 1],
            ),
            axis=1,
        )
        for x, y, yaw in zip(*(columns[name][marked] for name in ("x", "y", "yaw")), strict=True)
    ]
    axes.add_collection(LineCollection(places, colors=style.GREEN, linewidths=0.5, label="outline of the body"))


def poses_marked(columns: Columns) -> NDArray[np.intp]:
    """Rows at which the body is drawn."""
    return np.unique(np.linspace(0, columns["x"].size - 1, POSES).round().astype(np.intp))


def draw_map(axes: Axes, ground: MapImage) -> None:
    """A map, occupied dark, in its place."""
    rows, columns = ground.lightness.shape
    x, y, yaw = ground.origin
    image = axes.imshow(
        ground.lightness,
        cmap="gray",
        vmin=0.0,
        vmax=1.0,
        extent=(0.0, columns * ground.resolution, 0.0, rows * ground.resolution),
        interpolation="nearest",
    )
    place = Affine2D().rotate(yaw).translate(x, y)
    image.set_transform(place + axes.transData)
    width, height = columns * ground.resolution, rows * ground.resolution
    corners = place.transform([(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)])
    axes.update_datalim(corners)
    axes.autoscale()
    axes.grid(False)


def segment_borders(columns: Columns) -> NDArray[np.intp]:
    """Rows at which a new segment begins, but the first."""
    return np.flatnonzero(np.diff(columns["segment"]) != 0.0) + 1
