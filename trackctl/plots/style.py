"""The one style of all figures: for print in two columns or one, readable without colour.

Figures are made without pyplot, so that there is no global state, and inside `applied()`, both drawn and saved.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, cast

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.projections.polar import PolarAxes
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: What the drawing functions return.
Picture = Figure
#: Columns of a file in SI by their names without unit.
Columns = Mapping[str, Array]

#: Width of a page's text. [in]
PAGE_WIDTH = 7.2
PANEL_HEIGHT = 2.1
POINTS_PER_INCH = 72.0
#: Share of a curve's rows that its running mean is taken over.
SMOOTHED = 0.02
#: Of a legend: the sample of a line, and a letter of its label. [pt]
HANDLE_WIDTH, LETTER_WIDTH = 38.0, 3.9

# After Okabe and Ito: told apart by the colour-blind, and here in an order of changing lightness.
BLACK, BLUE, VERMILION, GREEN, ORANGE, SKY, PURPLE = (
    "#000000",
    "#0072B2",
    "#D55E00",
    "#009E73",
    "#E69F00",
    "#56B4E9",
    "#9A4F96",
)
GREY, PALE = "#707070", "#E4E4E4"
#: Lightness alone tells values apart in these.
SEQUENTIAL = "cividis"

COLOURS = (BLACK, BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)
DASHES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (5, 1.5, 1, 1.5)), (0, (1, 1)), (0, (8, 1.5, 1, 1.5, 1, 1.5)))
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">")
HATCHES = ("////", "\\\\\\\\", "xxxx", "....", "++++", "oooo")

LEFT: dict[str, Any] = {"color": BLUE, "linestyle": "-"}
RIGHT: dict[str, Any] = {"color": VERMILION, "linestyle": (0, (5, 1.5))}
#: What is asked for, or would be without slip, beside what is.
REFERENCE: dict[str, Any] = {"color": GREY, "linestyle": (0, (2, 1.5)), "linewidth": 0.9}
#: Where there is no answer, or no feasible one.
NO_ANSWER: dict[str, Any] = {"facecolor": PALE, "edgecolor": GREY, "hatch": "////", "linewidth": 0.0}

STYLE: dict[str, Any] = {
    "font.family": "DejaVu Sans",  # comes with matplotlib: the same everywhere
    "font.size": 7.5,
    "mathtext.fontset": "dejavusans",
    "axes.titlesize": 8.0,
    "axes.titlelocation": "left",
    "axes.labelsize": 7.5,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "axes.xmargin": 0.01,
    "grid.color": "#D0D0D0",
    "grid.linewidth": 0.4,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.2,
    "lines.markersize": 3.5,
    "hatch.linewidth": 0.4,
    "hatch.color": GREY,
    "legend.fontsize": 7.0,
    "legend.framealpha": 0.9,
    "legend.edgecolor": "#B0B0B0",
    "legend.fancybox": False,
    "legend.handlelength": 2.6,
    "figure.titlesize": 9.0,
    "image.cmap": SEQUENTIAL,
    "agg.path.chunksize": 20_000,  # longer curves are refused in one piece
    "savefig.dpi": 300,
    "svg.fonttype": "path",
    "svg.hashsalt": "trackctl",  # else random, and no two files the same
    "pdf.fonttype": 42,
}


@contextmanager
def applied() -> Iterator[None]:
    """Draw and save in this style, whatever the user's settings."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(cast(Any, STYLE))
        yield


def page(title: str, rows: int, height: float | None = None) -> Figure:
    """An empty page for panels in so many rows; the title says what was computed, the panels what they show."""
    figure = Figure(figsize=(PAGE_WIDTH, height or rows * PANEL_HEIGHT + 0.6), layout="constrained")
    figure.suptitle(title)
    return figure


def panels(figure: Figure, rows: int, columns: int, **settings: Any) -> list[Axes]:
    """Panels of a page, row by row."""
    return list(figure.subplots(rows, columns, squeeze=False, **settings).ravel())


def path_beside_times(figure: Figure, rows: int) -> tuple[Axes, Axes, list[Axes]]:
    """Panels for a path, for its legend below, and on the right a column of panels over time."""
    halves: Any = figure.subfigures(1, 2, width_ratios=(1.2, 1.0))
    path, legend = halves[0].subplots(2, 1, height_ratios=(3.0, 1.0))
    return path, legend, list(halves[1].subplots(rows, 1, sharex=True))


def legend_apart(place: Axes, axes: Axes) -> None:
    """The legend of a panel in a place of its own."""
    place.axis("off")
    place.legend(*axes.get_legend_handles_labels(), loc="upper center", frameon=False)


def caption(axes: Axes, number: int, text: str) -> None:
    """Title of a panel: (a), (b), ... and what it shows."""
    axes.set_title(f"({chr(ord('a') + number)}) {text}", loc="left")


