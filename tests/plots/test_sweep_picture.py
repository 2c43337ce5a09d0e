import math

import numpy as np
import pytest
from figure_artists import legend_texts, line_data, look
from plot_examples import by_name

from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.mechanics.parameters import STANDARD_GRAVITY
from trackctl.plots.sweep import draw_sweep
from trackctl.plots.sweep_summary import draw_sweep_summary
from trackctl.workflows.sweep import SweepRequest, summary_columns, sweep, tidy_columns

HEADING = np.arange(0.0, 360.0, 10.0)


def turns(slopes=(3, 12), velocities=(2,), radius=20.0, heading=HEADING):
    return sweep(
        SweepRequest(
            load_vehicle("utv-61cm"),
            load_terrain("asphalt"),
            STANDARD_GRAVITY,
            np.radians(slopes),
            np.array(velocities, float),
            radius,
            np.radians(heading),
        )
    )


def rows(result):
    tidy = tidy_columns(result)
    del tidy["status"]
    return by_name(tidy)


@pytest.fixture(scope="module")
def over_slopes():
    return rows(turns())


def curves_with_markers(axes):
    return [line for line in axes.get_lines() if line.get_marker() not in ("", "None")]


def test_the_lines_are_the_rows(over_slopes):
    figure = draw_sweep(over_slopes)
    outer, outer_slip, inner, inner_slip, radii, _ = figure.axes
    panels = {
        outer: over_slopes["track_speed_outer"],
        inner: over_slopes["track_speed_inner"],
        outer_slip: 100.0 * over_slopes["slip_outer"],
        inner_slip: 100.0 * over_slopes["slip_inner"],
        radii: over_slopes["theoretical_radius"],
    }
    for axes, values in panels.items():
        curves = curves_with_markers(axes)
        assert len(curves) == 2
        for curve, part in zip(curves, values.reshape(2, -1), strict=True):
            np.testing.assert_allclose(curve.get_xdata(), HEADING)
            np.testing.assert_array_equal(curve.get_ydata(), part)


def test_what_the_curves_are_compared_with(over_slopes):
    outer, _, inner, _, radii, polar = draw_sweep(over_slopes).axes
    for axes, name in ((outer, "body_speed_outer"), (inner, "body_speed_inner")):
        driving = [line for line in axes.get_lines() if line.get_marker() in ("", "None")]
        for line, part in zip(driving, over_slopes[name].reshape(2, -1), strict=True):
            np.testing.assert_array_equal(line.get_ydata(), part)
    assert list(line_data(radii, -1)[1]) == [20.0, 20.0]
    assert set(line_data(polar, -1)[1]) == {20.0}


def test_axes_name_quantities_and_units(over_slopes):
    figure = draw_sweep(over_slopes)
    assert [axes.get_ylabel() for axes in figure.axes[:5]] == [
        "Speed [m/s]",
        "Slip [%], above 0 driving",
        "Speed [m/s]",
        "Slip [%], above 0 driving",
        "Radius [m]",
    ]
    assert {axes.get_xlabel() for axes in figure.axes[:5]} == {"Heading from up-slope [°]"}
    assert figure.get_suptitle() == "Tracks in left turns over all headings: v = 2 m/s, R = 20 m"
    assert legend_texts(figure) == ["θ = 3°", "θ = 12°", "driving speed; desired radius"]
    titles = [axes.get_title("left")[:3] for axes in figure.axes]
    assert sorted(titles) == ["(a)", "(b)", "(c)", "(d)", "(e)", "(f)"]


def test_curves_differ_in_grey(over_slopes):
    for axes in draw_sweep(over_slopes).axes[:5]:
        first, second = curves_with_markers(axes)
        assert look(first) == (False, "o")
        assert look(second) == (True, "s")


def test_polar_curves_close_and_lie_on_the_slope(over_slopes):
    polar = draw_sweep(over_slopes).axes[-1]
    angle, radius = line_data(polar)
    assert (angle[-1], radius[-1]) == (angle[0], radius[0])
    np.testing.assert_array_equal(radius[:-1], over_slopes["theoretical_radius"][: HEADING.size])
    assert polar.get_theta_offset() == pytest.approx(0.5 * np.pi)
    assert polar.get_theta_direction() == 1
    assert polar.get_rmin() == 0.0


