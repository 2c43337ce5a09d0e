import numpy as np
import pytest
from figure_artists import labelled, look
from plot_examples import by_name, prediction

from trackctl.plots.prediction import ELLIPSES, HORIZONS, draw_prediction, successive


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


@pytest.fixture
def motions(columns):
    """With the poses around each prediction, for 0.2 m/s sideways without slip."""
    time = columns["time"]
    later = np.where(time <= 8.0, 1.0, np.nan)
    known = {"start_x": time, "start_y": 0.1 * time, "no_slip_x": time + 2.0, "no_slip_y": 0.1 * time - 0.4}
    return columns | known | {"actual_x": (time + 1.9) * later, "actual_y": (0.1 * time + 0.1) * later}


ENDS = {"predicted": "", "predicted without slip": "no_slip_", "where it was": "actual_"}


def test_motions_lead_from_one_start_to_three_ends(motions):
    path = draw_prediction(motions).axes[0]
    starts = [0, 10, 20, 30, 40, 50]
    for label, prefix in ENDS.items():
        x, y = labelled(path, label)
        np.testing.assert_array_equal(x[::3], motions["start_x"][starts])
        np.testing.assert_array_equal(y[::3], motions["start_y"][starts])
        np.testing.assert_array_equal(x[1::3], motions[f"{prefix}x"][starts])
        np.testing.assert_array_equal(y[1::3], motions[f"{prefix}y"][starts])
        assert np.isnan(x[2::3]).all()
    np.testing.assert_array_equal(labelled(path, "log")[1], motions["start_y"])
    np.testing.assert_array_equal(labelled(path, "start")[0], motions["start_x"][starts])
    assert [ellipse.center[0] for ellipse in path.patches] == motions["x"][starts].tolist()
    assert path.get_title("left") == "(a) Motions over 2 s, from 0 to 10 s"


def test_motions_are_told_apart_in_grey(motions):
    lines = [line for line in draw_prediction(motions).axes[0].get_lines() if line.get_label() in ENDS]
    assert len({look(line) for line in lines}) == 3
    assert all(line.get_markevery() == (1, 3) for line in lines)


def test_of_a_long_log_the_motions_in_its_middle_are_shown(motions):
    often = {name: np.repeat(values, 10) for name, values in motions.items()}
    often["time"] = 0.2 * np.arange(510)
    path = draw_prediction(often).axes[0]
    assert path.get_title("left") == "(a) Motions over 2 s, from 38 to 60 s"
    assert len(path.patches) == HORIZONS


def test_motions_go_on_after_gaps_and_a_clock_set_back():
    time = np.array([0.0, 1.0, 2.0, 3.0, 9.0, 10.0, 4.0, 5.0, 6.0])
    assert successive(time, np.full(9, 2.0)).tolist() == [0, 2, 4, 6, 8]


def test_without_positions_there_are_no_motions(motions):
    blind = {name: np.full(51, np.nan) if name[-1] in "xy" else values for name, values in motions.items()}
    figure = draw_prediction(blind)
    figure.canvas.draw()
    assert figure.axes[0].get_title("left") == "(a) Positions 2 s ahead"
