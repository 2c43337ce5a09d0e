"""Shear force of the ground on a stretch of track, integrated along the contact."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.mechanics.contact import Contact
from trackctl.mechanics.elementary_functions import LARGEST_HALF_ANGLE, cosine, decay, sinc

Array = NDArray[np.float64]

#: Keeps a displacement or a sliding speed of exactly zero finite; squares of lengths and of speed ratios. [m2, 1]
TINY = 1e-60


class TrackMotion(NamedTuple):
    """Motion of one track over the ground, speeds in units of the vehicle's speed.

    Attributes
    ----------
    speed
        Track speed over vehicle speed, positive. [-]
    body_speed
        Forward speed of the body along the track's centre line, v_x - r (y_i - c_l). [-]
    body_speed_slope
        Its derivative by the sideslip angle. [1/rad]
    lateral_speed
        Leftward speed of the body at x = 0, v_y - r c_f. [-]
    lateral_speed_slope
        Its derivative by the sideslip angle. [1/rad]
    curvature
        Yaw rate over speed. [1/m]
    """

    speed: float
    body_speed: float
    body_speed_slope: float
    lateral_speed: float
    lateral_speed_slope: float
    curvature: float


class Stretch(NamedTuple):
    """A stretch of track. [m]"""

    rear: float
    front: float


class Singularities(NamedTuple):
    """Where the shear force is singular along a track, at `turning +- i turning_width` and so on. [m]

    The sliding direction turns at `turning`; behind it, a shoe comes back towards its point of entry at `returning`.
    """

    turning: float
    turning_width: float
    returning: float
    returning_width: float


class ShearForce(NamedTuple):
    """Ground force on a track over the weight, and its derivatives.

    `forward`, `left` [-] and `moment` = integral of x dF_y [m]; `_by_speed` are derivatives by the track's speed ratio,
    `_by_sideslip` by the sideslip angle.
    """

    forward: float
    left: float
    moment: float
    forward_by_speed: float
    left_by_speed: float
    moment_by_speed: float
    forward_by_sideslip: float
    left_by_sideslip: float
    moment_by_sideslip: float


@kernel
def singularities(motion: TrackMotion, ground: Contact) -> Singularities:
    """The singularities nearest to the contact.

    The sliding direction is singular at x_0 +- i s_x/r, x_0 where the lateral sliding vanishes. To third order in the
    angle turned, the shear displacement vanishes at x_1 +- i w_1.
    """
    V, wx, kappa = motion.speed, motion.body_speed, motion.curvature
    if kappa == 0.0:
        return Singularities(math.inf, 0.0, math.inf, 0.0)
    radius = 1.0 / kappa
    x_0 = -motion.lateral_speed * radius
    ratio = 0.5 * wx / V
    free = 1.0 / (1.0 - ratio)
    x_1 = (x_0 - ratio * ground.front) * free
    turned = kappa * (ground.front - x_1) / V
    w_1 = (wx - V + wx * turned * turned / 12.0) * radius * free
    return Singularities(x_0, abs((wx - V) * radius), x_1, abs(w_1))


@inlined
def boundary_layer(motion: TrackMotion, shear_modulus: float, part: Stretch) -> float:
    """Exponent X of the stress that builds up as 1 - exp(-X t) along a stretch. [-]

    It does so from the point of entry, which lies ahead of the stretch or at its front.
    """
    sx = motion.body_speed - motion.speed
    sy = motion.lateral_speed + motion.curvature * 0.5 * (part.rear + part.front)
    return math.sqrt(sx * sx + sy * sy) * (part.front - part.rear) / (motion.speed * shear_modulus)


@inlined
def shear_force(
    motion: TrackMotion,
    ground: Contact,
    shear_modulus: float,
    middle: float,
    middle_slope: float,
    rule: Array,
    count: int,
) -> ShearForce:
    """Shear force on a track, by quadrature with nodes that move with the sideslip angle.

    A shoe now at x has been on the ground for tau = (x_e - x)/V and has turned by q = r tau. With S = sin(q)/r,
    C = (1 - cos q)/r and w the body's velocity there, its shear displacement is

        j_x = w_x S - w_y C - V tau,    j_y = w_x C + w_y S,

    eqs (20)-(22) of [1]_ in the body frame. (S, C) is a chord D = tau sin(q/2)/(q/2) long, turned by q/2. The stress is
    (c + mu p)(1 - exp(-j/K)), against the sliding velocity s; Q below is stress over sliding speed.

    Parameters
    ----------
    motion, ground
        Of the track.
    shear_modulus
        K. [m]
    middle, middle_slope
        Where the stretch behind meets the one ahead, and its derivative by the sideslip angle. [m, m/rad]
    rule, count
        Entry of `Rule.joined` for the two stretches, shape (4, n), and its number of nodes.

    Returns
    -------
    ShearForce
        Of the ground on the track.

    References
    ----------
    .. [1] Zhang et al., Slope-steering motion planning for unmanned tracked vehicles based on SSTP-RRT, 2023.
    """
    V, wx, dwx, kappa = motion.speed, motion.body_speed, motion.body_speed_slope, motion.curvature
    V_inverse, K_inverse = 1.0 / V, 1.0 / shear_modulus
    sx = wx - V
    # Beyond half a turn, which is outside the model, the rotation only has to stay finite.
    most_turn = LARGEST_HALF_ANGLE * V / (ground.front - ground.rear)
    turn = min(max(0.5 * kappa, -most_turn), most_turn)
    Q_0 = Q_y = Q_xy = QV_0 = QV_y = QV_xy = Qb_0 = Qb_y = Qb_xy = 0.0
    behind, dbehind = middle - ground.rear, middle_slope - ground.rear_slope
    ahead, dahead = ground.front - middle, ground.front_slope - middle_slope
    for k in range(count):
        x = ground.rear + behind * rule[0, k] + ahead * rule[1, k]
        dx = ground.rear_slope + dbehind * rule[0, k] + dahead * rule[1, k]
        weight = behind * rule[2, k] + ahead * rule[3, k]
        dweight = dbehind * rule[2, k] + dahead * rule[3, k]
        strength = ground.strength + ground.strength_gradient * x
        dstrength = ground.strength_slope + ground.strength_gradient_slope * x + ground.strength_gradient * dx
        P, dP = weight * strength, dweight * strength + weight * dstrength
        sy = motion.lateral_speed + kappa * x
        dsy = motion.lateral_speed_slope + kappa * dx
        # Shear displacement.
        travel, dtravel = ground.front - x, ground.front_slope - dx
        tau = travel * V_inverse
        z = turn * turn * tau * tau
        D, half_cos = tau * sinc(z), cosine(z)
        half_sin = turn * D
        wx_half, wy_half = wx * half_cos - sy * half_sin, wx * half_sin + sy * half_cos
        jx, jy = D * wx_half - travel, D * wy_half
        j = math.sqrt(jx * jx + TINY + jy * jy)
        s = math.sqrt(sx * sx + TINY + sy * sy)
        js_inverse = 1.0 / (j * s)
        s_inverse = js_inverse * j
        remaining = decay(j * K_inverse)
        mobilised = (1.0 - remaining) * s_inverse
        Q = P * mobilised
        # Derivatives, of j through the time on the ground and through the velocities, and of s.
        jx_half, jy_half = jx * half_cos + jy * half_sin, jy * half_cos - jx * half_sin
        j_tau = jx_half * wx_half + jy_half * wy_half
        j_b = D * (jx_half * dwx + jy_half * dsy) + dtravel * (j_tau * V_inverse - jx)
        rate = P * remaining * (js_inverse * K_inverse)
        Q_s = Q * (s_inverse * s_inverse)
        Q_V = Q_s * sx - rate * j_tau * (tau * V_inverse)
        Q_b = dP * mobilised + rate * j_b - Q_s * (sx * dwx + sy * dsy)
        # Sums.
        F_y, F_y_b = Q * sy, Q_b * sy + Q * dsy
        Q_0 += Q
        Q_y += F_y
        Q_xy += x * F_y
        QV_0 += Q_V
        QV_y += Q_V * sy
        QV_xy += Q_V * sy * x
        Qb_0 += Q_b
        Qb_y += F_y_b
        Qb_xy += x * F_y_b + dx * F_y
    return ShearForce(-sx * Q_0, -Q_y, -Q_xy, Q_0 - sx * QV_0, -QV_y, -QV_xy, -sx * Qb_0 - dwx * Q_0, -Qb_y, -Qb_xy)