def test_half_a_circle_stays_open():
    half = HEADING[:19]
    angle, _ = line_data(draw_sweep(rows(turns(heading=half))).axes[-1])
    np.testing.assert_allclose(angle, np.radians(half))


def test_rows_in_any_order_give_the_same_lines(over_slopes):
    order = np.random.default_rng(0).permutation(over_slopes["slope"].size)
    mixed = draw_sweep({name: column[order] for name, column in over_slopes.items()})
    for axes, same in zip(draw_sweep(over_slopes).axes, mixed.axes, strict=True):
        for line, other in zip(axes.get_lines(), same.get_lines(), strict=True):
            np.testing.assert_array_equal(line.get_xydata(), other.get_xydata())


def test_gaps_of_infeasible_headings_are_told():
    found = rows(turns(slopes=(5,), velocities=(4, 6), radius=-5.0))
    figure = draw_sweep(found)
    assert np.isnan(curves_with_markers(figure.axes[0])[1].get_ydata()).any()
    assert legend_texts(figure)[-1] == "gap: no equilibrium"
    assert legend_texts(figure)[:2] == ["v = 4 m/s", "v = 6 m/s"]
    assert figure.get_suptitle() == "Tracks in right turns over all headings: θ = 5°, R = 5 m"
    radii = curves_with_markers(figure.axes[4])[0].get_ydata()
    np.testing.assert_array_equal(radii, -found["theoretical_radius"][: HEADING.size])


def test_radii_beyond_all_bounds_neither_join_nor_squeeze_the_picture():
    found = rows(turns(slopes=(25,), velocities=(1,), radius=200.0))
    radii, polar = draw_sweep(found).axes[4:]
    drawn = line_data(radii)[1]
    signs = np.sign(found["theoretical_radius"])
    assert np.isnan(drawn).sum() == np.count_nonzero(np.diff(signs)) == 2
    np.testing.assert_array_equal(drawn[~np.isnan(drawn)], found["theoretical_radius"])
    assert max(map(abs, radii.get_ylim())) <= 600.0
    assert polar.get_rmax() <= 600.0
    assert np.nanmin(line_data(polar)[1]) > 0.0


def test_a_single_heading_is_a_point():
    figure = draw_sweep(rows(turns(heading=np.array([90.0]))))
    assert line_data(figure.axes[0], 1)[0] == pytest.approx([90.0])


def test_summary_over_slopes():
    result = turns(slopes=(3, 8, 12), velocities=(4, 6), radius=5.0)
    summary = by_name(summary_columns(result))
    figure = draw_sweep_summary(summary)
    errors, radii, headings, missing = figure.axes
    for axes, names, factor in (
        (errors, ("rmse_outer", "rmse_inner"), 1.0),
        (radii, ("max_radius", "min_radius"), 1.0),
        (headings, ("max_radius_heading", "min_radius_heading"), math.degrees(1.0)),
        (missing, ("infeasible_count",), 1.0),
    ):
        expected = [summary[name].reshape(3, 2)[:, k] for k in (0, 1) for name in names]
        for line, values in zip(axes.get_lines(), expected, strict=False):
            np.testing.assert_allclose(line.get_xdata(), [3, 8, 12])
            np.testing.assert_allclose(line.get_ydata(), factor * values)
        assert axes.get_xlabel() == "Slope [°]"
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == ["RMSE [m/s]", "Radius [m]", "Heading from up-slope [°]", "Headings"]
    assert missing.get_lines()[1].get_ydata().max() > 0.0
    assert legend_texts(figure)[:2] == ["v = 4 m/s", "v = 6 m/s"]
    full, empty = errors.get_lines()[:2]
    assert (full.get_fillstyle(), empty.get_fillstyle()) == ("full", "none")


def test_summary_over_speeds():
    figure = draw_sweep_summary(by_name(summary_columns(turns(slopes=(5,), velocities=(2, 4)))))
    assert figure.axes[0].get_xlabel() == "Speed [m/s]"
    np.testing.assert_array_equal(line_data(figure.axes[0])[0], [2.0, 4.0])
    assert figure.get_suptitle() == "Tracks in left turns over all headings: θ = 5°, R = 20 m"
