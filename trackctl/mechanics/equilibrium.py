"""Balance of forces and moment on the vehicle: the three equations of the slope-steering model."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.mechanics.contact import Contact, contact, loads
from trackctl.mechanics.operating_point import OperatingPoint
from trackctl.mechanics.parameters import TrackModel
from trackctl.mechanics.quadrature import Rule, choose
from trackctl.mechanics.shear import Stretch, TrackMotion, difficulty, stretch_force

Array = NDArray[np.float64]


@kernel
def split(motion: TrackMotion, ground: Contact) -> tuple[float, float]:
    """Where the lateral sliding vanishes, x = c_f - v_y/r, kept within the contact, and its derivative by sideslip."""
    rear, front = ground.rear, ground.front
    # Cross-multiplied, since the curvature may be zero.
    at_rear = motion.lateral_speed + motion.curvature * rear
    at_front = motion.lateral_speed + motion.curvature * front
    if at_rear * at_front >= 0.0:
        if abs(at_rear) <= abs(at_front):
            return rear, ground.rear_slope
        return front, ground.front_slope
    return -motion.lateral_speed / motion.curvature, -motion.lateral_speed_slope / motion.curvature


@kernel
def balance(
    model: TrackModel,
    point: OperatingPoint,
    rule: Rule,
    unknowns: Array,
    residual: Array,
    jacobian: Array,
    traction: Array,
) -> None:
    """Residuals of eqs (30)-(32), in units of m g, m g and m g L, and their exact derivatives.

    Parameters
    ----------
    model, point
        Vehicle on its terrain, and what it is asked to do.
    rule
        Quadrature for each of the two stretches of a track.
    unknowns
        Left and right track speed over vehicle speed [-], sideslip angle [rad], shape (3,).
    residual, jacobian
        Results, shapes (3,) and (3, 3).
    traction
        Result: forward shear force of the ground on the left and right track, in units of m g, shape (2,).
    """
    sideslip = unknowns[2]
    sin_beta, cos_beta = math.sin(sideslip), math.cos(sideslip)
    weighing = loads(model, point, sideslip)
    length_inverse = 1.0 / model.length
    F_x = point.gravity_forward + point.centripetal * sin_beta
    F_y = point.gravity_left - point.centripetal * cos_beta
    F_x_b = point.centripetal * cos_beta
    F_y_b = point.centripetal * sin_beta
    M = M_b = 0.0
    for track in range(2):
        side = 1.0 - 2.0 * track
        arm = side * 0.5 * model.gauge - model.cog_left
        load = weighing.left if track == 0 else weighing.right
        load_b = side * weighing.left_slope
        ground = contact(model, load, load_b, weighing.pressure_centre, weighing.pressure_centre_slope)
        motion = TrackMotion(
            unknowns[track],
            cos_beta - point.curvature * arm,
            -sin_beta,
            sin_beta - point.curvature * model.cog_forward,
            cos_beta,
            point.curvature,
        )
        middle, middle_b = split(motion, ground)
        f_x = -model.resistance * load
        f_x_b = -model.resistance * load_b
        f_y = m = f_x_V = f_y_V = m_V = f_y_b = m_b = 0.0
        for outward in (-1.0, 1.0):
            if outward < 0.0:
                stretch = Stretch(middle, ground.rear, middle_b, ground.rear_slope)
            else:
                stretch = Stretch(middle, ground.front, middle_b, ground.front_slope)
            if stretch.start != stretch.end:
                axis, layer = difficulty(motion, ground, model.shear_modulus, stretch)
                row = choose(rule, axis, layer)
                count = rule.count[row]
                shear = stretch_force(
                    motion,
                    ground,
                    model.shear_modulus,
                    stretch,
                    rule.nodes[row, :count],
                    rule.weights[row, :count],
                )
                f_x -= outward * shear.forward
                f_y -= outward * shear.left
                m -= outward * shear.moment
                f_x_V -= outward * shear.forward_by_speed
                f_y_V -= outward * shear.left_by_speed
                m_V -= outward * shear.moment_by_speed
                f_x_b -= outward * shear.forward_by_sideslip
                f_y_b -= outward * shear.left_by_sideslip
                m_b -= outward * shear.moment_by_sideslip
        traction[track] = f_x + model.resistance * load
        F_x += f_x
        F_y += f_y
        M += m - model.cog_forward * f_y - arm * f_x
        F_x_b += f_x_b
        F_y_b += f_y_b
        M_b += m_b - model.cog_forward * f_y_b - arm * f_x_b
        jacobian[0, track] = f_x_V
        jacobian[1, track] = f_y_V
        jacobian[2, track] = (m_V - model.cog_forward * f_y_V - arm * f_x_V) * length_inverse
    residual[0] = F_x
    residual[1] = F_y
    residual[2] = M * length_inverse
    jacobian[0, 2] = F_x_b
    jacobian[1, 2] = F_y_b
    jacobian[2, 2] = M_b * length_inverse
