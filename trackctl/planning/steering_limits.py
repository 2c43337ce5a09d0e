"""What a vehicle can do on a slope, as a search asks for it: how fast, and how it lies across its path."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class SteeringLimits(NamedTuple):
    """Fastest feasible turn and what it takes, over slope, curvature and direction of motion, for kernels.

    The direction is that of the path's tangent from up-slope, not the body's heading: a search knows the former. All
    arrays below but the axes have the shape (n_slope, n_curvature, n_direction).

    Attributes
    ----------
    slope
        Ascending; one value on a plane. [rad]
    curvature
        Ascending, right turns negative, 0 included. [1/m]
    direction
        Even over [0, 2 pi), from 0; periodic. [rad]
    speed
        The fastest that the table calls feasible and the profile's limits allow; 0 where none is. [m/s]
    sideslip
        At that speed: tangent - yaw of the body. [rad]
    slip
        The larger of the two tracks' slips in size, at that speed. [-]
    work
        Of the tracks on the ground per metre of path, at that speed: traction times track speed over speed. [J/m]
    """

    slope: Array
    curvature: Array
    direction: Array
    speed: Array
    sideslip: Array
    slip: Array
    work: Array
