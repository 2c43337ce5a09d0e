"""Shear force of the ground on a stretch of track, integrated along the contact."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.mechanics.contact import Contact
from trackctl.mechanics.elementary_functions import LARGEST_HALF_ANGLE, cosine, decay, sinc
from trackctl.mechanics.quadrature import axis_through

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
    """A stretch of track from `start` to `end`, either of which may be ahead, moving with the sideslip angle. [m, m/rad]."""

    start: float
    end: float
    start_slope: float
    end_slope: float


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
def difficulty(
    motion: TrackMotion, ground: Contact, shear_modulus: float, part: Stretch
) -> tuple[float, float]:
    """What the shear force asks of a quadrature: its ellipse of analyticity, and its boundary layer.

    The sliding direction is singular at x_0 +- i s_x/r, x_0 where the lateral sliding vanishes. Behind x_0, a shoe comes
    back towards its point of entry at x_1; to third order in the angle turned, its displacement vanishes at x_1 +- i w_1.
    Where the stretch begins at the entry, the stress builds up as 1 - exp(-X t).

    Returns
    -------
    tuple of float
        Half major axis of the ellipse in half stretches [-], exponent X of the layer [-].
    """
    V, wx, kappa = motion.speed, motion.body_speed, motion.curvature
    sx = wx - V
    axis = math.inf
    if kappa != 0.0:
        x_0 = -motion.lateral_speed / kappa
        axis = axis_through(x_0, abs(sx / kappa), part.start, part.end)
        if part.end < part.start:
            ratio = 0.5 * wx / V
            x_1 = (x_0 - ratio * ground.front) / (1.0 - ratio)
            turned = kappa * (ground.front - x_1) / V
            w_1 = abs((sx + wx * turned * turned / 12.0) / (kappa * (1.0 - ratio)))
            axis = min(axis, axis_through(x_1, w_1, part.start, part.end))
    layer = 0.0
    if part.start == ground.front or part.end == ground.front:
        middle = motion.lateral_speed + kappa * 0.5 * (part.start + part.end)
        layer = math.sqrt(sx * sx + middle * middle) * abs(part.end - part.start) / (V * shear_modulus)
    return axis, layer


@kernel
def stretch_force(
    motion: TrackMotion, ground: Contact, shear_modulus: float, part: Stretch, nodes: Array, weights: Array
) -> ShearForce:
    """Shear force on one smooth stretch of track, by quadrature with nodes that move with its ends.

    A shoe now at x has been on the ground for tau = (x_e - x)/V and has turned by q = r tau. With S = sin(q)/r,
    C = (1 - cos q)/r and w the body's velocity there, its shear displacement is

        j_x = w_x S - w_y C - V tau,    j_y = w_x C + w_y S,

    eqs (20)-(22) of [1]_ in the body frame. The stress is (c + mu p)(1 - exp(-j/K)), against the sliding velocity.

    Parameters
    ----------
    motion, ground
        Of the track.
    shear_modulus
        K. [m]
    part
        Where to integrate.
    nodes, weights
        Quadrature rule on [0, 1], shape (n,).

    Returns
    -------
    ShearForce
        The integrals are of the stress along the *sliding* direction: the force is their negative.

    References
    ----------
    .. [1] Zhang et al., Slope-steering motion planning for unmanned tracked vehicles based on SSTP-RRT, 2023.
    """
    V, wx, dwx, kappa = motion.speed, motion.body_speed, motion.body_speed_slope, motion.curvature
    V_inverse, K_inverse = 1.0 / V, 1.0 / shear_modulus
    sx = wx - V
    length, dlength = part.end - part.start, part.end_slope - part.start_slope
    F_x = F_y = M = F_x_V = F_y_V = M_V = F_x_b = F_y_b = M_b = 0.0
    for k in range(nodes.size):
        x = part.start + length * nodes[k]
        dx = part.start_slope + dlength * nodes[k]
        weight = length * weights[k]
        dweight = dlength * weights[k]
        # Shear displacement.
        tau = (ground.front - x) * V_inverse
        half = min(max(0.5 * kappa * tau, -LARGEST_HALF_ANGLE), LARGEST_HALF_ANGLE)
        z = half * half
        half_sinc, half_cos = sinc(z), cosine(z)
        half_sin = half * half_sinc
        S = tau * half_sinc * half_cos
        C = tau * half_sinc * half_sin
        sin_q = 2.0 * half_sin * half_cos
        cos_q = 1.0 - 2.0 * half_sin * half_sin
        sy = motion.lateral_speed + kappa * x
        dsy = motion.lateral_speed_slope + kappa * dx
        jx = wx * S - sy * C - V * tau
        jy = wx * C + sy * S
        j_inverse = 1.0 / math.sqrt(jx * jx + jy * jy + TINY)
        j = (jx * jx + jy * jy) * j_inverse
        remaining = decay(j * K_inverse)
        # Its derivatives: through the time on the ground, and through the velocities.
        along = (jx * (wx * cos_q - sy * sin_q) + jy * (wx * sin_q + sy * cos_q)) * j_inverse
        dtau = (ground.front_slope - dx) * V_inverse
        j_V = -along * tau * V_inverse
        j_b = along * dtau + j_inverse * (
            jx * (dwx * S - dsy * C - V * dtau) + jy * (dwx * C + dsy * S)
        )  # fmt: skip
        rate = remaining * K_inverse
        # Sliding direction.
        s_inverse = 1.0 / math.sqrt(sx * sx + sy * sy + TINY)
        nx, ny = sx * s_inverse, sy * s_inverse
        turn_V = -ny * s_inverse
        turn_b = (ny * dwx - nx * dsy) * s_inverse
        mobilised = 1.0 - remaining
        Tx, Ty = mobilised * nx, mobilised * ny
        Tx_V = rate * j_V * nx + mobilised * ny * turn_V
        Ty_V = rate * j_V * ny - mobilised * nx * turn_V
        Tx_b = rate * j_b * nx + mobilised * ny * turn_b
        Ty_b = rate * j_b * ny - mobilised * nx * turn_b
        # Sums.
        strength = ground.strength + ground.strength_gradient * x
        dstrength = ground.strength_slope + ground.strength_gradient_slope * x + ground.strength_gradient * dx
        P = weight * strength
        dP = dweight * strength + weight * dstrength
        F_x += P * Tx
        F_y += P * Ty
        M += P * x * Ty
        F_x_V += P * Tx_V
        F_y_V += P * Ty_V
        M_V += P * x * Ty_V
        F_x_b += dP * Tx + P * Tx_b
        F_y_b += dP * Ty + P * Ty_b
        M_b += dP * x * Ty + P * (dx * Ty + x * Ty_b)
    return ShearForce(F_x, F_y, M, F_x_V, F_y_V, M_V, F_x_b, F_y_b, M_b)
