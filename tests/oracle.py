"""Slope-steering equilibrium written a second time, straight from its equations: the fast kernel's oracle.

Slow and plain on purpose, and it shares no code with the package. Symbols are those of the equations: body
frame x forward, y left; angles counter-clockwise; SI units and radians throughout.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable
from typing import NamedTuple, TypeAlias, TypeVar, cast

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

Floats: TypeAlias = NDArray[np.float64]
Pair: TypeAlias = tuple[float, float]
Triple: TypeAlias = tuple[float, float, float]
Kernel = TypeVar("Kernel", bound=Callable[..., object])

NODES = 96  # A part; the largest error found in the residuals of 364 equilibria is then 1e-12.
SEARCH_NODES = 16
# The physical box, of (V_l/v, V_r/v, beta).
LOWER = np.array([0.01, 0.01, -math.radians(60.0)])
UPPER = np.array([6.0, 6.0, math.radians(60.0)])
POLISHED = 1e-12
SAME_ROOT = 1e-5


def _kernel(function: Kernel) -> Kernel:
    """Compile for speed alone: strict IEEE arithmetic, no fast-math."""
    return cast(Kernel, numba.njit(cache=True, error_model="numpy")(function))


class Symbols(NamedTuple):
    """An ``OraclePoint`` under the equations' symbols, for compiled code."""

    m: float
    B: float
    b: float
    L: float
    h: float
    c_f: float
    c_l: float
    mu: float
    K: float
    c: float
    f_r: float
    g: float
    theta: float
    v: float
    kappa: float
    phi: float


@dataclasses.dataclass(frozen=True)
class OraclePoint:
    """Vehicle, terrain, slope and motion: everything but the unknowns. SI, rad; cohesion in Pa."""

    mass: float
    gauge: float
    width: float
    length: float
    cog_height: float
    cog_forward: float
    cog_left: float
    friction: float
    shear_modulus: float
    cohesion: float
    resistance: float
    gravity: float
    slope: float
    velocity: float
    curvature: float
    heading: float

    @property
    def symbols(self) -> Symbols:
        return Symbols(*(float(value) for value in dataclasses.astuple(self)))


@_kernel
def gravity_and_acceleration(p: Symbols, beta: float) -> tuple[float, float, float, float]:
    """In-plane gravity ``(g_x, g_y)`` and acceleration ``(a_x, a_y)`` of the CG, body frame."""
    g, theta, v, kappa, phi = p.g, p.theta, p.v, p.kappa, p.phi
    r = v * kappa
    g_x = -g * math.sin(theta) * math.cos(phi)
    g_y = g * math.sin(theta) * math.sin(phi)
    return g_x, g_y, -v * r * math.sin(beta), v * r * math.cos(beta)


@_kernel
def loads(p: Symbols, beta: float) -> Triple:
    """``(N_left, N_right, x_cp)``: normal forces and the centre of pressure ahead of the contact centre."""
    m, B, h, c_f, c_l, g, theta = p.m, p.B, p.h, p.c_f, p.c_l, p.g, p.theta
    g_x, g_y, a_x, a_y = gravity_and_acceleration(p, beta)
    W = m * g * math.cos(theta)
    N_left = W * (0.5 + c_l / B) + (h / B) * m * (g_y - a_y)
    x_cp = c_f + h * (g_x - a_x) / (g * math.cos(theta))
    return N_left, W - N_left, x_cp


@_kernel
def contact(p: Symbols, x_cp: float) -> Pair:
    """Rear and front end of the loaded part of the tracks."""
    L = p.L
    if abs(x_cp) <= L / 6:
        return -L / 2, L / 2
    loaded = 3 * (L / 2 - abs(x_cp))
    if x_cp > 0:
        return L / 2 - loaded, L / 2
    return -L / 2, -L / 2 + loaded


@_kernel
def pressure(p: Symbols, N: float, x_cp: float, x: float) -> float:
    """Normal pressure: a trapezium on the full contact, else a triangle that is highest at the loaded end."""
    b, L = p.b, p.L
    if abs(x_cp) <= L / 6:
        return N / (b * L) * (1 + 12 * x_cp * x / L**2)
    rear, front = contact(p, x_cp)
    from_tip = x - rear if x_cp > 0 else front - x
    return 2 * N / (b * (front - rear)) * from_tip / (front - rear)


