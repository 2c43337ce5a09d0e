import numpy as np
import pytest
from figure_artists import labelled, line_data
from plot_examples import by_name, identification

from trackctl.plots import style
from trackctl.plots.identification import draw_identification


@pytest.fixture
def columns():
    return by_name(identification())


def band(axes, number):
    """Lower and upper border of a band, in the order of the rows."""
    vertices = axes.collections[number].get_paths()[0].vertices
    rows = (len(vertices) - 3) // 2
    return vertices[1 : rows + 1, 1], vertices[rows + 2 : -1, 1][::-1]


def check_band(axes, number, middle, deviation):
    low, high = band(axes, number)
    np.testing.assert_allclose(0.5 * (low + high), middle, atol=1e-12)
    np.testing.assert_allclose(high - low, 4.0 * deviation)


def test_turning_centres_in_their_bands(columns):
    sides, ahead = draw_identification(columns).axes[:2]
    np.testing.assert_array_equal(labelled(sides, "left track"), (columns["time"], columns["icr_left"]))
    np.testing.assert_array_equal(labelled(sides, "right track")[1], columns["icr_right"])
    np.testing.assert_array_equal(line_data(ahead)[1], columns["icr_x"])
    check_band(sides, 0, columns["icr_left"], columns["p7_std"])
    check_band(sides, 1, columns["icr_right"], columns["p8_std"])
    check_band(ahead, 0, columns["icr_x"], columns["p9_std"])
    assert sides.get_title("left") == "(a) Turning centres of the tracks, bands of the offsets"


def test_turning_centres_with_deviations_of_their_own(columns):
    own = {f"{name}_std": np.full(200, 0.3) for name in ("icr_left", "icr_right", "icr_x")}
    sides, ahead = draw_identification(columns | own).axes[:2]
    for axes, number, name in ((sides, 0, "icr_left"), (sides, 1, "icr_right"), (ahead, 0, "icr_x")):
        check_band(axes, number, columns[name], own[f"{name}_std"])
    assert sides.get_title("left") == "(a) Turning centres of the tracks"


def test_parameters_in_their_bands(columns):
    panels = draw_identification(columns).axes[2:5]
    for axes, names in zip(panels, (("p1", "p2", "p7"), ("p3", "p4", "p8"), ("p5", "p6", "p9")), strict=True):
        for number, (name, unit) in enumerate(zip(names, ("s²", "m²", "m"), strict=True)):
            np.testing.assert_array_equal(labelled(axes, f"{name} [{unit}]")[1], columns[name])
            check_band(axes, number, columns[name], columns[f"{name}_std"])


def test_bands_run_out_of_the_picture_only_at_the_start(columns):
    axes = draw_identification(columns).axes[2]
    lowest, highest = axes.get_ylim()
    for number in range(3):
        low, high = band(axes, number)
        assert high[0] > highest
        assert np.all((low[20:] >= lowest) & (high[20:] <= highest))


def test_errors_beside_those_without_slip(columns):
    position, yaw = draw_identification(columns).axes[6:]
    for axes, label, values in (
        (position, "identified, mean 0.05", columns["position_error"]),
        (position, "no slip, mean 0.7", columns["no_slip_position_error"]),
        (yaw, "identified, mean 0.573", np.degrees(np.abs(columns["yaw_error"]))),
    ):
        np.testing.assert_allclose(labelled(axes, f"_{label}")[1], values)
        np.testing.assert_array_equal(labelled(axes, label)[1], style.running_mean(values))
    assert (position.get_ylabel(), yaw.get_ylabel()) == ("Error [m]", "Error [°]")
    assert position.get_ylim()[0] == 0.0


def test_rejected_poses_are_crossed(columns):
    axes = draw_identification(columns).axes[5]
    np.testing.assert_array_equal(labelled(axes, "rejected")[0], columns["time"][[49, 99, 149, 199]])
    np.testing.assert_allclose(labelled(axes, "pose updates")[1], 0.05 * np.abs(np.cos(columns["time"])))


def test_nothing_known_at_all(columns):
    empty = {name: np.full(3, np.nan) for name in columns} | {"time": np.arange(3.0), "accepted": np.ones(3)}
    draw_identification(empty).canvas.draw()
