"""Newton's method on the nine equations of a step, with a Jacobian by differences, and the error of the step.

The Jacobian need not be exact: it is taken with few quadrature nodes, and kept for later steps of like length while
Newton's method gets on with it.

References
----------
.. [1] Hairer, Wanner, Solving ordinary differential equations II, 1996, section IV.8.
"""

from __future__ import annotations

import math

from trackctl.compiled import inlined, kernel
from trackctl.simulation.collocation import (
    DERIVATIVE,
    ERROR_WEIGHTS,
    NODES,
    REAL_EIGENVALUE,
    STAGES,
    interpolate,
    invert,
)
from trackctl.simulation.collocation_step import step_residual
from trackctl.simulation.contact_memory import Entries, Memory
from trackctl.simulation.run_state import JACOBIANS, UNKNOWNS, Run, Speeds
from trackctl.simulation.vehicle_rates import Scene, roughly

NEWTON_STEPS = 8
#: Newton stops when what it leaves is this share of the tolerance.
NEWTON_SHARE = 0.03
#: A Jacobian is kept while Newton's steps shrink by this or better.
GOOD_CONTRACTION = 0.2
#: Relative change of the step length that a Jacobian bears.
SAME_LENGTH = 1e-2
#: Step of difference quotients over the speed scale.
DIFFERENCE = 1e-6
#: Velocities below this are rest. [m/s]
REST = 1e-3


@kernel
def speed_scale(scene: Scene, run: Run, speeds: Speeds) -> float:
    """Speed that the tolerance is relative to. [m/s]"""
    scale: float = max(
        abs(run.velocity[0]),
        abs(run.velocity[1]),
        0.5 * scene.model.length * abs(run.velocity[2]),
        max(abs(speeds.left_start), abs(speeds.left_end)),
        max(abs(speeds.right_start), abs(speeds.right_end)),
        REST,
    )
    return scale


@inlined
def unit(scene: Scene, component: int) -> float:
    """What turns a velocity component into a speed: 1, 1 and half the contact length."""
    return 0.5 * scene.model.length if component == 2 else 1.0


@kernel
def linearise(scene: Scene, run: Run, h: float, speeds: Speeds, memory: Memory, entries: Entries, scale: float) -> bool:
    """Inverse Jacobian of the step by differences, and the filter of its error estimate; False if it is singular."""
    rough = roughly(scene)
    for column in range(-1, UNKNOWNS):
        j, k = max(column, 0) // 3, max(column, 0) % 3
        kept = run.change[j, k]
        # Away from zero, so that mirrored motions stay mirrored.
        difference = math.copysign(DIFFERENCE * scale / unit(scene, k), run.velocity[k])
        if column >= 0:
            run.change[j, k] = kept + difference
        step_residual(rough, run, h, speeds, memory, entries, run.beside)
        run.change[j, k] = kept
        for i in range(UNKNOWNS):
            if column < 0:
                run.about[i] = run.beside[i]
            else:
                run.matrix[i, column] = (run.beside[i] - run.about[i]) / difference
    run.linearisations += 1
    last = UNKNOWNS - 3
    for i in range(3):
        for k in range(3):
            run.small[i, k] = run.matrix[last + i, last + k]
        run.small[i, i] += (REAL_EIGENVALUE - DERIVATIVE[STAGES - 1, STAGES - 1]) / h
    run.jacobian_step[run.jacobian] = h
    return invert(run.matrix, run.inverse[run.jacobian]) and invert(run.small, run.filter[run.jacobian])


@kernel
def predict(run: Run, h: float) -> None:
    """Start of Newton's method: the last step's cubic, or else the rate at the start."""
    for i in range(STAGES):
        for k in range(3):
            if run.last_step > 0.0:
                theta = 1.0 + NODES[i] * h / run.last_step
                run.change[i, k] = interpolate(run.last[:, k], theta) - run.velocity[k]
            else:
                run.change[i, k] = NODES[i] * h * run.rate[k]


@kernel
def choose_jacobian(run: Run, h: float) -> None:
    """Choose a Jacobian that will do for a step of this length, or else a place for a new one."""
    for i in range(JACOBIANS):
        if abs(h - run.jacobian_step[i]) <= SAME_LENGTH * h:
            run.jacobian = i
            return
    run.jacobian = (run.jacobian + 1) % JACOBIANS
    run.jacobian_step[run.jacobian] = 0.0


@kernel
def newton(
    scene: Scene,
    run: Run,
    h: float,
    speeds: Speeds,
    memory: Memory,
    entries: Entries,
    scale: float,
    tolerance: float,
) -> bool:
    """Solve the step, with the Jacobian at hand or a new one; False where Newton's method does not get there."""
    reuse, worn = run.jacobian_step[run.jacobian] > 0.0, False
    before, to_come = math.inf, max(run.to_come, 1e-16) ** 0.8
    for iteration in range(NEWTON_STEPS):
        step_residual(scene, run, h, speeds, memory, entries, run.residual)
        if iteration == 0 and not reuse and not linearise(scene, run, h, speeds, memory, entries, scale):
            return False
        norm = 0.0
        for j in range(STAGES):
            for k in range(3):
                correction = 0.0
                for i in range(UNKNOWNS):
                    correction += run.inverse[run.jacobian, 3 * j + k, i] * run.residual[i]
                run.change[j, k] -= correction
                norm = max(norm, abs(correction) * unit(scene, k) / scale)
        if not norm < 1e3 or norm > 2.0 * before:
            return False
        if iteration > 0:
            contraction = norm / before
            to_come = contraction / (1.0 - contraction) if contraction < 1.0 else math.inf
            worn = reuse and contraction > GOOD_CONTRACTION
        if to_come * norm <= NEWTON_SHARE * tolerance:
            run.to_come = to_come
            if worn:
                run.jacobian_step[run.jacobian] = 0.0
            return True
        before = norm
    return False


@kernel
def error_of(scene: Scene, run: Run, h: float, scale: float) -> float:
    """Estimated error of the step's velocities over the speed scale, eq (8.20) of Hairer and Wanner."""
    worst = 0.0
    for k in range(3):
        error = 0.0
        for i in range(3):
            defect = run.rate[i]
            for j in range(STAGES):
                defect += ERROR_WEIGHTS[j] * run.change[j, i] / h
            error += run.filter[run.jacobian, k, i] * defect
        worst = max(worst, abs(error) * unit(scene, k) / scale)
    return worst


@kernel
def try_step(
    scene: Scene,
    run: Run,
    h: float,
    speeds: Speeds,
    memory: Memory,
    entries: Entries,
    tolerance: float,
) -> float:
    """Solve a step; its error over the tolerance, infinite where it could not be solved."""
    scale = speed_scale(scene, run, speeds)
    choose_jacobian(run, h)
    tries, solved = 2 if run.jacobian_step[run.jacobian] > 0.0 else 1, False
    while tries > 0 and not solved:
        predict(run, h)
        solved = newton(scene, run, h, speeds, memory, entries, scale, tolerance)
        if not solved:
            run.jacobian_step[run.jacobian] = 0.0
        tries -= 1
    if not solved:
        return math.inf
    error = error_of(scene, run, h, scale)
    run.error = error * scale
    return error / tolerance