@_kernel
def sliding_velocity(p: Symbols, V: float, y: float, beta: float, x: float) -> Pair:
    """Velocity ``(s_x, s_y)`` over ground of the shoe at ``(x, y)`` of a track that runs at speed V."""
    c_f, c_l, v, kappa = p.c_f, p.c_l, p.v, p.kappa
    r = v * kappa
    return v * math.cos(beta) - r * (y - c_l) - V, v * math.sin(beta) + r * (x - c_f)


@_kernel
def sine_and_versine_over_angle(q: float) -> Pair:
    """``sin(q)/q`` and ``(1 - cos q)/q``; the series leaves out terms below 1e-20."""
    if abs(q) < 1e-3:
        return 1 - q**2 / 6 + q**4 / 120, q / 2 - q**3 / 24 + q**5 / 720
    return math.sin(q) / q, 2 * math.sin(q / 2) ** 2 / q


@_kernel
def shear_displacement(p: Symbols, V: float, y: float, beta: float, x: float, x_e: float) -> Pair:
    """Way ``(j_x, j_y)`` over ground since the shoe now at x entered at x_e, in the axes of that moment."""
    c_f, c_l, v, kappa = p.c_f, p.c_l, p.v, p.kappa
    v_x, v_y = v * math.cos(beta), v * math.sin(beta)
    t = (x_e - x) / V
    q = v * kappa * t
    sine, versine = sine_and_versine_over_angle(q)
    S, C = sine * t, versine * t
    j_x = v_x * S - v_y * C + (x - c_f) * math.cos(q) - (y - c_l) * math.sin(q) - (x_e - c_f)
    j_y = v_x * C + v_y * S + (x - c_f) * math.sin(q) + (y - c_l) * math.cos(q) - (y - c_l)
    return j_x, j_y


@_kernel
def shear_stress(p: Symbols, N: float, x_cp: float, V: float, y: float, beta: float, x: float) -> Pair:
    """Stress ``(tau_x, tau_y)`` the ground exerts on the track at x: against the sliding velocity."""
    mu, K, c = p.mu, p.K, p.c
    rear, front = contact(p, x_cp)
    s_x, s_y = sliding_velocity(p, V, y, beta, x)
    j_x, j_y = shear_displacement(p, V, y, beta, x, front if V > 0 else rear)
    speed = math.hypot(s_x, s_y)
    if speed == 0:
        return 0.0, 0.0
    tau = (c + mu * pressure(p, N, x_cp, x)) * -math.expm1(-math.hypot(j_x, j_y) / K)
    return -tau * s_x / speed, -tau * s_y / speed


@_kernel
def split_points(p: Symbols, V: float, beta: float, rear: float, front: float) -> Pair:
    """Points of the contact where the integrand all but kinks, on a contact from rear to front.

    ``x_0``, where the lateral sliding vanishes, and the mirror image of the leading end in it, where the
    lateral shear displacement returns to zero (to first order in the rotation). A straight line has neither.
    """
    c_f, kappa = p.c_f, p.kappa
    if kappa == 0:
        return rear, rear
    x_0 = c_f - math.sin(beta) / kappa
    mirrored = 2 * x_0 - (front if V > 0 else rear)
    return min(max(x_0, rear), front), min(max(mirrored, rear), front)


@_kernel
def smooth_step(t: float) -> Pair:
    """Quintic from 0 to 1 with flat ends, and its derivative: it crowds the nodes at both ends of a part."""
    return t**3 * (10 - 15 * t + 6 * t**2), 30 * t**2 * (1 - t) ** 2


@_kernel
def shear_resultant(
    p: Symbols, N: float, x_cp: float, V: float, y: float, beta: float, nodes: Floats, weights: Floats
) -> Triple:
    """``(F_x, F_y, M)`` of the shear stress of one track, M about the CG; nodes and weights for [0, 1]."""
    b, c_f, c_l = p.b, p.c_f, p.c_l
    rear, front = contact(p, x_cp)
    first, second = split_points(p, V, beta, rear, front)
    low, high = min(first, second), max(first, second)
    F_x = F_y = M = 0.0
    for start, end in ((rear, low), (low, high), (high, front)):
        if end <= start:
            continue
        for k in range(len(nodes)):
            position, density = smooth_step(nodes[k])
            x = start + (end - start) * position
            area = b * (end - start) * density * weights[k]
            tau_x, tau_y = shear_stress(p, N, x_cp, V, y, beta, x)
            F_x += tau_x * area
            F_y += tau_y * area
            M += ((x - c_f) * tau_y - (y - c_l) * tau_x) * area
    return F_x, F_y, M


