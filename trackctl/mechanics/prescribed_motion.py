"""Balance of a vehicle whose mass centre moves along a given path: the equilibrium with its inertia terms."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.mechanics.equilibrium import balance
from trackctl.mechanics.operating_point import OperatingPoint
from trackctl.mechanics.parameters import TrackModel
from trackctl.mechanics.quadrature import Rule

Array = NDArray[np.float64]


class PrescribedMotion(NamedTuple):
    """Motion along a path on a slope, accelerations in units of gravity.

    Attributes
    ----------
    pull_along, pull_left
        Gravity less acceleration, along the path's tangent and to its left:
        -sin(theta) cos(chi) - a_t / g and sin(theta) sin(chi) - v^2 kappa / g, chi from up-slope to the tangent. [-]
    normal
        Gravity into the slope, cos(theta). [-]
    yaw_gradient
        Yaw rate over speed, which differs from the path's curvature where the sideslip changes. [1/m]
    yaw_inertia
        Inertial moment I_z dr/dt, in units of m g L. [-]
    """

    pull_along: float
    pull_left: float
    normal: float
    yaw_gradient: float
    yaw_inertia: float


@kernel
def prescribed_balance(
    model: TrackModel,
    motion: PrescribedMotion,
    rule: Rule,
    unknowns: Array,
    residual: Array,
    jacobian: Array,
    traction: Array,
) -> None:
    """Residuals of the force and moment balance, see `trackctl.mechanics.equilibrium.balance`.

    The heading follows the sideslip, as the path is what is given: the pull stands still while the body turns under
    it. Its part across the path has the form of a centripetal acceleration; the part along it is turned into the body
    frame here. Of the latter the derivatives by sideslip are complete but for the shift of load that it makes.
    """
    sin_beta, cos_beta = math.sin(unknowns[2]), math.cos(unknowns[2])
    forward, left = motion.pull_along * cos_beta, motion.pull_along * sin_beta
    point = OperatingPoint(forward, left, motion.normal, motion.yaw_gradient, -motion.pull_left)
    balance(model, point, rule, unknowns, residual, jacobian, traction, True)
    residual[2] -= motion.yaw_inertia
    jacobian[0, 2] -= left
    jacobian[1, 2] += forward