def series(number: int) -> dict[str, Any]:
    """Line and marker of one of several curves: 315 combinations before one comes back."""
    return {
        "color": COLOURS[number % len(COLOURS)],
        "linestyle": DASHES[number % len(DASHES)],
        "marker": MARKERS[number % len(MARKERS)],
    }


def markers_every(count: int, number: int, wanted: int = 12) -> tuple[int, int]:
    """First marker and step that put about `wanted` on a curve of so many points, other curves' beside them."""
    step = max(count // wanted, 1)
    return (number * step // 3) % step, step


def heading_axis(axes: Axes) -> None:
    """The full circle of headings, in degrees."""
    axes.set_xlim(0.0, 360.0)
    axes.set_xticks(range(0, 361, 45))
    axes.set_xlabel("Heading from up-slope [°]")


def compass(axes: PolarAxes) -> None:
    """Headings as they lie on the slope: up-slope above, counter-clockwise."""
    axes.set_theta_zero_location("N")
    axes.set_thetagrids(range(0, 360, 45), [f"{angle}°" for angle in range(0, 360, 45)])
    axes.tick_params(axis="x", pad=0)
    axes.set_rlabel_position(22.5)
    axes.yaxis.set_major_locator(MaxNLocator(4))


def legend_below(figure: Figure, handles: Sequence[Any]) -> None:
    """One legend for all panels of a page, in as many columns as fit."""
    lengths = [len(str(handle.get_label())) for handle in handles]
    columns = next((count for count in range(len(handles), 1, -1) if legend_width(lengths, count) <= PAGE_WIDTH), 1)
    figure.legend(handles=handles, loc="outside lower center", ncols=columns, frameon=False)


def legend_width(lengths: Sequence[int], columns: int) -> float:
    """Width of a legend whose labels, so many letters long, are dealt to columns. [in]"""
    longest = [max(part) for part in np.array_split(np.asarray(lengths), columns)]
    return (columns * HANDLE_WIDTH + LETTER_WIDTH * float(sum(longest))) / POINTS_PER_INCH


def plan_view(axes: Axes) -> None:
    """The plane of the path, to scale."""
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")


def arrows(axes: Axes, x: Array, y: Array, count: int = 5) -> None:
    """Arrowheads along a path, in the direction of travel."""
    if x.size < 2:
        return
    way = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))))
    for share in (np.arange(count) + 0.5) / count:
        place = min(int(np.searchsorted(way, share * way[-1])), x.size - 2)
        axes.annotate(
            "",
            xy=(x[place + 1], y[place + 1]),
            xytext=(x[place], y[place]),
            arrowprops={"arrowstyle": "-|>", "color": BLACK, "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0},
        )


def both_tracks(axes: Axes, x: Array, columns: Columns, name: str, factor: float = 1.0) -> None:
    """A quantity of the left and of the right track."""
    axes.plot(x, factor * columns[f"{name}_left"], label="left track", **LEFT)
    axes.plot(x, factor * columns[f"{name}_right"], label="right track", **RIGHT)


def noisy(axes: Axes, x: Array, values: Array, label: str, look: Mapping[str, Any]) -> None:
    """A curve that jumps from row to row, faint, and its running mean."""
    axes.plot(x, values, label=f"_{label}", alpha=0.35, **(dict(look) | {"linestyle": "-", "linewidth": 0.4}))
    axes.plot(x, running_mean(values), label=label, **look)


def running_mean(values: Array) -> Array:
    """Mean over a `SMOOTHED` share of the rows around each, NaN left out; NaN where there is nothing else."""
    known = np.isfinite(values)
    reach = int(0.5 * SMOOTHED * values.size)
    first = np.maximum(np.arange(values.size) - reach, 0)
    last = np.minimum(np.arange(values.size) + reach + 1, values.size)
    counts = np.concatenate(([0], np.cumsum(known)))
    sums = np.concatenate(([0.0], np.cumsum(np.where(known, values, 0.0))))
    with np.errstate(invalid="ignore"):
        return np.asarray((sums[last] - sums[first]) / (counts[last] - counts[first]), np.float64)


def shade(axes: Axes, x: Array, where: NDArray[np.bool_], label: str) -> None:
    """Hatch the stretches of x where something holds, under the label once."""
    for start, end in stretches(where):
        low = x[start] if start == 0 else 0.5 * (x[start - 1] + x[start])
        high = x[end - 1] if end == x.size else 0.5 * (x[end - 1] + x[end])
        axes.axvspan(low, high, zorder=0.5, label=label, **NO_ANSWER)
        label = "_"


def stretches(where: NDArray[np.bool_]) -> Iterable[tuple[int, int]]:
    """First and one past last index of each run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], where, [False])).astype(np.int8)))
    return zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
