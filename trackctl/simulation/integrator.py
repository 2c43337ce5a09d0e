"""Error-controlled implicit integration of a vehicle's motion, with the memory of its contact as part of the state.

The unknowns of a step are the body's velocities at the nodes of `collocation`; positions follow by integration. The
shear displacement of shoes that enter the ground during a step depends on the step itself: their points of entry are
those of the trial motion, so that the whole step is one system of nine equations (a collocation method for delay
equations, as in RADAR5). Newton's method solves it with a Jacobian by differences.

References
----------
.. [1] Guglielmi, Hairer, Implementing Radau IIA methods for stiff delay differential equations, 2001.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.simulation.collocation import (
    DERIVATIVE,
    ERROR_WEIGHTS,
    INTEGRAL,
    NODES,
    REAL_EIGENVALUE,
    STAGES,
    TO_CUBIC,
    interpolate,
    invert,
)
from trackctl.simulation.contact_memory import Entries, Memory, forget, newest, push, slot, withdraw
from trackctl.simulation.vehicle_rates import Scene, track_loads, vehicle_rates

Array = NDArray[np.float64]

UNKNOWNS = 3 * STAGES
#: How `advance` ends.
DONE, STORE_FULL, RING_FULL, TURNED, LIFTED, PITCHED, STUCK = range(7)

SMALLEST_STEP = 1e-9
NEWTON_STEPS = 8
#: Newton stops when its step is this share of the tolerance.
NEWTON_SHARE = 0.03
#: A Jacobian is kept while Newton's steps shrink by this or better.
GOOD_CONTRACTION = 0.2
SAFETY, MOST_GROWTH, MOST_SHRINKING = 0.85, 4.0, 0.2
#: A step is not lengthened by less than this, so that the Jacobian can be kept.
LEAST_GROWTH = 1.2
#: Relative change of the step length that a Jacobian bears.
SAME_LENGTH = 1e-2
#: Step of difference quotients over the speed scale.
DIFFERENCE = 1e-6
#: Change of the rates at which they are consistent, over gravity.
SETTLED = 1e-7
#: Velocities below this are rest. [m/s]
REST = 1e-3

#: A track speed piece: both track speeds are linear in time.
PIECE = np.dtype(
    [("start", np.float64), ("end", np.float64), ("left", np.float64, 2), ("right", np.float64, 2)], align=True
)
#: An accepted step: pose and velocity at its start and nodes, and the track speeds at its ends.
STEP = np.dtype(
    [
        ("time", np.float64),
        ("length", np.float64),
        ("pose", np.float64, (STAGES + 1, 3)),
        ("velocity", np.float64, (STAGES + 1, 3)),
        ("left", np.float64, 2),
        ("right", np.float64, 2),
    ],
    align=True,
)
#: The state of an integration between two steps, and the memory that a step works in.
RUN = np.dtype(
    [
        ("time", np.float64),
        ("pose", np.float64, 3),
        ("velocity", np.float64, 3),
        ("rate", np.float64, 3),
        ("step", np.float64),  # length to try next
        ("piece", np.int64),
        ("begun", np.bool_),  # whether the piece has been begun
        ("last_step", np.float64),  # 0 where the last step says nothing about the next
        ("last", np.float64, (STAGES + 1, 3)),
        ("jacobian_step", np.float64),  # length of the step of the Jacobian, 0 where it is too old
        ("inverse", np.float64, (UNKNOWNS, UNKNOWNS)),
        ("filter", np.float64, (3, 3)),
        ("change", np.float64, (STAGES, 3)),
        ("poses", np.float64, (STAGES + 1, 3)),
        ("velocities", np.float64, (STAGES + 1, 3)),
        ("stage_rate", np.float64, 3),
        ("force_rate", np.float64, 3),
        ("residual", np.float64, UNKNOWNS),
        ("beside", np.float64, UNKNOWNS),
        ("matrix", np.float64, (UNKNOWNS, UNKNOWNS)),
        ("small", np.float64, (3, 3)),
        ("travel", np.float64, 2),
        ("evaluations", np.int64),
        ("rejected", np.int64),
    ],
    align=True,
)
Run = Any
Pieces = Any
Steps = Any


class Speeds(NamedTuple):
    """Track speeds at the start and end of a step. [m/s]"""

    left_start: float
    left_end: float
    right_start: float
    right_end: float


class Settings(NamedTuple):
    """Relative tolerance of a step, longest step [s], and the turn at which to stop. [rad]"""

    tolerance: float
    longest_step: float
    most_turn: float


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


@kernel
def unit(scene: Scene, component: int) -> float:
    """What turns a velocity component into a speed: 1, 1 and half the contact length."""
    return 0.5 * scene.model.length if component == 2 else 1.0


@kernel
def lay_down(scene: Scene, run: Run, h: float, speeds: Speeds, memory: Memory, entries: Entries) -> None:
    """The pieces of memory that the trial step lays down."""
    model = scene.model
    for track in range(2):
        start = speeds.left_start if track == 0 else speeds.right_start
        end = speeds.left_end if track == 0 else speeds.right_end
        if start + end == 0.0:
            continue
        side = math.copysign(1.0, start + end)
        arm = (0.5 - track) * model.gauge - model.cog_left
        lever = side * 0.5 * model.length - model.cog_forward
        entry = entries[track, slot(memory[track], entries[track], newest(memory[track], side))]
        entry.label = run.travel[track] + side * 0.5 * model.length
        entry.rate = h * start
        entry.change = 0.5 * h * (end - start)
        stop = entry.label + entry.rate + entry.change
        entry.lower, entry.upper = min(entry.label, stop), max(entry.label, stop)
        entry.rough_below, entry.rough_above = memory[track].fresh and side > 0.0, memory[track].fresh and side < 0.0
        for i in range(STAGES + 1):
            entry.x[i] = entry.y[i] = entry.forward_x[i] = entry.forward_y[i] = 0.0
        for j in range(STAGES + 1):
            forward_x, forward_y = math.cos(run.poses[j, 2]), math.sin(run.poses[j, 2])
            x = run.poses[j, 0] + lever * forward_x - arm * forward_y
            y = run.poses[j, 1] + lever * forward_y + arm * forward_x
            for i in range(STAGES + 1):
                entry.x[i] += TO_CUBIC[i, j] * x
                entry.y[i] += TO_CUBIC[i, j] * y
                entry.forward_x[i] += TO_CUBIC[i, j] * forward_x
                entry.forward_y[i] += TO_CUBIC[i, j] * forward_y


@kernel
def set_poses(run: Run, h: float) -> None:
    """Velocities and poses at the nodes, from the changes of the velocities."""
    for k in range(3):
        run.velocities[0, k] = run.velocity[k]
        run.poses[0, k] = run.pose[k]
        for i in range(STAGES):
            run.velocities[i + 1, k] = run.velocity[k] + run.change[i, k]
            run.poses[i + 1, k] = run.pose[k]
    for i in range(STAGES):
        for j in range(STAGES):
            run.poses[i + 1, 2] += h * INTEGRAL[i, j] * run.velocities[j + 1, 2]
    for j in range(STAGES):
        cos_yaw, sin_yaw = math.cos(run.poses[j + 1, 2]), math.sin(run.poses[j + 1, 2])
        x_rate = run.velocities[j + 1, 0] * cos_yaw - run.velocities[j + 1, 1] * sin_yaw
        y_rate = run.velocities[j + 1, 0] * sin_yaw + run.velocities[j + 1, 1] * cos_yaw
        for i in range(STAGES):
            run.poses[i + 1, 0] += h * INTEGRAL[i, j] * x_rate
            run.poses[i + 1, 1] += h * INTEGRAL[i, j] * y_rate


@kernel
def set_travel(run: Run, h: float, speeds: Speeds, memory: Memory, theta: float) -> None:
    """Way travelled by the tracks at theta."""
    left = theta * speeds.left_start + 0.5 * theta * theta * (speeds.left_end - speeds.left_start)
    right = theta * speeds.right_start + 0.5 * theta * theta * (speeds.right_end - speeds.right_start)
    memory[0].travel = run.travel[0] + h * left
    memory[1].travel = run.travel[1] + h * right


@kernel
def step_residual(
    scene: Scene, run: Run, h: float, speeds: Speeds, memory: Memory, entries: Entries, residual: Array
) -> None:
    """Rates of the velocity cubic less those that the forces give, at the nodes."""
    set_poses(run, h)
    if scene.remember:
        lay_down(scene, run, h, speeds, memory, entries)
    for i in range(STAGES):
        theta = NODES[i]
        for k in range(3):
            rate = 0.0
            for j in range(STAGES):
                rate += DERIVATIVE[i, j] * run.change[j, k]
            run.stage_rate[k] = rate / h
        set_travel(run, h, speeds, memory, theta)
        left = speeds.left_start + theta * (speeds.left_end - speeds.left_start)
        right = speeds.right_start + theta * (speeds.right_end - speeds.right_start)
        vehicle_rates(
            scene, run.poses[i + 1], run.velocities[i + 1], run.stage_rate, left, right, memory, entries, run.force_rate
        )
        run.evaluations += 1
        for k in range(3):
            residual[3 * i + k] = run.stage_rate[k] - run.force_rate[k]


@kernel
def linearise(scene: Scene, run: Run, h: float, speeds: Speeds, memory: Memory, entries: Entries, scale: float) -> bool:
    """Inverse Jacobian of the step by differences, and the filter of its error estimate; False if it is singular."""
    for j in range(STAGES):
        for k in range(3):
            kept = run.change[j, k]
            difference = DIFFERENCE * scale / unit(scene, k)
            run.change[j, k] = kept + difference
            step_residual(scene, run, h, speeds, memory, entries, run.beside)
            run.change[j, k] = kept
            for i in range(UNKNOWNS):
                run.matrix[i, 3 * j + k] = (run.beside[i] - run.residual[i]) / difference
    last = UNKNOWNS - 3
    for i in range(3):
        for k in range(3):
            run.small[i, k] = run.matrix[last + i, last + k]
        run.small[i, i] += (REAL_EIGENVALUE - DERIVATIVE[STAGES - 1, STAGES - 1]) / h
    run.jacobian_step = h
    return invert(run.matrix, run.inverse) and invert(run.small, run.filter)


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
def jacobian_is_kept(run: Run, h: float) -> bool:
    """Whether the Jacobian at hand will do for a step of this length."""
    return bool(abs(h - run.jacobian_step) <= SAME_LENGTH * h)


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
    """Solve the step; False where Newton's method does not get there."""
    before = math.inf
    for iteration in range(NEWTON_STEPS):
        step_residual(scene, run, h, speeds, memory, entries, run.residual)
        if not jacobian_is_kept(run, h) and not linearise(scene, run, h, speeds, memory, entries, scale):
            return False
        norm = 0.0
        for j in range(STAGES):
            for k in range(3):
                correction = 0.0
                for i in range(UNKNOWNS):
                    correction += run.inverse[3 * j + k, i] * run.residual[i]
                run.change[j, k] -= correction
                norm = max(norm, abs(correction) * unit(scene, k) / scale)
        if not norm < 1e3 or norm > 2.0 * before:
            return False
        if norm <= NEWTON_SHARE * tolerance:
            if iteration > 0 and norm > GOOD_CONTRACTION * before:
                run.jacobian_step = 0.0
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
            error += run.filter[k, i] * defect
        worst = max(worst, abs(error) * unit(scene, k) / scale)
    return worst


