"""The constraint solved with the sideslip as a B-spline."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.forces.gauss_newton import gauss_newton
from trackctl.forces.model import (
    ForceModel,
    ReferencePoints,
    Residual,
    constraint,
    steady_sideslip,
)
from trackctl.forces.reference import Reference
from trackctl.forces.yaw import YawMotion, YawSolution
from trackctl.geometry.bspline import Spline, SplineSpace, clamped_knots, solve_normal_equations
from trackctl.geometry.gauss import gauss_points

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

DEGREE = 5
#: Multiplicity of a knot at which the second derivative may jump.
BREAK = DEGREE - 1
#: Gauss points an interval.
POINTS = 6
#: From between two Gauss points to an inflection.
NEWTON_STEPS = 5
#: Intervals are at most this share of the ground contact, and at least so many.
CONTACT_SHARE = 0.25
FEWEST = 20
#: Intervals with a larger residual are halved, this many times over, while there are not too many.
TOLERANCE = 1e-9
REFINEMENTS = 12
MOST_INTERVALS = 100_000
#: Weight of the sideslip asked for at an end against that of the constraint, which comes first.
PIN = 1e-3
#: Of the series for the sideslip at the ends, at most.
TERMS = 6
#: Near a jump in the reference no residual gets small; elsewhere those are let be that are this share of the largest.
SHARE = 0.01
#: So many first intervals on each side of a jump in the reference are left as they are.
SPARED = 10


@dataclass(frozen=True, slots=True, eq=False)
class SplineYaw:
    """Yaw whose sideslip is a spline over arc length."""

    sideslip: Spline

    def at(self, arc_length: Array, reference: ReferencePoints) -> YawMotion:
        """See `Yaw`."""
        slopes = self.sideslip(arc_length, derivative=1), self.sideslip(arc_length, derivative=2)
        gradient, gradient_change = reference.curvature - slopes[0], reference.curvature_gradient - slopes[1]
        return YawMotion(self.sideslip(arc_length), gradient, gradient_change)


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """Intervals of arc length.

    Attributes
    ----------
    edges
        Ascending, shape (n + 1,). [m]
    breaks
        Those where the second derivative of the sideslip jumps, ascending. [m]
    spared
        Stretches that refinement leaves alone, shape (n_spared, 2). [m]
    """

    edges: Array
    breaks: Array
    spared: Array


def solve_spline(model: ForceModel, reference: Reference, intervals: int | None = None) -> YawSolution:
    """The sideslip of least squared residual, by Gauss and Newton's method from the steady one.

    Parameters
    ----------
    model, reference
        The vehicle and what it is asked to do.
    intervals
        That many, evenly apart but for the breaks; None to refine where the residual is large.
    """
    mesh = first_mesh(model, reference, intervals)
    problem = SplineProblem.on(model, reference, mesh)
    sideslip, iterations = problem.solve()
    for _ in range(0 if intervals else REFINEMENTS):
        residuals = problem.largest_residuals(sideslip)
        finer = refined(mesh, residuals > max(TOLERANCE, SHARE * residuals.max()))
        if not mesh.edges.size < finer.edges.size <= MOST_INTERVALS:
            break
        mesh, problem = finer, SplineProblem.on(model, reference, finer)
        sideslip, iterations = problem.solve()
    return YawSolution(SplineYaw(sideslip), mesh.edges, mesh.breaks, iterations)


def first_mesh(model: ForceModel, reference: Reference, intervals: int | None) -> Mesh:
    """Even intervals, with edges at the breaks of the reference."""
    length = reference.path.length
    even = int(np.ceil(length / (CONTACT_SHARE * model.length)))
    count = intervals or min(max(FEWEST, even), MOST_INTERVALS)
    width = length / count
    kinks = np.concatenate((reference.path.kinks, inflections(model, reference, np.linspace(0.0, length, count + 1))))
    jumps = np.concatenate((reference.path.jumps, reference.speed.jumps))
    jumps = jumps[(jumps > 0.0) & (jumps < length)]
    corners = np.unique(np.concatenate(([0.0], kinks, jumps, [length])))
    corners = corners[np.append(np.diff(corners) > 1e-9 * length, True)]
    corners[0] = 0.0
    shares = np.maximum(1, np.round(np.diff(corners) / width)).astype(int)
    stretches = zip(corners[:-1], corners[1:], shares, strict=True)
    edges = np.concatenate([np.linspace(a, b, share, endpoint=False) for a, b, share in stretches])
    spared = jumps[:, None] + SPARED * width * np.array([-1.0, 1.0])
    breaks = np.intersect1d(corners[1:-1], kinks)
    return Mesh(np.append(edges, length), breaks, spared)


def inflections(model: ForceModel, reference: Reference, edges: Array) -> Array:
    """Where the curvature changes sign so fast that the second derivative of the sideslip jumps. [m]"""
    places = gauss_points(edges, POINTS)[0].ravel()
    curvature = reference.path.at(places).curvature
    k = np.flatnonzero(curvature[:-1] * curvature[1:] < 0.0)
    low, high = places[k], places[k + 1]
    at = 0.5 * (low + high)
    for _ in range(NEWTON_STEPS if k.size else 0):
        here = reference.path.at(at)
        slope = np.where(here.curvature_gradient == 0.0, np.inf, here.curvature_gradient)
        at = np.clip(at - here.curvature / slope, low, high)
    points = reference.at(at)
    jump = 4.0 * points.curvature_gradient**2 * points.squared_speed / model.grip
    return np.asarray(at[jump * np.diff(edges).max() ** 2 > TOLERANCE])


def refined(mesh: Mesh, halve: NDArray[np.bool_]) -> Mesh:
    """A mesh with some of its intervals halved, but for the spared ones."""
    middles = 0.5 * (mesh.edges[:-1] + mesh.edges[1:])
    for low, high in mesh.spared:
        halve = halve & ((middles < low) | (middles > high))
    return Mesh(np.sort(np.concatenate((mesh.edges, middles[halve]))), mesh.breaks, mesh.spared)


@dataclass(frozen=True, slots=True, eq=False)
class SplineProblem:
    """Least squares on a mesh: arrays over the Gauss points of its intervals and, at last, its two ends.

    Attributes
    ----------
    model
        The vehicle.
    space
        Of the sideslip.
    points
        Path and speed.
    weights
        Square roots of the quadrature weights, 0 at the ends.
    pins
        Weight of the steady sideslip, asked for at an end that the constraint leaves free; 0 elsewhere.
    steady
        The sideslip if the yaw turned as the path does, and at the ends without fast transients. [rad]
    span, basis, slopes
        Stretch of the spline that holds each point, its basis there, and the derivative of that.
    """

    model: ForceModel
    space: SplineSpace
    points: ReferencePoints
    weights: Array
    pins: Array
    steady: Array
    span: Indices
    basis: Array
    slopes: Array

    @staticmethod
    def on(model: ForceModel, reference: Reference, mesh: Mesh) -> SplineProblem:
        """The problem on a mesh."""
        multiplicity = np.where(np.isin(mesh.edges[1:-1], mesh.breaks), BREAK, 1)
        space = SplineSpace(clamped_knots(mesh.edges, DEGREE, multiplicity), DEGREE)
        inner, weights = gauss_points(mesh.edges, POINTS)
        places = np.append(inner.ravel(), mesh.edges[[0, -1]])
        points, span = reference.at(places), space.span(places)
        steady = steady_sideslip(model, points, points.curvature)
        steady[-2] = slow_sideslip(model, reference, mesh.edges[1], mesh.edges[0])
        steady[-1] = slow_sideslip(model, reference, mesh.edges[-2], mesh.edges[-1])
        return SplineProblem(
            model,
            space,
            points,
            np.append(np.sqrt(weights), [0.0, 0.0]),
            np.sqrt(weights.sum(axis=1).min()) * PIN * free_ends(model, points, steady),
            steady,
            span,
            space.basis(places, span),
            space.basis(places, span, 1),
        )

    def solve(self) -> tuple[Spline, int]:
        """The spline of least sum of squares, and the number of iterations."""
        weights = self.weights + self.pins
        start = solve_normal_equations(self.space, self.span, self.basis * weights, self.steady * weights)
        coefficients, iterations = gauss_newton(self.linearised, start)
        return Spline(self.space, coefficients), iterations

    def linearised(self, coefficients: Array) -> tuple[float, Callable[[], Array]]:
        """Sum of squares, and what solves the linearised problem."""
        sideslip, residual = self.constraint(coefficients)
        right = self.weights * residual.value + self.pins * (sideslip - self.steady)

        def step() -> Array:
            by_sideslip = self.weights * residual.by_sideslip + self.pins
            rows = by_sideslip * self.basis - self.weights * residual.by_yaw_gradient * self.slopes
            return solve_normal_equations(self.space, self.span, rows, -right)

        return float(right @ right), step

    def constraint(self, coefficients: Array) -> tuple[Array, Residual]:
        """Sideslip and constraint at the points."""
        local = coefficients[self.span - DEGREE + np.arange(DEGREE + 1)[:, None]]
        sideslip, slope = (self.basis * local).sum(axis=0), (self.slopes * local).sum(axis=0)
        return sideslip, constraint(self.model, self.points, sideslip, self.points.curvature - slope)

    def largest_residuals(self, sideslip: Spline) -> Array:
        """Largest absolute residual in each interval, shape (n_intervals,)."""
        _, residual = self.constraint(sideslip.coefficients)
        return np.asarray(np.abs(residual.value[:-2]).reshape(-1, POINTS).max(axis=1))


def slow_sideslip(model: ForceModel, reference: Reference, start: float, end: float) -> float:
    """Sideslip at the end of a stretch of the one solution there that has no fast transient. [rad]

    The constraint may be met with any sideslip at its free end, but with others the yaw jerks right there. That
    solution is a series whose terms follow from each other: the steady sideslip for the slope of the sum so far.
    It is summed while its terms go down.
    """
    nodes = 0.5 * (start + end) - 0.5 * (end - start) * np.cos(np.linspace(0.0, np.pi, TERMS + 1))
    points = reference.at(np.append(nodes[:-1], np.nextafter(end, start)))
    powers = np.vander((nodes - end) / (end - start), increasing=True)
    slopes = np.zeros_like(powers)
    slopes[:, 1:] = powers[:, :-1] * np.arange(1, TERMS + 1) / (end - start)
    to_slopes = slopes @ np.linalg.inv(powers)
    sideslip, last = steady_sideslip(model, points, points.curvature), np.inf
    for _ in range(TERMS):
        following = steady_sideslip(model, points, points.curvature - to_slopes @ sideslip)
        term = np.abs(following - sideslip).max()
        if term > 0.5 * last:
            break
        sideslip, last = following, term
    return float(sideslip[-1])


def free_ends(model: ForceModel, points: ReferencePoints, sideslip: Array) -> Array:
    """1 at the ends, the last two of the points, that the constraint leaves free, else 0.

    Linearised about the steady sideslip it is an equation of first order. Where its solutions grow along
    the path, as on level ground, they are told apart at the end; where they die out, at the start. Right at an end
    the path may be straight, and the equation none, so the Gauss points next to the ends decide.
    """
    by_yaw_gradient = constraint(model, points, sideslip, points.curvature).by_yaw_gradient
    pins = np.zeros(sideslip.size)
    pins[-2] = by_yaw_gradient[0] > 0.0
    pins[-1] = by_yaw_gradient[-3] <= 0.0
    return pins