@_kernel
def residuals(p: Symbols, V_l: float, V_r: float, beta: float, nodes: Floats, weights: Floats) -> Floats:
    """Longitudinal, lateral and moment balance over (m g, m g, m g L); NaN at lift-off and pitch-over."""
    m, B, L, c_l, f_r, g = p.m, p.B, p.L, p.c_l, p.f_r, p.g
    N_left, N_right, x_cp = loads(p, beta)
    if N_left <= 0 or N_right <= 0 or abs(x_cp) >= L / 2:
        return np.array([np.nan, np.nan, np.nan])
    g_x, g_y, a_x, a_y = gravity_and_acceleration(p, beta)
    total_x, total_y, total_moment = m * (g_x - a_x), m * (g_y - a_y), 0.0
    for N, V, y in ((N_left, V_l, B / 2), (N_right, V_r, -B / 2)):
        F_x, F_y, M = shear_resultant(p, N, x_cp, V, y, beta, nodes, weights)
        resistance = -f_r * N * np.sign(V)
        total_x += F_x + resistance
        total_y += F_y
        total_moment += M - (y - c_l) * resistance
    return np.array([total_x / (m * g), total_y / (m * g), total_moment / (m * g * L)])


@functools.cache
def gauss_rule(nodes: int) -> tuple[Floats, Floats]:
    """Gauss-Legendre nodes and weights on [0, 1]."""
    abscissae, weights = np.polynomial.legendre.leggauss(nodes)
    return (abscissae + 1) / 2, weights / 2


def balance(point: OraclePoint, speed_left: float, speed_right: float, sideslip: float, nodes: int = NODES) -> Floats:
    """Three residuals of the equilibrium, over (m g, m g, m g L); NaN at lift-off and pitch-over."""
    speeds = float(speed_left), float(speed_right)
    return np.asarray(residuals(point.symbols, *speeds, float(sideslip), *gauss_rule(nodes)))


@_kernel
def scaled_residuals(p: Symbols, u: Floats, nodes: Floats, weights: Floats) -> Floats:
    """Residuals over ``u = (V_l/v, V_r/v, beta)``; NaN too where a shoe turns half a turn on the ground."""
    L, v, kappa = p.L, p.v, p.kappa
    if abs(kappa) * L >= math.pi * min(u[0], u[1]):
        return np.array([np.nan, np.nan, np.nan])
    return residuals(p, u[0] * v, u[1] * v, u[2], nodes, weights)


@_kernel
def forward_jacobian(p: Symbols, u: Floats, residual: Floats, nodes: Floats, weights: Floats) -> Floats:
    """Jacobian of ``scaled_residuals`` by forward differences: good enough to descend with."""
    step = 1e-7
    jacobian = np.empty((3, 3))
    for k in range(3):
        ahead = u.copy()
        ahead[k] += step
        jacobian[:, k] = (scaled_residuals(p, ahead, nodes, weights) - residual) / step
    return jacobian


@_kernel
def damped_step(jacobian: Floats, residual: Floats, damping: float, u: Floats) -> Floats:
    """Levenberg-Marquardt step inside the box; components that press against a bound stay where they are."""
    gradient = jacobian.T @ residual
    matrix = jacobian.T @ jacobian
    for k in range(3):
        matrix[k, k] += damping * max(matrix[k, k], 1e-9)
    for k in range(3):
        if (u[k] <= LOWER[k] and gradient[k] > 0) or (u[k] >= UPPER[k] and gradient[k] < 0):
            matrix[k, :] = 0.0
            matrix[:, k] = 0.0
            matrix[k, k] = 1.0
            gradient[k] = 0.0
    target: Floats = u - np.linalg.solve(matrix, gradient)
    step: Floats = np.minimum(np.maximum(target, LOWER), UPPER) - u
    return step


@_kernel
def descend(p: Symbols, u: Floats, goal: float, nodes: Floats, weights: Floats) -> tuple[Floats, float]:
    """Levenberg-Marquardt from u inside the box: where it ended, and the residual norm there."""
    residual = scaled_residuals(p, u, nodes, weights)
    norm = float(np.linalg.norm(residual))
    if not np.isfinite(norm):
        return u, np.inf
    damping = 1e-3
    for _ in range(60):
        if norm < goal or damping > 1e8:
            break
        jacobian = forward_jacobian(p, u, residual, nodes, weights)
        if not np.all(np.isfinite(jacobian)):
            break
        while damping <= 1e8:
            step = damped_step(jacobian, residual, damping, u)
            trial = scaled_residuals(p, u + step, nodes, weights)
            trial_norm = float(np.linalg.norm(trial))
            if trial_norm < norm:
                u, residual, norm = u + step, trial, trial_norm
                damping = max(damping / 10, 1e-15)
                break
            damping *= 10
    return u, norm


