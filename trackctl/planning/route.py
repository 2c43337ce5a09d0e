"""A found way: arcs and straights that join start and goal exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Route:
    """Arcs and straights of the mass centre, one after the other, arrays of shape (n,).

    Attributes
    ----------
    start
        x, y [m] and tangent [rad] of the motion's line: the direction of travel forwards, its reverse backwards.
    curvature
        Of each piece, yaw change per metre travelled forwards, left positive. [1/m]
    length
        Of each piece, negative where it is driven backwards; 0 for a turn on the spot. [m]
    pivot
        Angle turned on the spot, 0 for arcs and straights. [rad]
    """

    start: tuple[float, float, float]
    curvature: Array
    length: Array
    pivot: Array
