"""Laps of a motion: turns of 2 pi of yaw from the start, and the circles that they make."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from trackctl.simulation.motion import Integration, sample, turn_time

Array = NDArray[np.float64]

SAMPLES_A_LAP = 720


@dataclass(frozen=True, slots=True)
class Circle:
    """Centre and radius. [m]"""

    x: float
    y: float
    radius: float


def fitted_circle(x: Array, y: Array) -> Circle:
    """Circle through points by linear least squares in x^2 + y^2 = 2 x_c x + 2 y_c y + (r^2 - x_c^2 - y_c^2)."""
    # About the points' mean, so that nothing is lost far from the origin.
    x_mean, y_mean = float(x.mean()), float(y.mean())
    u, v = x - x_mean, y - y_mean
    system = np.stack((2.0 * u, 2.0 * v, np.ones_like(u)), axis=1)
    a, b, c = np.linalg.lstsq(system, u * u + v * v, rcond=None)[0].tolist()
    return Circle(x_mean + a, y_mean + b, math.sqrt(c + a * a + b * b))


def laps(simulation: Integration) -> list[Circle]:
    """Circles of the whole laps of a simulation, fitted to points even in time."""
    steps = simulation.steps[: simulation.count]
    turned = np.abs(steps["pose"][:, -1, 2] - steps["pose"][0, 0, 2]).max(initial=0.0)
    whole = math.floor(turned / (2.0 * math.pi) * (1.0 + 1e-12))
    ends = [float(steps["time"][0])] + [turn_time(simulation, 2.0 * math.pi * k) for k in range(1, whole + 1)]
    circles = []
    for start, end in pairwise(ends):
        lap = sample(simulation, 1.0, np.linspace(start, end, SAMPLES_A_LAP, endpoint=False))
        circles.append(fitted_circle(lap.x, lap.y))
    return circles


def drift_per_lap(circles: list[Circle]) -> float | None:
    """Mean distance of successive centres, None for fewer than two laps. [m]"""
    if len(circles) < 2:
        return None
    pairs = pairwise(circles)
    return float(np.mean([math.hypot(b.x - a.x, b.y - a.y) for a, b in pairs]))
