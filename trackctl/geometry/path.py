"""A path in the plane, as a function of its arc length."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class PathPoints:
    """Points of a path, arrays of shape (n,).

    Attributes
    ----------
    x, y
        In the world. [m]
    tangent
        Direction of travel from the x axis, counter-clockwise, continuous along the path. [rad]
    curvature
        Its derivative along the path, left positive. [1/m]
    curvature_gradient
        The derivative of the curvature. [1/m2]
    """

    x: Array
    y: Array
    tangent: Array
    curvature: Array
    curvature_gradient: Array


class Path(Protocol):
    """A path that a vehicle may be asked to follow.

    Attributes
    ----------
    length
        Arc length from start to end. [m]
    kinks
        Arc lengths within the path where the curvature's derivative jumps. [m]
    jumps
        Arc lengths where the curvature jumps; the ends are among them where the path meets a straight there. [m]
    scale
        Length below which nothing happens to the curvature but at kinks and jumps; the finer, the more detail. [m]
    """

    @property
    def length(self) -> float: ...  # noqa: D102

    @property
    def kinks(self) -> Array: ...  # noqa: D102

    @property
    def jumps(self) -> Array: ...  # noqa: D102

    def at(self, arc_length: Array) -> PathPoints:
        """Points at arc lengths, shape (n,), in any order; at kinks and jumps as just after."""
        ...
