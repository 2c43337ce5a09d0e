import io

import matplotlib as mpl
import numpy as np
import pytest
from figure_artists import span_edges
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from trackctl.plots import saving, style


def test_series_can_be_told_apart_without_colour():
    looks = {(str(each["linestyle"]), each["marker"]) for each in map(style.series, range(45))}
    assert len(looks) == 45
    assert len({str(style.series(number)) for number in range(315)}) == 315


def test_left_and_right_can_be_told_apart_without_colour():
    assert style.LEFT["linestyle"] != style.RIGHT["linestyle"]


def test_sequential_colours_grow_lighter():
    shades = [to_rgb(mpl.colormaps[style.SEQUENTIAL](share)) for share in np.linspace(0.0, 1.0, 33)]
    lightness = np.array(shades) @ (0.2126, 0.7152, 0.0722)
    assert np.all(np.diff(lightness) > 0.0)


def test_the_style_does_not_depend_on_the_user_and_leaves_no_trace():
    with mpl.rc_context({"lines.linewidth": 9.0, "axes.facecolor": "red"}):
        with style.applied():
            assert (mpl.rcParams["lines.linewidth"], mpl.rcParams["axes.facecolor"]) == (1.2, "white")
        assert (mpl.rcParams["lines.linewidth"], mpl.rcParams["axes.facecolor"]) == (9.0, "red")


def test_captions_are_lettered():
    figure = style.page("Title", 2)
    for number, axes in enumerate(style.panels(figure, 2, 2)):
        style.caption(axes, number, "text")
    assert [axes.get_title("left") for axes in figure.axes] == ["(a) text", "(b) text", "(c) text", "(d) text"]
    assert figure.get_suptitle() == "Title"


@pytest.mark.parametrize(
    ("where", "runs"),
    [([], []), ([0, 0], []), ([1, 1], [(0, 2)]), ([1, 0, 1, 1, 0], [(0, 1), (2, 4)]), ([0, 1], [(1, 2)])],
)
def test_stretches(where, runs):
    assert list(style.stretches(np.array(where, bool))) == runs


def test_running_mean():
    values = np.arange(300.0)
    values[100] = np.nan
    mean = style.running_mean(values)
    assert mean[200] == 200.0  # rows 197 to 203
    assert mean[0] == np.mean([0.0, 1.0, 2.0, 3.0])
    assert mean[101] == np.mean([98.0, 99.0, 101.0, 102.0, 103.0, 104.0])
    np.testing.assert_array_equal(style.running_mean(values[:3]), values[:3])
    assert np.isnan(style.running_mean(np.full(200, np.nan))).all()


def test_shade_reaches_half_way_to_the_neighbours():
    axes = Figure().subplots()
    style.shade(axes, np.array([0.0, 1.0, 2.0, 4.0]), np.array([False, True, False, True]), "bad")
    assert [span_edges(patch) for patch in axes.patches] == [pytest.approx([0.5, 1.5]), pytest.approx([3.0, 4.0])]
    assert [patch.get_label() for patch in axes.patches] == ["bad", "_"]


@pytest.mark.parametrize("labels", [["a"], ["a long label of some words"] * 3, ["v = 2 m/s"] * 20, ["x" * 200]])
def test_a_legend_fits_the_page(labels):
    figure = style.page("", 1)
    style.legend_below(figure, [Line2D([], [], label=label) for label in labels])
    figure.canvas.draw()
    (legend,) = figure.legends
    assert len(legend.get_texts()) == len(labels)
    if max(map(len, labels)) < 100:
        assert legend.get_window_extent().width <= figure.bbox.width


def test_arrows_point_along_the_path():
    axes = Figure().subplots()
    x = np.linspace(0.0, 9.0, 10)
    style.arrows(axes, x, 0.0 * x, count=3)
    for arrow in axes.texts:
        assert arrow.xy[0] > arrow.get_position()[0]
    style.arrows(axes, x[:1], x[:1])
    assert len(axes.texts) == 3


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_the_same_figure_gives_the_same_bytes(tmp_path, suffix):
    def saved(name):
        figure = style.page("Title", 1)
        figure.subplots().fill_between([0, 1], [1, 2], hatch="//", label="é")
        path = tmp_path / f"{name}{suffix}"
        saving.save(figure, path)
        return path.read_bytes()

    first = saved("first")
    assert first == saved("second")
    assert not [word for word in (b"dc:date", b"CreationDate", b"Software", b"<dc:creator") if word in first]


def test_png_has_the_resolution_of_print(tmp_path):
    saving.save(style.page("", 1, 2.0), tmp_path / "a.png")
    height, width, _ = mpl.image.imread(io.BytesIO((tmp_path / "a.png").read_bytes())).shape
    assert (width, height) == (2160, 600)
