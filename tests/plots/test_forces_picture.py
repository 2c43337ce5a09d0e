import numpy as np
import pytest
from figure_artists import labelled, legend_texts, line_data, span_edges
from plot_examples import by_name, forces

from trackctl.plots.forces import draw_forces


@pytest.fixture
def columns():
    return by_name(forces())


def test_curves_over_the_arc_length(columns):
    figure = draw_forces(columns)
    path, speed, gradient, angle, sums, tracks, offset, moment = figure.axes
    np.testing.assert_array_equal(line_data(path), (columns["x"], columns["y"]))
    for axes, values in (
        (speed, columns["speed"]),
        (gradient, columns["yaw_gradient"]),
        (angle, np.degrees(columns["slip_angle"])),
        (offset, columns["icr_offset"]),
        (moment, columns["friction_moment"]),
    ):
        np.testing.assert_array_equal(line_data(axes), (columns["arc_length"], values))
        assert axes.get_xlabel() == "Arc length [m]"
    for axes, label, name in (
        (sums, "total", "force_total"),
        (sums, "right minus left", "force_difference"),
        (tracks, "left track", "force_left"),
        (tracks, "right track", "force_right"),
    ):
        np.testing.assert_array_equal(labelled(axes, label)[1], columns[name])


def test_units(columns):
    labels = [axes.get_ylabel() for axes in draw_forces(columns).axes]
    assert labels == [
        "y [m]",
        "Speed [m/s]",
        "dθ/ds [1/m]",
        "Angle [°]",
        "Force [N]",
        "Force [N]",
        "Offset [m]",
        "Moment [N m]",
    ]


def test_what_is_not_feasible_is_hatched(columns):
    figure = draw_forces(columns)
    way, wrong = columns["arc_length"], np.flatnonzero(columns["feasible"] == 0.0)
    for axes in figure.axes[1:]:
        (stretch,) = axes.patches
        assert stretch.get_hatch()
        begin, end = span_edges(stretch)
        assert way[wrong[0] - 1] < begin < way[wrong[0]]
        assert way[wrong[-1]] < end < way[wrong[-1] + 1]
    assert legend_texts(figure) == ["total", "right minus left", "left track", "right track", "not feasible"]
    feasible = draw_forces(columns | {"feasible": np.ones(way.size)})
    assert not [axes for axes in feasible.axes if axes.patches]
    assert "not feasible" not in legend_texts(feasible)


def test_simulated_motion_beside_the_nominal_one(columns):
    simulated = columns | {
        "simulated_x": columns["x"] + 0.03,
        "simulated_y": columns["y"] - 0.04,
        "simulated_speed": 1.01 * columns["speed"],
        "simulated_yaw_rate": 0.202 * columns["speed"],
        "simulated_slip_angle": columns["slip_angle"] + 0.01,
    }
    figure = draw_forces(simulated)
    path, speed, gradient, angle, *others = figure.axes
    np.testing.assert_array_equal(labelled(path, "simulated"), (simulated["simulated_x"], simulated["simulated_y"]))
    np.testing.assert_array_equal(labelled(speed, "simulated")[1], simulated["simulated_speed"])
    np.testing.assert_allclose(labelled(gradient, "simulated")[1], 0.2, rtol=1e-12)
    np.testing.assert_array_equal(labelled(angle, "simulated")[1], np.degrees(simulated["simulated_slip_angle"]))
    assert "simulated within 5.0e-02 m" in path.get_title(loc="left")
    assert legend_texts(figure)[0] == "simulated"
    assert all("simulated" not in [line.get_label() for line in axes.get_lines()] for axes in others)