@kernel
def settle(scene: Scene, run: Run, piece: Pieces, memory: Memory, entries: Entries) -> None:
    """Rates at the start of a piece, consistent with the loads that they make."""
    for _ in range(20):
        vehicle_rates(
            scene, run.pose, run.velocity, run.rate, piece.left[0], piece.right[0], memory, entries, run.force_rate
        )
        run.evaluations += 1
        change = 0.0
        for k in range(3):
            change = max(change, abs(run.force_rate[k] - run.rate[k]) * unit(scene, k))
            run.rate[k] = run.force_rate[k]
        if change < SETTLED * scene.model.gravity:
            return


@kernel
def begin(scene: Scene, run: Run, piece: Pieces, memory: Memory, entries: Entries) -> None:
    """Begin a piece: a track that starts from rest lays down shoes that know nothing of those before."""
    for track in range(2):
        speeds = piece.left if track == 0 else piece.right
        if abs(speeds[0]) < 1e-6 * abs(speeds[1]):
            memory[track].fresh = True
    settle(scene, run, piece, memory, entries)
    run.begun = True


@kernel
def accept(scene: Scene, run: Run, h: float, speeds: Speeds, memory: Memory, entries: Entries, step: Steps) -> None:
    """Move the state to the end of the step and write it down."""
    step.time, step.length = run.time, h
    step.left[0], step.left[1] = speeds.left_start, speeds.left_end
    step.right[0], step.right[1] = speeds.right_start, speeds.right_end
    set_poses(run, h)
    if scene.remember:
        lay_down(scene, run, h, speeds, memory, entries)
    set_travel(run, h, speeds, memory, 1.0)
    for k in range(3):
        for i in range(STAGES + 1):
            step.pose[i, k] = run.poses[i, k]
            step.velocity[i, k] = run.last[i, k] = run.velocities[i, k]
        rate = 0.0
        for j in range(STAGES):
            rate += DERIVATIVE[STAGES - 1, j] * run.change[j, k]
        run.rate[k] = rate / h
        run.pose[k], run.velocity[k] = run.poses[STAGES, k], run.velocities[STAGES, k]
    for track in range(2):
        run.travel[track] = memory[track].travel
        if scene.remember:
            forget(memory[track], entries[track], 0.5 * scene.model.length)
        memory[track].fresh = False
    run.time += h
    run.last_step = h


