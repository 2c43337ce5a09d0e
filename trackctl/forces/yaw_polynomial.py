"""The constraint solved as in the paper, with the yaw gradient as a polynomial over arc length."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.chebyshev import Chebyshev, chebvander
from numpy.typing import NDArray

from trackctl.forces.gauss_newton import gauss_newton
from trackctl.forces.model import ForceModel, ReferencePoints, constraint, steady_sideslip
from trackctl.forces.reference import Reference
from trackctl.forces.yaw import YawMotion, YawSolution
from trackctl.geometry.gauss import gauss_points

Array = NDArray[np.float64]

#: Even intervals of quadrature, and Gauss points in each.
INTERVALS = 64
POINTS = 6


@dataclass(frozen=True, slots=True, eq=False)
class PolynomialYaw:
    """Yaw over arc length whose derivative is a polynomial."""

    yaw: Chebyshev

    def at(self, arc_length: Array, reference: ReferencePoints) -> YawMotion:
        """See `Yaw`."""
        gradient = self.yaw.deriv()
        return YawMotion(reference.tangent - self.yaw(arc_length), gradient(arc_length), gradient.deriv()(arc_length))


def solve_polynomial(model: ForceModel, reference: Reference, order: int) -> YawSolution:
    """The yaw gradient of least squared residual, (32) and (33) of the paper in Chebyshev polynomials.

    Parameters
    ----------
    model, reference
        The vehicle and what it is asked to do.
    order
        n, of the polynomial theta_s.
    """
    length = reference.path.length
    corners = np.concatenate((reference.path.kinks, reference.path.jumps, reference.speed.jumps))
    edges = np.unique(np.concatenate((np.linspace(0.0, length, INTERVALS + 1), corners)))
    places, weights = (part.ravel() for part in gauss_points(edges, POINTS))
    points, roots = reference.at(places), np.sqrt(weights)
    scaled = 2.0 * places / length - 1.0
    yaws = chebvander(scaled, order + 1)
    gradients = np.stack([Chebyshev.basis(k, [0.0, length]).deriv()(places) for k in range(order + 2)], axis=1)

    def linearised(unknowns: Array) -> tuple[float, Callable[[], Array]]:
        residual = constraint(model, points, points.tangent - yaws @ unknowns, gradients @ unknowns)
        right = roots * residual.value

        def step() -> Array:
            rows = -residual.by_sideslip[:, None] * yaws + residual.by_yaw_gradient[:, None] * gradients
            return np.asarray(np.linalg.lstsq(roots[:, None] * rows, -right, rcond=None)[0])

        return float(right @ right), step

    steady = points.tangent - steady_sideslip(model, points, points.curvature)
    start = np.asarray(np.linalg.lstsq(roots[:, None] * yaws, roots * steady, rcond=None)[0], np.float64)
    unknowns, iterations = gauss_newton(linearised, start)
    return YawSolution(PolynomialYaw(Chebyshev(unknowns, [0.0, length])), edges, np.empty(0), iterations)
