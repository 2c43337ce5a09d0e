"""Balance of forces and moment on the vehicle: the three equations of the slope-steering model."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.mechanics.contact import Contact, contact, loads
from trackctl.mechanics.operating_point import OperatingPoint
from trackctl.mechanics.parameters import TrackModel
from trackctl.mechanics.quadrature import Rule, axis_through, choose
from trackctl.mechanics.shear import (
    ShearForce,
    Singularities,
    Stretch,
    TrackMotion,
    boundary_layer,
    shear_force,
    singularities,
)

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
def sharpness(near: Singularities, part: Stretch) -> float:
    """Half major axis, in half stretches, of the smallest ellipse about a stretch that meets a singularity."""
    return min(
        axis_through(near.turning, near.turning_width, part.rear, part.front),
        axis_through(near.returning, near.returning_width, part.rear, part.front),
    )


@inlined
def track_force(motion: TrackMotion, ground: Contact, shear_modulus: float, rule: Rule) -> ShearForce:
    """Shear force on a track, integrated over the stretches behind and ahead of where the lateral sliding vanishes."""
    middle, middle_b = split(motion, ground)
    near = singularities(motion, ground)
    row_behind = row_ahead = rule.counts.size
    count = 0
    if middle > ground.rear:
        behind = Stretch(ground.rear, middle)
        row_behind = choose(rule, sharpness(near, behind), boundary_layer(motion, shear_modulus, behind))
        count += rule.counts[row_behind]
    if middle < ground.front:
        ahead = Stretch(middle, ground.front)
        row_ahead = choose(rule, sharpness(near, ahead), boundary_layer(motion, shear_modulus, ahead))
        count += rule.counts[row_ahead]
    joined = rule.joined[row_behind, row_ahead]
    return shear_force(motion, ground, shear_modulus, middle, middle_b, joined, count)


@inlined
def balance(
    model: TrackModel,
    point: OperatingPoint,
    rule: Rule,
    unknowns: Array,
    residual: Array,
    jacobian: Array,
    traction: Array,
    differentiate: bool,
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
        Results, shapes (3,) and (3, 3); the second is left alone unless `differentiate`.
    traction
        Result: forward shear force of the ground on the left and right track, in units of m g, shape (2,).
    differentiate
        Whether the derivatives are wanted. As a constant in a compiled caller it saves their cost, a third of all.
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
        shear = track_force(motion, ground, model.shear_modulus, rule)
        f_x = shear.forward - model.resistance * load
        f_x_b = shear.forward_by_sideslip - model.resistance * load_b
        traction[track] = shear.forward
        F_x += f_x
        F_y += shear.left
        M += shear.moment - model.cog_forward * shear.left - arm * f_x
        F_x_b += f_x_b
        F_y_b += shear.left_by_sideslip
        M_b += shear.moment_by_sideslip - model.cog_forward * shear.left_by_sideslip - arm * f_x_b
        if differentiate:
            jacobian[0, track] = shear.forward_by_speed
            jacobian[1, track] = shear.left_by_speed
            jacobian[2, track] = length_inverse * (
                shear.moment_by_speed - model.cog_forward * shear.left_by_speed - arm * shear.forward_by_speed
            )
    residual[0] = F_x
    residual[1] = F_y
    residual[2] = M * length_inverse
    if differentiate:
        jacobian[0, 2] = F_x_b
        jacobian[1, 2] = F_y_b
        jacobian[2, 2] = M_b * length_inverse
