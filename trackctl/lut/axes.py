"""The four axes of a look-up table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FULL_CIRCLE = 2.0 * np.pi


def locked(values: Array) -> Array:
    """A read-only float64 copy."""
    copy = np.array(values, dtype=np.float64)
    copy.setflags(write=False)
    return copy


@dataclass(frozen=True, slots=True, eq=False)
class Axes:
    """Grid nodes of a table, each axis ascending.

    Attributes
    ----------
    slope
        Slope angle, in [0, pi/4). [rad]
    velocity
        Speed of the mass centre, positive. [m/s]
    curvature
        Yaw rate over speed, left turn positive; holds 0. [1/m]
    heading
        From the up-slope direction to the body's x axis, counter-clockwise, in [0, 2 pi). [rad]
    heading_is_periodic
        True where the headings go round the full circle evenly, so that the last is followed by the first.
    """

    slope: Array
    velocity: Array
    curvature: Array
    heading: Array
    heading_is_periodic: bool

    def __post_init__(self) -> None:
        for name in ("slope", "velocity", "curvature", "heading"):
            object.__setattr__(self, name, locked(getattr(self, name)))

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """Number of nodes: (slope, velocity, curvature, heading)."""
        return self.slope.size, self.velocity.size, self.curvature.size, self.heading.size

    @property
    def size(self) -> int:
        """Number of cells, as a Python integer that cannot overflow."""
        slopes, velocities, curvatures, headings = self.shape
        return slopes * velocities * curvatures * headings

    @property
    def radius(self) -> Array:
        """Turn radius at each curvature, negative to the right, inf when straight. [m]"""
        with np.errstate(divide="ignore"):
            return np.where(self.curvature == 0.0, np.inf, 1.0 / self.curvature)
