"""Extended Kalman filter on the parameters of the slip model: one measured motion against its prediction."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.identification.slip_model import PARAMETERS

Array = NDArray[np.float64]

#: Rows of a measurement: a pose change, or its heading alone. [-]
POSE_ROWS, HEADING_ROWS = 3, 1
HEADING = 2
#: Chi-square of 99.9 % for three rows and for one.
POSE_GATE, HEADING_GATE = 16.266, 10.828
#: After this many rejections in a row P is widened and the next measurement accepted.
MOST_REJECTIONS = 3
#: Variances are capped at this many prior ones.
WIDEST = 4.0
#: An innovation teaches the model's error no more than one of this many standard deviations would.
CLIP = 3.0
#: Motion that the model's error is not learned from: what a small one shows is noise. [m2], [rad2]
SMALL_MOTION = 0.01

ESTIMATE = np.dtype(
    [
        ("p", np.float64, PARAMETERS),
        ("P", np.float64, (PARAMETERS, PARAMETERS)),
        ("prior", np.float64, PARAMETERS),  # variances that P starts from
        ("drift", np.float64),  # q, in prior variances a second [1/s]
        ("memory", np.float64),  # time over which the model's error is averaged [s]
        ("position_error", np.float64),  # square of the model's error over the distance rolled [-]
        ("heading_error", np.float64),  # the same over the angle turned [-]
        ("rejections", np.int64),  # in a row
        # A measurement, and the estimate that it would give.
        ("innovation", np.float64, 3),  # x, y [m], heading [rad]
        ("H", np.float64, (3, PARAMETERS)),
        ("R", np.float64, (3, 3)),
        ("independent_innovation", np.float64, 3),
        ("independent_H", np.float64, (3, PARAMETERS)),
        ("independent_R", np.float64, (3, 3)),
        ("trial_p", np.float64, PARAMETERS),
        ("trial_P", np.float64, (PARAMETERS, PARAMETERS)),
        ("gain", np.float64, PARAMETERS),
    ],
    align=True,
)
Estimate = Any


@kernel
def drift(estimate: Estimate, duration: float) -> None:
    """Let the parameters wander: P grows by q dt."""
    for i in range(PARAMETERS):
        estimate.P[i, i] += estimate.drift * duration * estimate.prior[i]
    cap(estimate)


@kernel
def widen(estimate: Estimate) -> None:
    """Add the prior to P: the parameters may have changed."""
    for i in range(PARAMETERS):
        estimate.P[i, i] += estimate.prior[i]
    cap(estimate)


@kernel
def forget(estimate: Estimate) -> None:
    """Go back to the prior."""
    estimate.rejections = 0
    estimate.p[:] = 0.0
    estimate.P[:] = 0.0
    widen(estimate)


@kernel
def cap(estimate: Estimate) -> None:
    """Scale rows and columns of P so that no variance exceeds `WIDEST` prior ones."""
    P = estimate.P
    for i in range(PARAMETERS):
        widest = WIDEST * estimate.prior[i]
        if P[i, i] > widest:
            scale = math.sqrt(widest / P[i, i])
            for j in range(PARAMETERS):
                P[i, j] *= scale
                P[j, i] *= scale


@kernel
def add_model_error(estimate: Estimate, rows: int, rolled: float, turned: float, duration: float) -> None:
    """Add the model's own error to R, and learn it: what innovations have beyond P and the sensors' noise.

    It is a share of the motion, averaged over `memory`; a log at rest says nothing on it.
    """
    R, H, P = estimate.R, estimate.H, estimate.P
    share = min(duration / estimate.memory, 0.5)
    rolled, turned = rolled * rolled, turned * turned
    R[0, 0] += estimate.position_error * rolled
    R[1, 1] += estimate.position_error * rolled
    R[2, 2] += estimate.heading_error * turned
    in_position = 0.0
    for row in range(3 - rows, 3):
        variance = R[row, row]
        for i in range(PARAMETERS):
            for j in range(PARAMETERS):
                variance += H[row, i] * P[i, j] * H[row, j]
        surplus = min(estimate.innovation[row] ** 2, CLIP * CLIP * variance) - variance
        if row == HEADING:
            learned = estimate.heading_error + share * surplus * turned / (turned + SMALL_MOTION) ** 2
            estimate.heading_error = max(0.0, learned)
        else:
            in_position += 0.5 * surplus
    learned = estimate.position_error + share * in_position * rolled / (rolled + SMALL_MOTION) ** 2
    estimate.position_error = max(0.0, learned)


@kernel
def make_independent(estimate: Estimate, rows: int, scale: float) -> None:
    """The measurement with its R times `scale`, as rows with independent noise.

    R = L D L' with the heading first; the rows become L^-1 of them, D the diagonal of `independent_R`.
    """
    z, H, R = estimate.independent_innovation, estimate.independent_H, estimate.independent_R
    z[:] = estimate.innovation
    H[:] = estimate.H
    for i in range(3):
        for j in range(3):
            R[i, j] = scale * estimate.R[i, j]
    for done in range(2, 3 - rows, -1):
        for row in range(done - 1, 2 - rows, -1):
            factor = R[row, done] / R[done, done]
            z[row] -= factor * z[done]
            for i in range(PARAMETERS):
                H[row, i] -= factor * H[done, i]
            for column in range(3):
                R[row, column] -= factor * R[done, column]


@kernel
def misfit(estimate: Estimate, rows: int, innovation: Array) -> float:
    """The misfit z' R^-1 z of an innovation z, for the R of the last `make_independent`."""
    z, R = estimate.independent_innovation, estimate.independent_R
    z[:] = innovation
    total = 0.0
    for row in range(2, 2 - rows, -1):
        for done in range(2, row, -1):
            z[row] -= R[done, row] / R[done, done] * z[done]
        total += z[row] * z[row] / R[row, row]
    return total


@kernel
def try_update(estimate: Estimate, rows: int, scale: float) -> float:
    """The update by the measurement with its R times `scale`, on a copy; returns its chi-square."""
    make_independent(estimate, rows, scale)
    p, P = estimate.trial_p, estimate.trial_P
    p[:] = estimate.p
    P[:] = estimate.P
    chi_square = 0.0
    for row in range(2, 2 - rows, -1):
        z = estimate.independent_innovation[row]
        for i in range(PARAMETERS):
            z -= estimate.independent_H[row, i] * (p[i] - estimate.p[i])
        h, r = estimate.independent_H[row], estimate.independent_R[row, row]
        chi_square += update_by_row(z, h, r, p, P, estimate.gain)
    return chi_square


@kernel
def update_by_row(z: float, h: Array, r: float, p: Array, P: Array, gain: Array) -> float:
    """Update by a scalar z = h p with noise r, in Joseph form; returns z^2 over its variance."""
    variance = r
    for i in range(PARAMETERS):
        gain[i] = 0.0
        for j in range(PARAMETERS):
            gain[i] += P[i, j] * h[j]
        variance += h[i] * gain[i]
    # (I - K h) P (I - K h)' + K r K' with K = P h / s: the sum of -2 K (P h)' and K s K'.
    for i in range(PARAMETERS):
        K_i = gain[i] / variance
        p[i] += K_i * z
        for j in range(i + 1):
            K_j = gain[j] / variance
            P[i, j] += K_i * variance * K_j - K_i * gain[j] - gain[i] * K_j
            P[j, i] = P[i, j]
    return z * z / variance


@inlined
def accept(estimate: Estimate) -> None:
    """Make the last trial the estimate."""
    estimate.rejections = 0
    estimate.p[:] = estimate.trial_p
    estimate.P[:] = estimate.trial_P
