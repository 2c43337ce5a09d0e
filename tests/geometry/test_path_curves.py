import numpy as np
import pytest
from scipy.special import fresnel

from trackctl.geometry.clothoid_path import ClothoidPath, arc, clothoid_arc_clothoid
from trackctl.geometry.spline_path import fit_path, has_cusp, rounded

NO_JUMPS = np.empty(0)


def sampled(path, count=2001):
    return path.at(np.linspace(0.0, path.length, count))


@pytest.mark.parametrize("radius", [5.0, -0.3])
def test_an_arc_is_one(radius):
    path = arc(radius, 7.0)
    points = sampled(path)
    s = np.linspace(0.0, path.length, 2001)
    assert path.length == pytest.approx(7.0 * abs(radius))
    assert points.x == pytest.approx(radius * np.sin(s / radius), abs=1e-13)
    assert points.y == pytest.approx(radius * (1.0 - np.cos(s / radius)), abs=1e-13)
    assert points.tangent == pytest.approx(s / radius)
    assert (points.curvature == 1.0 / radius).all()


def test_a_clothoid_is_fresnels_integral():
    length, curvature = 10.0, 0.4
    path = ClothoidPath(np.array([0.0, length]), np.zeros(1), np.array([curvature]), NO_JUMPS)
    scale = np.sqrt(np.pi * length / curvature)
    s = np.linspace(0.0, length, 101)
    sine, cosine = fresnel(s / scale)
    points = path.at(s)
    assert points.x == pytest.approx(scale * cosine, abs=1e-13)
    assert points.y == pytest.approx(scale * sine, abs=1e-13)


def test_a_curve_between_straights():
    path = clothoid_arc_clothoid(-5.0, 4.0, 6.0, 3.0)
    points = sampled(path, 1301)
    assert path.length == 13.0
    assert path.kinks == pytest.approx([4.0, 10.0])
    assert path.jumps.size == 0
    assert points.curvature[[0, 400, 1000, 1300]] == pytest.approx([0.0, -0.2, -0.2, 0.0], abs=1e-15)
    assert points.tangent[-1] == pytest.approx(-0.2 * (2.0 + 6.0 + 1.5))
    assert clothoid_arc_clothoid(5.0, 0.0, 6.0, 0.0).jumps == pytest.approx([0.0, 6.0])


@pytest.mark.parametrize("count", [4, 12, 60, 2000])
def test_a_fitted_path_is_in_arc_length_and_its_derivatives_agree(count):
    x = np.linspace(0.0, 60.0, count)
    path, _ = fit_path(x, 5.0 * np.sin(x / 10.0), 0.05)
    s, h = np.linspace(0.0, path.length, 500)[1:-1], 1e-4
    before, here, after = path.at(s - h), path.at(s), path.at(s + h)
    assert np.hypot(after.x - before.x, after.y - before.y) / (2.0 * h) == pytest.approx(1.0, abs=1e-7)
    assert (after.tangent - before.tangent) / (2.0 * h) == pytest.approx(here.curvature, abs=1e-7)
    assert (after.curvature - before.curvature) / (2.0 * h) == pytest.approx(here.curvature_gradient, abs=1e-6)


def test_exact_waypoints_of_a_circle_give_its_curvature():
    errors = []
    for count in (50, 100, 200):
        angle = np.linspace(0.0, 2.0 * np.pi, count + 1)
        path, _ = fit_path(5.0 * np.cos(angle), 5.0 * np.sin(angle), 0.05)
        errors.append(abs(sampled(path).curvature - 0.2).max())
        assert path.length == pytest.approx(10.0 * np.pi, rel=1e-6)
    assert errors[-1] < 1e-6
    # a quintic spline's second derivative is of fourth order
    assert np.log2(np.array(errors[:-1]) / errors[1:]).min() > 3.5


@pytest.mark.parametrize("digits", [2, 3, 6])
def test_rounded_waypoints_are_evened_out(digits):
    angle = np.linspace(0.0, 2.0 * np.pi, 1001)
    path, fit = fit_path((5.0 * np.cos(angle)).round(digits), (5.0 * np.sin(angle)).round(digits), 0.05)
    assert fit.deviation < 10.0**-digits
    # through the points, it would be off by 10^-digits / spacing^2
    assert abs(sampled(path).curvature - 0.2).max() < 0.02 * 10.0**-digits / 0.0314**2


def test_few_waypoints_are_met():
    path, fit = fit_path(np.array([0.0, 10.0, 20.0, 20.0]), np.array([0.0, 0.0, 5.0, 15.0]), 0.05)
    assert fit.deviation < 1e-12
    assert not has_cusp(path)


def test_two_waypoints_are_a_straight():
    path, _ = fit_path(np.array([1.0, 4.0]), np.array([1.0, 5.0]), 0.05)
    points = sampled(path, 11)
    assert path.length == pytest.approx(5.0)
    assert points.tangent == pytest.approx(np.arctan2(4.0, 3.0))
    assert points.curvature == pytest.approx(0.0, abs=1e-15)


def test_rounding_draws_a_jump_out_and_leaves_straights_alone():
    s = np.arange(0.0, 40.0, 0.1)
    bend = np.maximum(s - 20.0, 0.0) / 8.0
    path, _ = fit_path(np.minimum(s, 20.0) + 8.0 * np.sin(bend), 8.0 * (1.0 - np.cos(bend)), 0.05)
    smooth, moved = rounded(path, 4.0)
    points = sampled(smooth)
    straight = points.x < 17.9
    assert moved < 4.0**2 / (24.0 * 8.0)
    assert abs(points.y[straight]).max() < 1e-5
    # a triangle 4 m wide: at most 1/8 over 2 m
    assert points.curvature_gradient.max() == pytest.approx(0.125 / 2.0, rel=0.05)
    assert abs(sampled(path).curvature_gradient).max() > 0.5
    assert points.curvature[-1] == pytest.approx(0.125, rel=0.02)
