"""Speeds along a path, as squared speed over arc length."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.geometry.bspline import Spline
from trackctl.geometry.gauss import gauss_points, unit_rule

Array = NDArray[np.float64]

#: Share of the path on which the trapezoidal profile speeds up, and slows down.
RAMP = 0.25
#: Gauss points between two stations.
POINTS = 6
#: Ratio of squared speeds at two stations below which the slower one counts as rest.
REST = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class SpeedProfile:
    """How fast the mass centre is along its path.

    Attributes
    ----------
    squared
        z = v^2 at arc lengths. [m2/s2]
    acceleration
        a = z'/2, from the right where it jumps. [m/s2]
    jumps
        Arc lengths within the path where the acceleration jumps. [m]
    """

    squared: Callable[[Array], Array]
    acceleration: Callable[[Array], Array]
    jumps: Array


def piecewise_linear(arc_lengths: list[float], speeds: list[float]) -> SpeedProfile:
    """Constant acceleration between speeds at arc lengths."""
    places, squared = np.array(arc_lengths), np.array(speeds) ** 2
    slopes = np.diff(squared) / np.diff(places)

    def acceleration(at: Array) -> Array:
        piece = np.clip(np.searchsorted(places, at, side="right") - 1, 0, slopes.size - 1)
        return np.asarray(0.5 * slopes[piece])

    jumps = places[1:-1][np.diff(slopes) != 0.0]
    return SpeedProfile(lambda at: np.interp(at, places, squared), acceleration, jumps)


def constant(length: float, speed: float) -> SpeedProfile:
    """One speed. [m/s]"""
    return piecewise_linear([0.0, length], [speed, speed])


def triangular(length: float, start: float, peak: float) -> SpeedProfile:
    """Up to the peak in the middle and down again, at constant acceleration."""
    return piecewise_linear([0.0, 0.5 * length, length], [start, peak, start])


def trapezoidal(length: float, start: float, peak: float) -> SpeedProfile:
    """Up to the peak on the first quarter and down on the last, at constant acceleration."""
    places = [0.0, RAMP * length, (1.0 - RAMP) * length, length]
    return piecewise_linear(places, [start, peak, peak, start])


def smooth(length: float, start: float, peak: float) -> SpeedProfile:
    """Speed of z = v0^2 + (vp^2 - v0^2) sin^2(pi s / S), every derivative of which is continuous."""
    rise, rate = peak**2 - start**2, math.pi / length
    return SpeedProfile(
        lambda at: start**2 + rise * np.sin(rate * at) ** 2,
        lambda at: 0.5 * rise * rate * np.sin(2.0 * rate * at),
        np.empty(0),
    )


def from_spline(squared: Spline) -> SpeedProfile:
    """Squared speed that is a spline, of continuous acceleration."""
    return SpeedProfile(
        lambda at: np.maximum(squared(at), 0.0), lambda at: 0.5 * squared(at, derivative=1), np.empty(0)
    )


def times(speed: SpeedProfile, stations: Array) -> Array:
    """Time at ascending arc lengths, from 0 at the first, shape (n,). [s]

    Where the vehicle starts or ends at rest or nearly so, 1/v is integrated over the square root of the distance
    from there.
    """
    points, weights = gauss_points(stations, POINTS)
    fractions, shares = unit_rule(POINTS)
    squared, widths = speed.squared(stations), np.diff(stations)
    for k in np.flatnonzero(squared[:-1] < REST * squared[1:]):
        points[k], weights[k] = stations[k] + widths[k] * fractions**2, 2.0 * widths[k] * fractions * shares
    for k in np.flatnonzero(squared[1:] < REST * squared[:-1]):
        points[k], weights[k] = stations[k + 1] - widths[k] * fractions**2, 2.0 * widths[k] * fractions * shares
    speeds = np.sqrt(speed.squared(points.ravel())).reshape(points.shape)
    return np.concatenate(([0.0], np.cumsum((weights / speeds).sum(axis=1))))
