"""Paths of continuous curvature through waypoints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.geometry.bspline import Spline
from trackctl.geometry.gauss import gauss_points
from trackctl.geometry.path import PathPoints
from trackctl.geometry.smoothing import Fit, fit_spline

Array = NDArray[np.float64]

#: Degree of the curve: its curvature has two continuous derivatives.
DEGREE = 5
#: Fewest parts of the stretch between two knots in which the arc length is tabulated, and Gauss points in each.
PARTS = 1
POINTS = 5
#: Error of the parameter between the lines of the table, as a share of the length, and the most lines to that end.
ACCURACY = 1e-13
LARGEST_TABLE = 1_000_000
#: A curve that slows to this share of its mean speed against the waypoints has a cusp, or nearly so.
CUSP = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class SplinePath:
    """A spline curve in the plane, as a function of its arc length.

    Attributes
    ----------
    curve
        x and y over a parameter that is close to the arc length. [m]
    parameters, arc_lengths, stretches
        Table of the parameter over the arc length, and the arc length per parameter there; shape (n,).
    tangents
        Continuous direction of travel at the table's points, shape (n,). [rad]
    """

    curve: Spline
    parameters: Array
    arc_lengths: Array
    stretches: Array
    tangents: Array

    @property
    def length(self) -> float:
        """See `Path`."""
        return float(self.arc_lengths[-1])

    @property
    def kinks(self) -> Array:
        """See `Path`; there are none."""
        return np.empty(0)

    @property
    def jumps(self) -> Array:
        """See `Path`; there are none."""
        return np.empty(0)

    def at(self, arc_length: Array) -> PathPoints:
        """See `Path`."""
        parameter = self.parameter_at(arc_length)
        place, first, second, third = (self.curve(parameter, order).view(np.complex128)[:, 0] for order in range(4))
        speed = np.abs(first)
        # Of the conjugate product, the real part is along the curve and the imaginary part across it.
        along, across = (first.conj() * second).real, (first.conj() * second).imag
        curvature = across / speed**3
        change = (first.conj() * third).imag / speed**3 - 3.0 * curvature * along / speed**2
        near = np.interp(arc_length, self.arc_lengths, self.tangents)
        tangent = near + np.angle(first * np.exp(-1j * near))
        return PathPoints(place.real, place.imag, tangent, curvature, change / speed)

    def parameter_at(self, arc_length: Array) -> Array:
        """Parameter of the curve at arc lengths: the cubic with the table's values and slopes."""
        k = np.clip(np.searchsorted(self.arc_lengths, arc_length, side="right") - 1, 0, self.arc_lengths.size - 2)
        width = self.arc_lengths[k + 1] - self.arc_lengths[k]
        t = (arc_length - self.arc_lengths[k]) / width
        rise = self.parameters[k + 1] - self.parameters[k]
        first = width / self.stretches[k] - rise
        last = rise - width / self.stretches[k + 1]
        return np.asarray(self.parameters[k] + t * rise + t * (1.0 - t) * (first * (1.0 - t) + last * t))


def fit_path(x: Array, y: Array, tolerance: float) -> tuple[SplinePath, Fit]:
    """A path along waypoints, of continuous curvature and curvature gradient.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        n >= 2; no two in a row at one place. [m]
    tolerance
        Largest distance of the curve from a waypoint, where the curve is to even out their scatter. [m]
    """
    points = np.stack((x, y), axis=1)
    chords = np.hypot(np.diff(x), np.diff(y))
    fit = fit_spline(np.concatenate(([0.0], np.cumsum(chords))), points, DEGREE, tolerance)
    return spline_path(fit.spline), fit


def spline_path(curve: Spline) -> SplinePath:
    """A curve with its arc length tabulated, so densely that the middles of the table come out right."""
    knots = np.unique(curve.space.knots)
    parts = PARTS
    coarse = tabulated(curve, knots, parts)
    while True:
        parts *= 2
        fine = tabulated(curve, knots, parts)
        error = np.abs(coarse.parameter_at(fine.arc_lengths) - fine.parameters).max()
        if error <= ACCURACY * fine.length or fine.parameters.size > LARGEST_TABLE:
            return fine
        coarse = fine


def tabulated(curve: Spline, knots: Array, parts: int) -> SplinePath:
    """A curve with a table of so many parts between two knots."""
    fractions = np.arange(parts) / parts
    parameters = np.append((knots[:-1, None] + np.diff(knots)[:, None] * fractions).ravel(), knots[-1])
    points, weights = gauss_points(parameters, POINTS)
    velocity = curve(points.ravel(), 1).view(np.complex128)[:, 0]
    lengths = (np.abs(velocity).reshape(points.shape) * weights).sum(axis=1)
    ends = curve(parameters, 1).view(np.complex128)[:, 0]
    turns = np.angle(ends[1:] * ends[:-1].conj())
    tangents = np.angle(ends[0]) + np.concatenate(([0.0], np.cumsum(turns)))
    arc_lengths = np.concatenate(([0.0], np.cumsum(lengths)))
    return SplinePath(curve, parameters, arc_lengths, np.abs(ends), tangents)


def has_cusp(path: SplinePath) -> bool:
    """Whether the curve stops or nearly stops somewhere against its waypoints."""
    return bool(path.stretches.min() < CUSP * path.stretches.mean())


def rounded(path: SplinePath, transition: float) -> tuple[SplinePath, float]:
    """A path with every jump of curvature drawn out over a length, and how far that moves it.

    The mean of the curve over a sliding window that is widest in the middle (a triangle): it shrinks an arc
    of radius R by transition^2 / (48 R) at most, beyond the ends goes on along the osculating circles, and
    draws a jump of curvature out to a smooth step.

    Parameters
    ----------
    path
        The curve; its ends move sideways where they are bent.
    transition
        Width of the window, above 0 and at most the path's length. [m]
    """
    half = 16
    step = 0.5 * transition / half
    count = max(int(np.ceil(path.length / step)), 2 * half) + 1
    places = np.linspace(0.0, path.length, count)
    step = places[1]
    points = path.at(places)
    curve = points.x + 1j * points.y
    beyond = step * np.arange(1, half + 1)
    before = beyond_end(curve[0], points.tangent[0], points.curvature[0], -beyond[::-1])
    after = beyond_end(curve[-1], points.tangent[-1], points.curvature[-1], beyond)
    window = 1.0 - np.abs(np.arange(1 - half, half)) / half
    mean = np.convolve(np.concatenate((before[1:], curve, after[:-1])), window / window.sum(), mode="valid")
    smooth, _ = fit_path(mean.real, mean.imag, 0.0)
    return smooth, float(np.abs(mean - curve).max())


def beyond_end(place: complex, tangent: float, curvature: float, distance: Array) -> NDArray[np.complex128]:
    """Points on the osculating circle of a path's end, at signed distances along it."""
    chord = distance * np.sinc(0.5 * curvature * distance / np.pi)
    return np.asarray(place + chord * np.exp(1j * (tangent + 0.5 * curvature * distance)))
