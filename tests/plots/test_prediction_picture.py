import numpy as np
import pytest
from figure_artists import labelled
from plot_examples import by_name, prediction

from trackctl.plots.prediction import ELLIPSES, draw_prediction


@pytest.fixture
def columns():
    return by_name(prediction())


def test_positions_in_their_ellipses(columns):
    path = draw_prediction(columns).axes[0]
    np.testing.assert_array_equal(labelled(path, "predicted positions"), (columns["x"], columns["y"]))
    assert path.get_title("left") == "(a) Positions 2 s ahead"
    assert len(path.patches) == ELLIPSES
    for ellipse in path.patches:
        row = int(np.searchsorted(columns["x"], ellipse.center[0]))
        assert ellipse.center == pytest.approx((columns["x"][row], columns["y"][row]))
        assert ellipse.width == pytest.approx(4.0 * columns["x_std"][row])
        assert ellipse.height == pytest.approx(4.0 * columns["y_std"][row])


def test_deviations_and_errors(columns):
    position, heading = draw_prediction(columns).axes[2:]
    np.testing.assert_array_equal(labelled(position, "_standard deviation of x"), (columns["time"], columns["x_std"]))
    np.testing.assert_array_equal(labelled(position, "_standard deviation of y")[1], columns["y_std"])
    np.testing.assert_array_equal(labelled(position, "_error")[1], columns["position_error"])
    assert not [line for line in position.get_lines() if line.get_label() == "error without slip"]
    whole = draw_prediction(columns | {"no_slip_position_error": columns["time"]}).axes[2]
    np.testing.assert_array_equal(labelled(whole, "_error without slip")[1], columns["time"])
    np.testing.assert_allclose(labelled(heading, "_standard deviation")[1], np.degrees(columns["yaw_std"]))
    assert [line.get_label() for line in heading.get_lines()] == ["_standard deviation", "standard deviation"]
    assert (position.get_ylabel(), heading.get_ylabel()) == ("Distance [m]", "Angle [°]")


def test_several_horizons(columns):
    figure = draw_prediction(columns | {"horizon": np.linspace(1.0, 3.0, 51)})
    assert figure.axes[0].get_title("left") == "(a) Positions 1 to 3 s ahead"
