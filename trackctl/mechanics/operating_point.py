"""What the vehicle is asked to do, in the dimensionless form that the balance needs."""

from __future__ import annotations

import math
from typing import NamedTuple

from trackctl.compiled import inlined
from trackctl.mechanics.parameters import TrackModel


class OperatingPoint(NamedTuple):
    """Steady motion on a slope, accelerations in units of gravity.

    Attributes
    ----------
    gravity_forward, gravity_left
        Gravity along the slope plane in the body frame: -sin(theta) cos(phi), sin(theta) sin(phi). [-]
    normal
        Gravity into the slope, cos(theta). [-]
    curvature
        Yaw rate over speed, left positive. [1/m]
    centripetal
        Acceleration towards the turning centre, v^2 kappa / g, left positive. [-]
    """

    gravity_forward: float
    gravity_left: float
    normal: float
    curvature: float
    centripetal: float


@inlined
def operating_point(
    model: TrackModel, slope: float, velocity: float, curvature: float, heading: float
) -> OperatingPoint:
    """The operating point of a slope [rad], speed [m/s], curvature [1/m] and heading from up-slope [rad]."""
    return OperatingPoint(
        -math.sin(slope) * math.cos(heading),
        math.sin(slope) * math.sin(heading),
        math.cos(slope),
        curvature,
        velocity * velocity * curvature / model.gravity,
    )
