"""Steady motion on level ground under given track speeds, by the balance of the slope-steering model."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.mechanics.equilibrium import balance
from trackctl.mechanics.limits import ADMISSIBLE, exceeded_limit
from trackctl.mechanics.operating_point import OperatingPoint
from trackctl.mechanics.parameters import TrackModel
from trackctl.mechanics.quadrature import Rule, rules
from trackctl.solvers import levenberg_marquardt as lm
from trackctl.solvers.workspace import Workspace, workspace

Array = NDArray[np.float64]

#: Largest residual of a solution, in units of m g and m g L.
TOLERANCE = 1e-9
EVALUATIONS = 60
#: Step of the difference quotients, and the box of the unknowns: v over the mean track speed, kappa times the gauge,
#: and sideslip. [-], [-], [rad]
STEP = 1e-6
LOWER, UPPER = (0.05, -1.99, -1.0), (3.0, 1.99, 1.0)
#: How much wider than the tracks a vehicle turns, for a first guess. [-]
WIDENING = 1.3


def steady_motions(model: TrackModel, speeds: Array, starts: Array | None = None) -> Array:
    """Steady motion for each pair of track speeds.

    Parameters
    ----------
    model
        Vehicle on its terrain.
    speeds : ndarray, shape (n, 2)
        Left and right track speed, both forward. [m/s]
    starts : ndarray, shape (n, 3), optional
        Motions to start from, such as those of a similar model.

    Returns
    -------
    ndarray, shape (n, 3)
        Forward and lateral velocity of the mass centre [m/s] and yaw rate [rad/s]; NaN where there is no equilibrium
        that the model holds for.
    """
    mean = speeds.mean(axis=1)
    guess = np.column_stack((mean, np.zeros(len(mean)), (speeds[:, 1] - speeds[:, 0]) / (WIDENING * model.gauge)))
    motions = guess.copy()
    if starts is not None:
        motions = np.where(np.all(np.isfinite(starts), axis=1)[:, None], starts, guess)
    solve_all(model, RULE, np.ascontiguousarray(speeds), motions, np.zeros(1, workspace(3)), np.empty((3, 3)))
    return motions


@kernel
def solve_all(model: TrackModel, rule: Rule, speeds: Array, motions: Array, memory: Array, scratch: Array) -> None:
    """Improve the rows of `motions` to solutions, or NaN."""
    work = memory[0]
    lower, upper = np.array(LOWER), np.array(UPPER)
    x = np.empty(3)
    for row in range(speeds.shape[0]):
        left, right = speeds[row, 0], speeds[row, 1]
        mean = 0.5 * (left + right)
        v = max(math.hypot(motions[row, 0], motions[row, 1]), LOWER[0] * mean)
        x[0], x[1] = v / mean, model.gauge * motions[row, 2] / v
        x[2] = math.atan2(motions[row, 1], motions[row, 0])
        for i in range(3):
            x[i] = min(max(x[i], lower[i]), upper[i])
        if solve(model, rule, left, right, x, lower, upper, work, scratch):
            v = x[0] * mean
            motions[row, 0], motions[row, 1] = v * math.cos(x[2]), v * math.sin(x[2])
            motions[row, 2] = v * x[1] / model.gauge
        else:
            motions[row] = math.nan


@kernel
def solve(
    model: TrackModel, rule: Rule, left: float, right: float, x: Array, lower: Array, upper: Array, work: Workspace,
    scratch: Array,
) -> bool:  # fmt: skip
    """Levenberg-Marquardt from x; True if it ends in an equilibrium that the model holds for."""
    slopes(model, rule, left, right, x, work.residual, work.jacobian, scratch)
    damping, evaluations = 0.0, 1
    while not lm.is_solved(work, TOLERANCE):
        if evaluations >= EVALUATIONS or damping > lm.LARGEST_DAMPING:
            return False
        if lm.propose(x, damping, lower, upper, work):
            slopes(model, rule, left, right, work.trial, work.trial_residual, work.trial_jacobian, scratch)
            evaluations += 1
            damping = lm.judge(x, damping, work)
        else:
            damping = lm.more_damping(damping)
    return steady_residual(model, rule, left, right, x, work.residual, scratch) == ADMISSIBLE


@kernel
def slopes(
    model: TrackModel, rule: Rule, left: float, right: float, x: Array, residual: Array, jacobian: Array, scratch: Array
) -> None:
    """Residual and its derivatives by the unknowns, from differences."""
    steady_residual(model, rule, left, right, x, residual, scratch)
    moved = scratch[2]
    for j in range(3):
        kept = x[j]
        x[j] = kept + STEP
        steady_residual(model, rule, left, right, x, moved, scratch)
        x[j] = kept
        for i in range(3):
            jacobian[i, j] = (moved[i] - residual[i]) / STEP


@kernel
def steady_residual(
    model: TrackModel, rule: Rule, left: float, right: float, x: Array, residual: Array, scratch: Array
) -> int:
    """Residual of the balance for the unknowns v over the mean track speed, kappa B and sideslip.

    Returns the limit that they exceed, of `trackctl.mechanics.limits`.
    """
    mean = 0.5 * (left + right)
    v, curvature = x[0] * mean, x[1] / model.gauge
    point = OperatingPoint(0.0, 0.0, 1.0, curvature, v * v * curvature / model.gravity)
    unknowns, traction = scratch[0], scratch[1]
    unknowns[0], unknowns[1], unknowns[2] = left / v, right / v, x[2]
    jacobian = np.empty((3, 3))
    balance(model, point, rule, unknowns, residual, jacobian, traction, True)
    return exceeded_limit(model, point, unknowns)


RULE = rules()
