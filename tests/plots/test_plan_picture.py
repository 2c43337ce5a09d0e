import math

import numpy as np
import pytest
from figure_artists import labelled, line_data
from plot_examples import by_name, plan

from trackctl.plots.plan import MapImage, draw_plan


@pytest.fixture
def columns():
    return by_name(plan())


def test_the_path_with_its_ends_and_segments(columns):
    path = draw_plan(columns).axes[0]
    np.testing.assert_array_equal(labelled(path, "path"), (columns["x"], columns["y"]))
    assert labelled(path, "start") == ([0.0], [0.0])
    assert labelled(path, "goal") == ([columns["x"][-1]], [columns["y"][-1]])
    np.testing.assert_array_equal(labelled(path, "end of a segment")[0], columns["x"][[40, 80]])
    assert path.get_aspect() == 1.0


def labelled_arrows(columns, label):
    (arrows,) = [each for each in draw_plan(columns).axes[0].collections if each.get_label() == label]
    return arrows


def test_arrows_show_the_heading_of_the_body(columns):
    arrows = labelled_arrows(columns, "heading of the body")
    marked = np.searchsorted(columns["x"], arrows.X)
    np.testing.assert_allclose(arrows.U, np.cos(columns["yaw"][marked]))
    np.testing.assert_allclose(arrows.V, np.sin(columns["yaw"][marked]))


def test_what_the_tracks_are_told(columns):
    figure = draw_plan(columns)
    speed, rates, slips, sideslip = figure.axes[2:]
    np.testing.assert_array_equal(line_data(speed), (columns["time"], columns["velocity"]))
    np.testing.assert_array_equal(line_data(rates, 0)[1], columns["sprocket_rate_left"])
    np.testing.assert_array_equal(line_data(rates, 1)[1], columns["sprocket_rate_right"])
    np.testing.assert_array_equal(line_data(slips, 1)[1], 100.0 * columns["slip_right"])
    np.testing.assert_allclose(line_data(sideslip)[1], np.degrees(columns["sideslip"]))
    labels = [axes.get_ylabel() for axes in figure.axes[2:]]
    assert labels == ["Speed [m/s]", "Rate [rad/s]", "Slip [%]", "Angle [°]"]


def test_the_map_lies_where_it_belongs(columns):
    lightness = np.ones((20, 30))
    lightness[0, 0] = 0.0  # the upper left corner
    ground = MapImage(lightness, 0.5, (1.0, -2.0, math.radians(90.0)))
    figure = draw_plan(columns, ground)
    figure.canvas.draw()
    path = figure.axes[0]
    (image,) = path.images
    np.testing.assert_array_equal(image.get_array(), lightness)
    to_data = image.get_transform() - path.transData
    # A quarter turn about the lower left corner takes the upper left one to the left of it.
    np.testing.assert_allclose(to_data.transform([(0.0, 0.0), (0.0, 10.0)]), [(1.0, -2.0), (-9.0, -2.0)], atol=1e-9)
    (low_x, high_x), (low_y, high_y) = path.get_xlim(), path.get_ylim()
    assert low_x <= -9.0 < 10.0 <= high_x
    assert low_y <= -2.0 < 13.0 <= high_y


def test_one_segment_has_no_borders(columns):
    figure = draw_plan(columns | {"segment": np.zeros(101)})
    assert not [line for line in figure.axes[0].get_lines() if line.get_label() == "end of a segment"]
    assert len(figure.axes[2].get_lines()) == 1


def test_arrows_show_up_slope_where_the_ground_is_not_level(columns):
    """Heading is yaw less the direction of up-slope."""

    def slopes(slope):
        with_slope = columns | {"slope": slope, "heading": columns["yaw"] - 0.7}
        found = draw_plan(with_slope).axes[0].collections
        return [each for each in found if str(each.get_label()).startswith("up-slope")]

    assert slopes(np.zeros_like(columns["x"])) == []
    (arrows,) = slopes(np.full_like(columns["x"], math.radians(12.0)))
    assert arrows.get_label() == "up-slope, 12°"
    np.testing.assert_allclose(arrows.U, math.cos(0.7))
    np.testing.assert_allclose(arrows.V, math.sin(0.7))
    (arrows,) = slopes(np.radians(np.linspace(2.0, 20.0, columns["x"].size)))
    assert arrows.get_label() == "up-slope, 2 to 20°"
