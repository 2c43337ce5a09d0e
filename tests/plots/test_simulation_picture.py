import numpy as np
import pytest
from figure_artists import labelled, legend_texts, line_data
from plot_examples import TURN, by_name, simulation

from trackctl.geometry.circle import fitted_circle
from trackctl.plots.laps import laps
from trackctl.plots.simulation import NAMED_LAPS, draw_simulation


@pytest.fixture
def columns():
    return by_name(simulation())


def test_laps_are_whole_turns():
    yaw = np.linspace(0.3, 0.3 + 4.5 * np.pi, 901)
    assert laps(yaw) == [slice(0, 400), slice(400, 800)]
    assert laps(-yaw) == laps(yaw)
    assert laps((yaw + np.pi) % (2.0 * np.pi) - np.pi) == laps(yaw)
    assert laps(yaw[:400]) == []
    assert laps(yaw[:1]) == []
    assert laps(yaw[:401]) == [slice(0, 400)]


def test_a_circle_is_found_exactly():
    angle = np.linspace(0.0, 1.0, 7)
    circle = fitted_circle(1e5 + 3.0 * np.cos(angle), -2e5 + 3.0 * np.sin(angle))
    assert (circle.x, circle.y, circle.radius) == pytest.approx((1e5, -2e5, 3.0))


def test_a_drifting_lap_has_its_circle_in_the_middle(columns):
    """The drift of a lap moves the fitted centre by its mean, half of it, plus what it turns with the path."""
    first, second = (fitted_circle(columns["x"][lap], columns["y"][lap]) for lap in laps(columns["yaw"]))
    assert second.x - first.x == pytest.approx(0.4, abs=0.01)
    assert second.y - first.y == pytest.approx(-0.1, abs=0.01)


def test_the_path_and_its_laps(columns):
    figure = draw_simulation(columns)
    path, legend = figure.axes[:2]
    x, y = labelled(path, "path")
    np.testing.assert_array_equal(x, columns["x"])
    np.testing.assert_array_equal(y, columns["y"])
    assert labelled(path, "start") == ([columns["x"][0]], [columns["y"][0]])
    texts = [text.get_text() for text in legend.get_legend().get_texts()]
    for number, lap in enumerate(laps(columns["yaw"]), start=1):
        circle = fitted_circle(columns["x"][lap], columns["y"][lap])
        label = f"lap {number}: ({circle.x:.3f}, {circle.y:.3f}) m, R = {circle.radius:.3f} m"
        assert label in texts
        assert labelled(path, label) == ([circle.x], [circle.y])
    circles = [line.get_xydata() for line in path.get_lines() if len(line.get_xdata()) == 181]
    assert len(circles) == 2
    assert np.hypot(*(circles[1] - (circle.x, circle.y)).T) == pytest.approx(circle.radius)
    assert (path.get_xlabel(), path.get_ylabel(), path.get_aspect()) == ("x [m]", "y [m]", 1.0)


def test_what_the_tracks_do(columns):
    tracks, body, slips, loads = draw_simulation(columns).axes[2:]
    for axes, name, factor in ((tracks, "track_speed", 1.0), (slips, "slip", 100.0), (loads, "load", 1.0)):
        for number, side in enumerate(("left", "right")):
            time, values = line_data(axes, number)
            np.testing.assert_array_equal(time, columns["time"])
            np.testing.assert_array_equal(values, factor * columns[f"{name}_{side}"])
    np.testing.assert_array_equal(line_data(body, 0)[1], columns["forward_velocity"])
    np.testing.assert_array_equal(line_data(body, 1)[1], columns["lateral_velocity"])
    labels = [axes.get_ylabel() for axes in (tracks, body, slips, loads)]
    assert labels == ["Speed [m/s]", "Speed [m/s]", "Slip [%]", "Load [N]"]
    assert loads.get_xlabel() == "Time [s]"


def test_legend(columns):
    assert legend_texts(draw_simulation(columns)) == ["left track", "right track", "forward", "lateral"]


def test_many_laps_do_not_overflow_the_legend(columns):
    many = columns | {"yaw": 10.0 * TURN}
    legend = draw_simulation(many).axes[1].get_legend()
    assert len(legend.get_texts()) == 2 + NAMED_LAPS
    assert legend.get_texts()[-1].get_text().startswith("lap 22:")


@pytest.mark.parametrize("rows", [1, 2])
def test_a_vehicle_at_rest(columns, rows):
    still = {name: np.full(rows, values[0]) for name, values in columns.items()}
    draw_simulation(still).canvas.draw()