@_kernel
def descend_all(p: Symbols, starts: Floats, goal: float, nodes: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """``descend`` from every row of starts."""
    ends = np.empty_like(starts)
    norms = np.empty(len(starts))
    for i in range(len(starts)):
        ends[i], norms[i] = descend(p, starts[i].copy(), goal, nodes, weights)
    return ends, norms


@functools.cache
def unit_points(number: int) -> Floats:
    """Halton points in the unit cube, always the same."""
    return np.asarray(qmc.Halton(3, scramble=False).random(number + 1)[1:])


def default_starts(point: OraclePoint, number: int) -> Floats:
    """Half the starts over the whole box (speeds logarithmic), half about rolling without slip."""
    wide, near = np.array_split(unit_points(number), 2)
    smallest = max(LOWER[0], 1.001 * abs(point.curvature) * point.length / math.pi)
    speeds = smallest * (UPPER[0] / smallest) ** wide[:, :2]
    everywhere = np.column_stack((speeds, UPPER[2] * (2 * wide[:, 2] - 1)))
    arms = np.array([point.gauge / 2, -point.gauge / 2]) - point.cog_left
    rolling = np.maximum(1 - point.curvature * arms, smallest)
    about = np.column_stack((rolling * 3.0 ** (2 * near[:, :2] - 1), UPPER[2] * (2 * near[:, 2] - 1)))
    return np.asarray(np.clip(np.vstack((everywhere, about)), LOWER, UPPER))


def search(point: OraclePoint, starts: int | Floats, goal: float, nodes: int = SEARCH_NODES) -> tuple[Floats, Floats]:
    """Ends ``(V_l/v, V_r/v, beta)`` and residual norms of descents from every start."""
    first = default_starts(point, starts) if isinstance(starts, int) else np.asarray(starts, dtype=float)
    return descend_all(point.symbols, first, goal, *gauss_rule(nodes))


def distinct(candidates: Floats) -> list[Floats]:
    """Rows that differ from all rows kept before."""
    kept: list[Floats] = []
    for row in candidates:
        if all(np.abs(row - other).max() > SAME_ROOT for other in kept):
            kept.append(row)
    return kept


def roots(point: OraclePoint, starts: int | Floats = 128) -> list[Triple]:
    """All equilibria ``(V_l, V_r, beta)`` in the physical box, to a residual of 1e-12, by rising sideslip.

    Parameters
    ----------
    point : OraclePoint
        Velocity above zero.
    starts : int or ndarray, shape (n, 3)
        Number of starts, or the starts themselves as ``(V_l/v, V_r/v, beta)``.
    """
    ends, norms = search(point, starts, 1e-7)
    # The coarse quadrature can lift a nearly double root off zero: the polish decides.
    candidates = distinct(ends[norms < 1e-4].round(7))
    if not candidates:
        return []
    polished, remaining = search(point, np.array(candidates), POLISHED / 100, NODES)
    v = point.velocity
    found = (u.tolist() for u in distinct(polished[remaining < POLISHED]))
    return sorted(((left * v, right * v, beta) for left, right, beta in found), key=lambda root: abs(root[2]))


def best_residual(point: OraclePoint, starts: int | Floats = 128) -> float:
    """Smallest residual norm found in the physical box."""
    ends, norms = search(point, starts, 1e-9)
    best = ends[np.argmin(norms)][None, :]
    return float(search(point, best, POLISHED / 100, NODES)[1][0])


def det_sign(point: OraclePoint, root: Triple) -> int:
    """Sign of the determinant of d(residuals)/d(V_l, V_r, beta)."""
    u = np.array([root[0] / point.velocity, root[1] / point.velocity, root[2]])
    rule = gauss_rule(NODES)
    changes = [
        scaled_residuals(point.symbols, u + step, *rule) - scaled_residuals(point.symbols, u - step, *rule)
        for step in 1e-6 * np.eye(3)
    ]
    return int(np.sign(np.linalg.det(np.array(changes))))
