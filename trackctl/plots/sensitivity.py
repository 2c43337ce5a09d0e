"""Picture of a sensitivity analysis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from trackctl.plots import style
from trackctl.sensitivity.pawn import PawnIndex, Statistic

BARS: dict[Statistic, dict[str, Any]] = {
    Statistic.MEDIAN: {"facecolor": "#5B8DB8", "hatch": ""},
    Statistic.MAX: {"facecolor": "#F2F2F2", "hatch": style.HATCHES[0]},
}
WIDTH = 0.36
INTERVAL: dict[str, Any] = {"linestyle": "", "elinewidth": 0.9}
DUMMY: dict[str, Any] = {"color": style.VERMILION, "linestyle": (0, (3, 1)), "linewidth": 1.4}


def draw_sensitivity(indices: Sequence[PawnIndex]) -> Figure:
    """PAWN indices as bars with their confidence intervals, a panel per output; lines mark the dummy thresholds."""
    outputs = list(dict.fromkeys(index.output for index in indices))
    figure = style.page("PAWN sensitivity indices", 1, 2.9)
    grid = style.panels(figure, 1, len(outputs), sharey=True)
    for number, (axes, output) in enumerate(zip(grid, outputs, strict=True)):
        draw_output(axes, [index for index in indices if index.output == output])
        style.caption(axes, number, words(output))
    grid[0].set_ylabel("Index [–]")
    bars = [Patch(edgecolor=style.BLACK, label=f"{each} over the slices", **BARS[each]) for each in Statistic]
    interval = grid[0].containers[-1]
    dummy = Line2D([], [], label="dummy threshold", **DUMMY)
    style.legend_below(figure, [*bars, interval, dummy])
    return figure


def draw_output(axes: Axes, indices: list[PawnIndex]) -> None:
    """The bars of one output: by input, then by statistic."""
    inputs = list(dict.fromkeys(index.input for index in indices))
    for index in indices:
        offset = -0.5 if index.statistic is Statistic.MEDIAN else 0.5
        place = inputs.index(index.input) + offset * WIDTH
        reach = np.maximum([[index.index - index.ci_low], [index.ci_high - index.index]], 0.0)
        axes.bar(place, index.index, WIDTH, edgecolor=style.BLACK, linewidth=0.6, **BARS[index.statistic])
        axes.errorbar(place, index.index, reach, color=style.BLACK, capsize=3, label="confidence interval", **INTERVAL)
        ends = [place - 0.5 * WIDTH, place + 0.5 * WIDTH]
        axes.plot(ends, [index.dummy, index.dummy], label="_dummy", **DUMMY)
    axes.set_xticks(range(len(inputs)), [words(name) for name in inputs])
    axes.set_xlim(-0.6, len(inputs) - 0.4)
    axes.set_ylim(0.0, 1.0)
    axes.grid(False, axis="x")


def words(name: str) -> str:
    """A name for people."""
    return name.replace("_", " ").capitalize()