@kernel
def limit_at(scene: Scene, run: Run) -> int:
    """The limit of the model that the state exceeds, or `DONE`."""
    v_x, v_y, r = run.velocity[0], run.velocity[1], run.velocity[2]
    weighing = track_loads(scene, run.pose[2], run.rate[0] - r * v_y, run.rate[1] + r * v_x)
    if min(weighing.left, weighing.right) <= 0.0:
        return LIFTED
    if abs(weighing.pressure_centre) >= 0.5 * scene.model.length:
        return PITCHED
    return DONE


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
    reused = jacobian_is_kept(run, h)
    predict(run, h)
    solved = newton(scene, run, h, speeds, memory, entries, scale, tolerance)
    if not solved and reused:
        run.jacobian_step = 0.0
        predict(run, h)
        solved = newton(scene, run, h, speeds, memory, entries, scale, tolerance)
    return error_of(scene, run, h, scale) / tolerance if solved else math.inf


@kernel
def next_length(h: float, error: float) -> float:
    """Length of the next step, or of the next try."""
    if math.isinf(error) or math.isnan(error):
        return 0.25 * h
    factor = SAFETY * max(error, 1e-12) ** -0.25
    factor = min(max(factor, MOST_SHRINKING), MOST_GROWTH)
    return h if 1.0 <= factor <= LEAST_GROWTH else factor * h


