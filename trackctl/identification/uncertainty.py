"""How sure the parameters of a robust fit to steady motions are, with noise and with an error of the model."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

Array = NDArray[np.float64]

#: Information, relative to the most, that counts as none.
NOTHING = 1e-9
#: Standard deviations (99 %) above which neighbours have more in common than noise has.
IN_COMMON = 2.33


def standard_deviations(jacobian: Array, residuals: Array, speeds: Array) -> tuple[Array, Array]:
    """Of the parameters of a robust fit, each of shape (n,): by noise, and by an error of the model.

    Huge where nothing depends on a parameter. That by noise is the larger one of what the weights W of the loss soft_l1
    and what the residuals make likely; the latter is the sandwich (J'WJ)^-1 J' psi^2 J (J'WJ)^-1, psi = W r: where few
    motions near the limit of grip tell all, it is much larger.

    An error e of the model shifts a parameter by no more than sqrt((J'WJ)^-1_jj e'We), after Cauchy and Schwarz. How
    large it is, is seen in what it leaves; what the parameters make up for in full, no fit can show.

    Parameters
    ----------
    jacobian : ndarray, shape (3 m, n)
        Of the residuals by the parameters.
    residuals : ndarray, shape (3 m,)
        Of forward and lateral velocity and yaw rate of each motion, in standard deviations.
    speeds : ndarray, shape (m, 2)
        Left and right track speed, forward. [m/s]
    """
    weight = 1.0 / np.sqrt(1.0 + residuals**2)
    information = jacobian.T @ (jacobian * weight[:, None])
    scale = np.sqrt(np.maximum(np.diag(information), 1e-12))
    size, direction = np.linalg.eigh(information / np.outer(scale, scale))
    bread = (direction / np.maximum(size, NOTHING)) @ direction.T / np.outer(scale, scale)
    scores = jacobian * (residuals * weight)[:, None]
    sandwich = bread @ (scores.T @ scores) @ bread
    noise = np.sqrt(np.maximum(np.diag(bread), np.diag(sandwich)))
    return noise, model_error((residuals * weight).reshape(-1, 3), speeds) * np.sqrt(np.diag(bread))


def model_error(residuals: Array, speeds: Array) -> float:
    """Norm of that part of the residuals, shape (m, 3), that is no noise: what motions at like speeds have in common.

    Left and right turns count as mirror images. The mean product of neighbours' residuals is the square of what they
    share; in a channel where it may be by chance it counts as none.
    """
    if len(residuals) < 2:
        return 0.0
    to_right = (speeds[:, 1] < speeds[:, 0])[:, None]
    mirrored = residuals * np.where(to_right, [1.0, -1.0, -1.0], 1.0)
    beside = mirrored[neighbours(np.where(to_right, speeds[:, ::-1], speeds))]
    shared, squares = (mirrored * beside).mean(axis=0), (mirrored**2).mean(axis=0)
    # Of two motions each may be the other's neighbour: half the products are new.
    known = shared * np.sqrt(0.5 * len(residuals)) > IN_COMMON * squares
    return math.sqrt(len(residuals) * float(shared[known].sum()))


def neighbours(places: Array) -> NDArray[np.intp]:
    """Index of the nearest other one of each of at least two places."""
    nearest = np.reshape(KDTree(places).query(places, k=2)[1], (-1, 2))
    return np.where(nearest[:, 0] == np.arange(len(places)), nearest[:, 1], nearest[:, 0])
