import numpy as np
import pytest
from scipy.interpolate import BSpline

from trackctl.geometry.bspline import (
    FEW,
    Spline,
    SplineSpace,
    clamped_knots,
    solve_banded,
    solve_normal_equations,
)
from trackctl.geometry.gauss import gauss_points

BREAKS = np.array([0.0, 0.5, 0.7, 2.0, 3.0])


@pytest.mark.parametrize("multiplicity", [1, np.array([1, 4, 2])])
@pytest.mark.parametrize("derivative", [0, 1, 2, 3])
def test_splines_are_those_of_scipy(multiplicity, derivative):
    space = SplineSpace(clamped_knots(BREAKS, 5, multiplicity), 5)
    coefficients = np.random.default_rng(0).normal(size=(space.size, 2))
    at = np.linspace(0.0, 3.0, 301)
    expected = BSpline(space.knots, coefficients, 5)(at, derivative)
    assert Spline(space, coefficients)(at, derivative) == pytest.approx(expected, rel=1e-11, abs=1e-9)
    assert Spline(space, coefficients[:, 1])(at, derivative) == pytest.approx(expected[:, 1], rel=1e-11, abs=1e-9)


def test_normal_equations_are_those_of_least_squares():
    space = SplineSpace(clamped_knots(BREAKS, 3), 3)
    at = np.sort(np.random.default_rng(1).uniform(0.0, 3.0, 40))
    span = space.span(at)
    right = np.stack((np.sin(at), np.cos(at)), axis=1)
    dense = np.zeros((at.size, space.size))
    rows = space.basis(at, span)
    for k in range(4):
        dense[np.arange(at.size), span - 3 + k] = rows[k]
    expected = np.linalg.lstsq(dense, right, rcond=None)[0]
    assert solve_normal_equations(space, span, rows, right) == pytest.approx(expected, abs=1e-10)
    alone = solve_normal_equations(space, span, rows, right[:, 0])
    assert alone == pytest.approx(expected[:, 0], abs=1e-10)


def test_gauss_points_integrate_polynomials():
    points, weights = gauss_points(BREAKS, 3)
    assert (points**5 * weights).sum() == pytest.approx(3.0**6 / 6.0, rel=1e-14)


@pytest.mark.parametrize("size", [5, FEW, FEW + 1])
def test_banded_systems_small_and_large(size):
    random = np.random.default_rng(2)
    banded = random.uniform(-1.0, 1.0, (3, size))
    banded[-1] = 6.0
    matrix = np.diag(banded[2]) + sum(np.diag(banded[2 - j, j:], j) + np.diag(banded[2 - j, j:], -j) for j in (1, 2))
    right = random.normal(size=(size, 2))
    assert matrix @ solve_banded(banded, right) == pytest.approx(right, abs=1e-12)
