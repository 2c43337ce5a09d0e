import math
from dataclasses import replace

import numpy as np
import pytest
from figure_artists import legend_texts
from files.lut_examples import example_table
from matplotlib.colors import to_rgba
from solved_tables import CURVATURE, HEADING, VELOCITY, solved_table

from trackctl.lut.axes import Axes
from trackctl.lut.table import Status
from trackctl.plots import style
from trackctl.plots.table import FILLS, WORDS, closed, draw_table, edges, shown_turns


@pytest.fixture(scope="module")
def table():
    return solved_table()


@pytest.fixture
def figure(table):
    """The table at its highest speed."""
    return draw_table(table, 0, VELOCITY.size - 1)


def test_slices_are_rows_of_the_table(figure, table):
    left, right = figure.axes[1], figure.axes[3]
    for axes, side in ((left, "left"), (right, "right")):
        rates = table.values[f"sprocket_rate_{side}"][0, -1]
        shown = shown_turns(CURVATURE, rates)
        assert len(axes.get_lines()) == len(shown) > 2
        for line, row in zip(axes.get_lines(), shown, strict=True):
            np.testing.assert_allclose(line.get_xdata(), [*np.degrees(HEADING), 360.0])
            np.testing.assert_array_equal(line.get_ydata(), [*rates[row], rates[row][0]])
        assert axes.get_ylabel() == "Rate [rad/s]"


def test_surfaces_and_their_lines(figure, table):
    for axes, side in ((figure.axes[0], "left"), (figure.axes[2], "right")):
        rates = table.values[f"sprocket_rate_{side}"][0, -1]
        assert (axes.get_xlabel(), axes.get_ylabel()) == ("Heading [°]", "Curvature [1/m]")
        assert axes.get_zlim() == pytest.approx(
            (np.nanmin(rates) - 0.15 * np.ptp(rates[np.isfinite(rates)]), np.nanmax(rates))
        )
        for line, row in zip(axes.get_lines(), shown_turns(CURVATURE, rates), strict=True):
            x, y, z = line.get_data_3d()
            np.testing.assert_array_equal(z[:-1], rates[row])
            assert set(y) == {CURVATURE[row]}
            assert x[-1] == 360.0


def test_the_floor_is_dark_where_there_is_no_answer(figure):
    shadow, _ = figure.axes[0].collections
    assert set(map(tuple, shadow.get_facecolor())) == {to_rgba(style.GREY)}
    full = draw_table(example_table(slopes=1, velocities=2), 0, 1)
    assert len(full.axes[0].collections) == 1
    assert "no answer (floor of a, b)" in legend_texts(figure)
    assert "no answer (floor of a, b)" not in legend_texts(full)


def covered(collection):
    """Nodes of the table in the area that is filled; the headings at the very border left out."""
    paths = collection.get_paths()
    nodes = [[(math.degrees(heading), curvature) for heading in HEADING[1:]] for curvature in CURVATURE]
    return np.array([[any(path.contains_point(node) for path in paths) for node in row] for row in nodes])


def test_cells_without_an_answer_are_hatched_by_reason(figure, table):
    status = table.status[0, -1]
    found = [reason for reason in Status if np.any(status == reason)][1:]
    assert Status.INFEASIBLE_GRIP in found
    for cells, reason in zip(figure.axes[4].collections, found, strict=True):
        assert cells.hatches == [FILLS[reason]["hatch"]]
        np.testing.assert_array_equal(covered(cells), status[:, 1:] == reason)
    assert {WORDS[reason] for reason in found} <= set(legend_texts(figure))


def test_fastest_turns(figure, table):
    mesh, *never = figure.axes[5].collections
    solved = table.status[0] == Status.CONVERGED
    expected = np.where(solved, VELOCITY[:, None, None], np.nan)
    expected = np.where(solved.any(axis=0), np.nanmax(expected, axis=0, initial=0.0), np.nan)
    np.testing.assert_array_equal(mesh.get_array().filled(np.nan)[:, :-1], expected)
    if never:
        np.testing.assert_array_equal(covered(never[0]), np.isnan(expected[:, 1:]))
    assert ("no answer at any speed" in legend_texts(figure)) == np.isnan(expected).any()
    assert figure.axes[6].get_ylabel() == "Speed [m/s]"


def test_page(figure):
    assert figure.get_suptitle() == "utv-61cm on asphalt, slope 12°"
    titles = {axes.get_title("left") for axes in figure.axes}
    assert {"(a) Left sprocket rate at 2 m/s [rad/s]", "(d) Slices: right sprocket rate at 2 m/s"} <= titles
    assert legend_texts(figure)[0] == "straight"


def test_every_reason_has_a_fill_and_a_word():
    table = example_table(slopes=1, velocities=1, curvatures=5, headings=4)
    figure = draw_table(table, 0, 0)
    assert len({fill["hatch"] for fill in FILLS.values()}) == len(FILLS) == len(Status) - 1
    assert [collection.hatches[0] for collection in figure.axes[4].collections] == [
        fill["hatch"] for fill in FILLS.values()
    ]
    assert {
        "infeasible: grip",
        "infeasible: liftoff",
        "infeasible: pitchover",
        "outside the model",
        "not converged",
    } <= set(legend_texts(figure))
    assert "no answer at any speed" in legend_texts(figure)


def test_a_table_without_any_answer():
    table = example_table(slopes=1)
    empty = {name: np.full_like(values, np.nan) for name, values in table.values.items()}
    figure = draw_table(replace(table, values=empty, status=np.ones_like(table.status)), 0, 0)
    figure.canvas.draw()


def test_one_heading_is_a_ribbon():
    table = example_table(slopes=1, headings=1)
    figure = draw_table(replace(table, axes=replace(table.axes, heading_is_periodic=False)), 0, 2)
    figure.canvas.draw()
    assert len(figure.axes[0].collections[-1].get_facecolor()) > 0


def test_slices_reach_the_tightest_turn_with_an_answer():
    curvature = np.linspace(-1.0, 1.0, 21)
    rates = np.where(np.abs(curvature)[:, None] > 0.45, np.nan, 1.0)
    assert curvature[shown_turns(curvature, rates)] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert curvature[shown_turns(curvature, np.full_like(rates, np.nan))] == pytest.approx([0.0])


def test_edges_lie_between_the_nodes():
    assert list(edges(np.array([0.0, 1.0, 3.0]))) == [-0.5, 0.5, 2.0, 4.0]
    low, high = edges(np.array([90.0]))
    assert low < 90.0 < high


def test_headings_that_do_not_go_round_are_not_closed():
    part = replace(solved_table(), axes=Axes(np.zeros(1), VELOCITY, CURVATURE, HEADING, heading_is_periodic=False))
    heading, values = closed(part, np.ones((CURVATURE.size, HEADING.size)))
    assert (heading.size, values.shape) == (HEADING.size, (CURVATURE.size, HEADING.size))