@kernel
def advance_piece(
    scene: Scene,
    run: Run,
    piece: Pieces,
    settings: Settings,
    memory: Memory,
    entries: Entries,
    steps: Steps,
    count: int,
) -> tuple[int, int]:
    """Integrate to the end of a piece of track speeds; how that ends, and the number of steps stored."""
    if not run.begun:
        begin(scene, run, piece, memory, entries)
    duration = piece.end - piece.start
    while run.time < piece.end:
        if count == steps.size:
            return STORE_FULL, count
        if max(memory[0].count, memory[1].count) + 1 >= entries.shape[1]:
            return RING_FULL, count
        left = piece.end - run.time
        h = min(run.step, settings.longest_step)
        if h >= left * (1.0 - 1e-9):
            h = left
        elif h > 0.5 * left:
            h = 0.5 * left
        a = (run.time - piece.start) / duration
        b = (run.time + h - piece.start) / duration
        speeds = Speeds(
            piece.left[0] + a * (piece.left[1] - piece.left[0]),
            piece.left[0] + b * (piece.left[1] - piece.left[0]),
            piece.right[0] + a * (piece.right[1] - piece.right[0]),
            piece.right[0] + b * (piece.right[1] - piece.right[0]),
        )
        side_left, side_right = speeds.left_start + speeds.left_end, speeds.right_start + speeds.right_end
        if scene.remember:
            if side_left != 0.0:
                push(memory[0], entries[0], math.copysign(1.0, side_left))
            if side_right != 0.0:
                push(memory[1], entries[1], math.copysign(1.0, side_right))
        error = try_step(scene, run, h, speeds, memory, entries, settings.tolerance)
        if error <= 1.0:
            at_end = h == left
            accept(scene, run, h, speeds, memory, entries, steps[count])
            if at_end:
                run.time = piece.end
            count += 1
            limit = limit_at(scene, run)
            if limit != DONE:
                return limit, count
            if abs(run.pose[2] - steps[0].pose[0, 2]) >= settings.most_turn:
                return TURNED, count
            run.step = max(next_length(h, error), run.step) if at_end else next_length(h, error)
        else:
            run.rejected += 1
            memory[0].travel, memory[1].travel = run.travel[0], run.travel[1]
            if scene.remember:
                if side_left != 0.0:
                    withdraw(memory[0], math.copysign(1.0, side_left))
                if side_right != 0.0:
                    withdraw(memory[1], math.copysign(1.0, side_right))
            run.step = next_length(h, error)
            if run.step < SMALLEST_STEP:
                return STUCK, count
    return DONE, count


@kernel
def advance(
    scene: Scene,
    run_memory: NDArray[np.void],
    pieces: Pieces,
    settings: Settings,
    memory: Memory,
    entries: Entries,
    steps: Steps,
    count: int,
) -> tuple[int, int]:
    """Integrate through pieces of track speeds, from where the run stands; see `advance_piece`."""
    run = run_memory[0]
    while run.piece < pieces.size:
        status, count = advance_piece(scene, run, pieces[run.piece], settings, memory, entries, steps, count)
        if status != DONE:
            return status, count
        run.piece += 1
        run.begun = False
    return DONE, count
