import pytest
from figure_artists import legend_texts
from matplotlib.container import BarContainer, ErrorbarContainer

from trackctl.plots.sensitivity import DUMMY, draw_sensitivity
from trackctl.sensitivity.pawn import PawnIndex, Statistic

INDICES = [
    PawnIndex(output, name, statistic, 0.1 * k + shift, 0.1 * k, 0.1 * k + 0.09, 0.05 + 0.01 * k)
    for output, shift in (("sprocket_rate_left", 0.02), ("sprocket_rate_right", 0.03))
    for k, name in enumerate(("velocity", "radius", "heading"), start=1)
    for statistic in Statistic
]


def test_bars_intervals_and_dummies_are_the_indices():
    figure = draw_sensitivity(INDICES)
    assert [axes.get_title("left") for axes in figure.axes] == ["(a) Sprocket rate left", "(b) Sprocket rate right"]
    for axes, indices in zip(figure.axes, (INDICES[:6], INDICES[6:]), strict=True):
        bars = [bar for each in axes.containers if isinstance(each, BarContainer) for bar in each]
        assert [bar.get_height() for bar in bars] == [index.index for index in indices]
        intervals = [each for each in axes.containers if isinstance(each, ErrorbarContainer)]
        for interval, index in zip(intervals, indices, strict=True):
            _, _, (reach,) = interval.lines
            (low, high) = reach.get_segments()[0][:, 1]
            assert (low, high) == pytest.approx((index.ci_low, index.ci_high))
        dummies = [line for line in axes.get_lines() if line.get_color() == DUMMY["color"]]
        for dummy, bar, index in zip(dummies, bars, indices, strict=True):
            assert list(dummy.get_ydata()) == [index.dummy, index.dummy]
            assert list(dummy.get_xdata()) == pytest.approx([bar.get_x(), bar.get_x() + bar.get_width()])
        assert [label.get_text() for label in axes.get_xticklabels()] == ["Velocity", "Radius", "Heading"]
    assert figure.axes[0].get_ylabel() == "Index [–]"


def test_statistics_differ_in_grey_and_are_told():
    figure = draw_sensitivity(INDICES)
    median, largest = figure.axes[0].patches[:2]
    assert median.get_hatch() != largest.get_hatch()
    assert legend_texts(figure) == [
        "median over the slices",
        "max over the slices",
        "confidence interval",
        "dummy threshold",
    ]


def test_one_output_and_one_input():
    figure = draw_sensitivity(INDICES[:1])
    assert len(figure.axes) == 1
    figure.canvas.draw()
