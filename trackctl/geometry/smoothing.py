"""Splines through points that may scatter: as many pieces as the points bear out, and no more."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.geometry.bspline import Spline, SplineSpace, solve_normal_equations

Array = NDArray[np.float64]

#: Coarser splines are tried until their score is this many times the best.
HOPELESS = 4.0
#: Of splines whose scores differ by less than this factor, the one of fewest coefficients is taken.
AS_GOOD = 1.3
#: Up to so many points a spline goes through them all.
FEW_POINTS = 20


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """A spline and how far it leaves its points.

    Attributes
    ----------
    spline
        Of as many components as the points.
    deviation
        Largest distance from a point, in the unit of the points.
    """

    spline: Spline
    deviation: float


def fit_spline(parameter: Array, points: Array, degree: int, tolerance: float) -> Fit:
    """The spline that best foretells points left out, among those that stay within a tolerance.

    Least squares on 4/5, 2/5, 1/5, ... as many coefficients as points, scored by generalised cross-validation [1]_;
    where none of them stays within the tolerance, and for few points, the spline that interpolates.

    Parameters
    ----------
    parameter : ndarray, shape (n,)
        Strictly ascending.
    points : ndarray, shape (n, n_components)
        n >= 2; the degree is lowered to n - 1 for fewer points than it needs.
    degree
        Of the spline.
    tolerance
        Largest distance from a point allowed.

    References
    ----------
    .. [1] P. Craven, G. Wahba, Smoothing noisy data with spline functions, 1978, doi:10.1007/BF01404567.
    """
    count = parameter.size
    degree = min(degree, count - 1)
    chosen, best_score = None, np.inf
    size = count if count <= FEW_POINTS else 4 * count // 5
    while degree < size < count:
        fit, squares = least_squares(parameter, points, degree, size)
        score = squares / (1.0 - size / count) ** 2
        if fit.deviation > tolerance or score > HOPELESS * best_score:
            break
        best_score = min(best_score, score)
        if score <= AS_GOOD * best_score:
            chosen = fit
        size //= 2
    return chosen or least_squares(parameter, points, degree, count)[0]


def least_squares(parameter: Array, points: Array, degree: int, size: int) -> tuple[Fit, float]:
    """The spline of `size` coefficients next to points, and its sum of squares; knots follow the points."""
    space = SplineSpace(knots_among(parameter, degree, size), degree)
    span = space.span(parameter)
    rows = space.basis(parameter, span)
    centre = points.mean(axis=0)
    left_over, coefficients = points - centre, np.zeros((size, points.shape[1]))
    for _ in range(2):  # the second refines the first, as normal equations lose digits
        correction = solve_normal_equations(space, span, rows, left_over)
        for k, row in enumerate(rows):
            left_over = left_over - row[:, None] * correction[span - degree + k]
        coefficients += correction
    squares = (left_over**2).sum(axis=1)
    return Fit(Spline(space, coefficients + centre), float(np.sqrt(squares.max()))), float(squares.sum())


def knots_among(parameter: Array, degree: int, size: int) -> Array:
    """Knots of a spline of `size` coefficients, with points between them all: means of `degree` points apart.

    With as many coefficients as points they are de Boor's averages, with which interpolation has one answer.
    """
    places = np.linspace(0.0, parameter.size - 1.0, size)
    sites = np.interp(places, np.arange(parameter.size), parameter)
    totals = np.concatenate(([0.0], np.cumsum(sites)))
    inner = (totals[degree + 1 : -1] - totals[1 : -degree - 1]) / degree
    ends = np.full(degree + 1, parameter[0]), np.full(degree + 1, parameter[-1])
    return np.concatenate((ends[0], inner, ends[1]))
