import numpy as np
import pytest
from figure_artists import labelled, legend_texts, line_data, span_edges
from plot_examples import by_name, lookup

from trackctl.plots.lookup import draw_lookup


def test_points_and_commands_over_the_rows():
    columns = by_name(lookup())
    columns["curvature"] = 1.0 / columns["radius"]
    figure = draw_lookup(columns)
    velocity, rates, curvature, slips, heading, sideslip = figure.axes
    np.testing.assert_array_equal(line_data(velocity), (np.arange(1.0, 11.0), columns["velocity"]))
    np.testing.assert_array_equal(line_data(curvature)[1], columns["curvature"])
    np.testing.assert_allclose(line_data(heading)[1], np.degrees(columns["heading"]))
    np.testing.assert_allclose(line_data(sideslip)[1], np.degrees(columns["sideslip"]))
    for axes, name, factor in ((rates, "sprocket_rate", 1.0), (slips, "slip", 100.0)):
        for side in ("left", "right"):
            np.testing.assert_array_equal(labelled(axes, f"{side} track")[1], factor * columns[f"{name}_{side}"])
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == ["Speed [m/s]", "Rate [rad/s]", "Curvature [1/m]", "Slip [%]", "Heading [°]", "Angle [°]"]
    for axes in figure.axes:
        (stretch,) = axes.patches
        assert span_edges(stretch) == pytest.approx([7.5, 10.0])
    assert legend_texts(figure) == ["left track", "right track", "no answer"]


def test_a_single_row():
    columns = {name: values[:1] for name, values in by_name(lookup()).items()}
    figure = draw_lookup(columns | {"curvature": 1.0 / columns["radius"]})
    figure.canvas.draw()
    assert legend_texts(figure) == ["left track", "right track"]
