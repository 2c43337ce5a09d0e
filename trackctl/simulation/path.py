"""Paths of the mass centre in the slope plane, with the speed along them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SAMPLES_A_TURN = 720


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """Samples of a path, arrays of shape (n,).

    Attributes
    ----------
    arc_length
        From the start, ascending. [m]
    x, y
        Of the mass centre. [m]
    tangent
        Direction of motion from the x axis, without jumps. [rad]
    curvature
        Left positive. [1/m]
    speed
        Not negative. [m/s]
    """

    arc_length: Array
    x: Array
    y: Array
    tangent: Array
    curvature: Array
    speed: Array

    @property
    def length(self) -> float:
        """Of the whole path. [m]"""
        return float(self.arc_length[-1])


def path_of_curvature(arc_length: Array, curvature: Array, speed: Array, start: tuple[float, float, float]) -> Path:
    """The path of a curvature [1/m] over arc length [m] from x, y [m] and tangent [rad]."""
    from scipy.integrate import cumulative_simpson  # takes its time

    x, y, tangent = start
    direction = tangent + cumulative_simpson(curvature, x=arc_length, initial=0.0)
    return Path(
        arc_length,
        x + cumulative_simpson(np.cos(direction), x=arc_length, initial=0.0),
        y + cumulative_simpson(np.sin(direction), x=arc_length, initial=0.0),
        direction,
        curvature,
        speed,
    )


def hermite(place: Array, values: Array, slopes: Array, at: Array) -> Array:
    """Cubics between places where values and slopes are known, at others."""
    step = np.diff(place)
    chord = np.diff(values) / step
    third = (slopes[:-1] + slopes[1:] - 2.0 * chord) / step
    second = (chord - slopes[:-1]) / step - third
    k = np.clip(np.searchsorted(place, at, side="right") - 1, 0, step.size - 1)
    s = at - place[k]
    return np.asarray(values[k] + slopes[k] * s + second[k] * (s * s) + third[k] / step[k] * (s * s * s))


def circle(radius: float, speed: float, turns: float, start: tuple[float, float, float]) -> Path:
    """Turns of a circle, to the right if the radius is negative, from x, y [m] and tangent [rad]."""
    x, y, tangent = start
    count = math.ceil(SAMPLES_A_TURN * turns) + 1
    turned = np.linspace(0.0, math.copysign(2.0 * math.pi * turns, radius), count)
    direction = tangent + turned
    return Path(
        radius * turned,
        x + radius * (np.sin(direction) - math.sin(tangent)),
        y - radius * (np.cos(direction) - math.cos(tangent)),
        direction,
        np.full(count, 1.0 / radius),
        np.full(count, speed),
    )
