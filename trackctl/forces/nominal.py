"""Nominal track forces along a path, and where the vehicle cannot put them on the ground."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from trackctl.forces.model import ForceModel, constraint, gravity_in_body, smooth_magnitude
from trackctl.forces.reference import Reference
from trackctl.forces.speed_profile import times
from trackctl.forces.yaw import Yaw

Array = NDArray[np.float64]
Truths = NDArray[np.bool_]

#: Residual at which a motion is none of the vehicle's. The crudest fits that are of use stay below a third of it.
UNBALANCED = 0.2


@dataclass(frozen=True, slots=True, eq=False)
class NominalForces:
    """Motion and forces at stations of the path, arrays of shape (n,).

    Attributes
    ----------
    arc_length, time
        Of the stations. [m], [s]
    x, y, yaw, yaw_rate
        Of the body. [m], [rad], [rad/s]
    speed, sideslip
        Of the mass centre; the direction of travel minus the yaw. [m/s], [rad]
    yaw_gradient
        theta_s. [1/m]
    zero_slide_offset
        D: how far ahead of the mass centre the tracks do not slide sideways. [m]
    total, difference, left, right
        Q, dQ = right - left, and the forces on each track, forward positive. [N]
    load_left, load_right
        On each track. [N]
    friction_moment
        Of the sideways friction, left positive: it opposes the turn. [N m]
    residual
        r of the constraint. [1]
    """

    arc_length: Array
    time: Array
    x: Array
    y: Array
    yaw: Array
    yaw_rate: Array
    speed: Array
    sideslip: Array
    yaw_gradient: Array
    zero_slide_offset: Array
    total: Array
    difference: Array
    left: Array
    right: Array
    load_left: Array
    load_right: Array
    friction_moment: Array
    residual: Array


def nominal_forces(model: ForceModel, reference: Reference, yaw: Yaw, stations: Array) -> NominalForces:
    """Forces that drive the motion at ascending arc lengths; from the right where they jump.

    (17) and (19) of the paper with the arm b/2, and gravity:

        Q = m (a cos(beta) + kappa z sin(beta) - g_x),
        dQ = (2/b) [I (theta_s a + theta_ss z) - M] .

    Parameters
    ----------
    model, reference
        The vehicle and what it is asked to do.
    yaw
        That satisfies the constraint.
    stations : ndarray, shape (n,)
        [m]
    """
    points = reference.at(stations)
    motion = yaw.at(stations, points)
    heading = points.tangent - motion.sideslip
    gravity = gravity_in_body(model, heading)
    magnitude = smooth_magnitude(motion.gradient, points)
    centripetal = points.curvature * points.squared_speed
    along = points.acceleration * np.cos(motion.sideslip) - centripetal * np.sin(motion.sideslip)
    yaw_acceleration = motion.gradient * points.acceleration + motion.gradient_change * points.squared_speed
    offset = -np.sin(motion.sideslip) * motion.gradient / magnitude**2
    moment = friction_moment(model, gravity.load_offset, offset, motion.gradient / magnitude)
    total = model.mass * (along - gravity.forward)
    difference = 2.0 / model.gauge * (model.yaw_inertia * yaw_acceleration - moment)
    shifted = model.mass * gravity.left * model.cog_height / model.gauge
    return NominalForces(
        arc_length=stations,
        time=times(reference.speed, stations),
        x=points.x,
        y=points.y,
        yaw=heading,
        yaw_rate=motion.gradient * points.speed,
        speed=points.speed,
        sideslip=motion.sideslip,
        yaw_gradient=motion.gradient,
        zero_slide_offset=offset,
        total=total,
        difference=difference,
        left=0.5 * (total - difference),
        right=0.5 * (total + difference),
        load_left=0.5 * model.load + shifted,
        load_right=0.5 * model.load - shifted,
        friction_moment=moment,
        residual=constraint(model, points, motion.sideslip, motion.gradient).value,
    )


def friction_moment(model: ForceModel, load_offset: Array, offset: Array, sign: Array) -> Array:
    """M = -sign(omega) mu_t (N/L) (L^2/4 - D^2 - 8 x_p D^3 / L^2), D clipped to the ground contact. [N m]"""
    clipped = np.clip(offset, -0.5 * model.length, 0.5 * model.length)
    area = 0.25 * model.length**2 - clipped**2 - 8.0 * load_offset * clipped**3 / model.length**2
    return -sign * model.lateral_friction * model.load / model.length * area


@dataclass(frozen=True, slots=True, eq=False)
class Limits:
    """Whether each station breaks a limit, arrays of shape (n,).

    Attributes
    ----------
    curvature_jump
        The path's curvature jumps here, and with it the yaw rate.
    beyond_contact
        The tracks slide to one side along their whole length: abs(D) is not below L/2.
    beyond_grip
        A track would have to drive or brake with more than its load times mu_f.
    beyond_drive
        A track would have to drive or brake with more than its drive can.
    lifted
        A track, or an end of both, carries no load.
    unbalanced
        The constraint is not met by far, so that these forces drive another motion.
    """

    curvature_jump: Truths
    beyond_contact: Truths
    beyond_grip: Truths
    beyond_drive: Truths
    lifted: Truths
    unbalanced: Truths

    @property
    def feasible(self) -> Truths:
        """Whether each station breaks none."""
        return np.asarray(~np.logical_or.reduce([getattr(self, field.name) for field in fields(self)]))


def limits(model: ForceModel, reference: Reference, forces: NominalForces) -> Limits:
    """Which stations break which limits."""
    largest = np.maximum(np.abs(forces.left), np.abs(forces.right))
    load_offset = gravity_in_body(model, forces.yaw).load_offset
    return Limits(
        curvature_jump=np.isin(forces.arc_length, reference.path.jumps),
        beyond_contact=~(np.abs(forces.zero_slide_offset) < 0.5 * model.length),
        beyond_grip=required_friction(forces) > model.longitudinal_friction,
        beyond_drive=largest > model.max_track_force,
        unbalanced=~(np.abs(forces.residual) < UNBALANCED),
        lifted=(np.minimum(forces.load_left, forces.load_right) <= 0.0) | (6.0 * np.abs(load_offset) > model.length),
    )


def required_friction(forces: NominalForces) -> Array:
    """Driving or braking force over load, of the track that needs more, shape (n,); inf where it has no load."""
    shares = [
        np.divide(np.abs(force), load, out=np.full(force.size, np.inf), where=load > 0.0)
        for force, load in ((forces.left, forces.load_left), (forces.right, forces.load_right))
    ]
    return np.asarray(np.maximum(*shares))
