"""Laps of a motion: turns of 2 pi of yaw from the start, and the circles that they make."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from trackctl.geometry.circle import Circle, fitted_circle
from trackctl.simulation.motion import Integration, sample, turn_time

Array = NDArray[np.float64]

SAMPLES_A_LAP = 720


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
