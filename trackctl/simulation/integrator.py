"""Error-controlled implicit integration of a vehicle's motion, with the memory of its contact as part of the state."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.simulation.collocation_step import accept
from trackctl.simulation.contact_memory import Entries, Memory, push, withdraw
from trackctl.simulation.newton import try_step, unit
from trackctl.simulation.run_state import Pieces, Run, Settings, Speeds, Steps
from trackctl.simulation.vehicle_rates import Scene, track_loads, vehicle_rates

#: How `advance` ends.
DONE, STORE_FULL, RING_FULL, TURNED, LIFTED, PITCHED, STUCK = range(7)

SMALLEST_STEP = 1e-9
SAFETY, MOST_GROWTH, MOST_SHRINKING = 0.85, 4.0, 0.2
#: A step is not lengthened by less than this, so that the Jacobian can be kept.
LEAST_GROWTH = 1.2
#: Errors over the tolerance that count as so large, of a step and of the one before it.
LEAST_ERROR, LEAST_LAST_ERROR = 1e-12, 1e-2
#: Relative change of a track speed that is none.
SAME_SPEED = 1e-9
#: Change of the rates at which they are consistent, over gravity.
SETTLED = 1e-7


@kernel
def settle(scene: Scene, run: Run, left: float, right: float, memory: Memory, entries: Entries) -> None:
    """Rates where the run stands, at track speeds [m/s], consistent with the loads that they make."""
    for k in range(3):
        run.poses[0, k], run.velocities[0, k] = run.pose[k], run.velocity[k]
    for _ in range(20):
        vehicle_rates(scene, run.poses[0], run.velocities[0], run.rate, left, right, memory, entries, run.force_rate)
        run.evaluations += 1
        change = 0.0
        for k in range(3):
            change = max(change, abs(run.force_rate[k] - run.rate[k]) * unit(scene, k))
            run.rate[k] = run.force_rate[k]
        if change < SETTLED * scene.model.gravity:
            return


@inlined
def goes_on(before: float, after: float) -> bool:
    """Whether a track speed has not jumped, nor turned round."""
    return bool(abs(after - before) <= SAME_SPEED * max(abs(before), abs(after)) and before * after >= 0.0)


@kernel
def begin(scene: Scene, run: Run, piece: Pieces, memory: Memory, entries: Entries) -> None:
    """Begin a piece: a track that starts from rest lays down shoes that know nothing of those before."""
    for track in range(2):
        speeds = piece.left if track == 0 else piece.right
        if abs(speeds[0]) < 1e-6 * abs(speeds[1]):
            memory[track].fresh = True
    smooth = goes_on(run.left_speed, piece.left[0]) and goes_on(run.right_speed, piece.right[0])
    if run.last_step == 0.0 or not smooth:
        settle(scene, run, piece.left[0], piece.right[0], memory, entries)
    run.begun = True


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
def limit_reached(scene: Scene, run: Run, memory: Memory, entries: Entries) -> int:
    """The limit that a step has exceeded, or `DONE`.

    Where the step is short what Newton's method leaves of its velocities counts for much in the rates: they are looked
    at again before it is said to be at an end.
    """
    if limit_at(scene, run) == DONE:
        return DONE
    settle(scene, run, run.left_speed, run.right_speed, memory, entries)
    return limit_at(scene, run)


@inlined
def next_length(run: Run, h: float, error: float) -> float:
    """Length of the next step, or of the next try.

    After a success also by how the error has changed since the step before (Gustafsson's predictive control).
    """
    if math.isinf(error) or math.isnan(error):
        return 0.25 * h
    factor = SAFETY * max(error, LEAST_ERROR) ** -0.25
    if error <= 1.0 and run.last_step > 0.0:
        trend = h / run.last_step * (run.last_error / max(error, LEAST_ERROR)) ** 0.25
        factor = min(factor, factor * trend)
    factor = min(max(factor, MOST_SHRINKING), MOST_GROWTH)
    return h if 1.0 <= factor <= LEAST_GROWTH else factor * h


@inlined
def speeds_between(piece: Pieces, start: float, end: float) -> Speeds:
    """Track speeds at two times of a piece."""
    a, b = (start - piece.start) / (piece.end - piece.start), (end - piece.start) / (piece.end - piece.start)
    return Speeds(
        piece.left[0] + a * (piece.left[1] - piece.left[0]),
        piece.left[0] + b * (piece.left[1] - piece.left[0]),
        piece.right[0] + a * (piece.right[1] - piece.right[0]),
        piece.right[0] + b * (piece.right[1] - piece.right[0]),
    )


@inlined
def length_to_try(wanted: float, left: float) -> float:
    """Length of a step where so much of the piece is left: the end is met by even steps."""
    if wanted >= left * (1.0 - 1e-9):
        return left
    return 0.5 * left if wanted > 0.5 * left else wanted


@kernel
def make_room(scene: Scene, speeds: Speeds, memory: Memory, entries: Entries) -> None:
    """Room in the memory for the shoes of a step."""
    left, right = speeds.left_start + speeds.left_end, speeds.right_start + speeds.right_end
    if scene.remember and left != 0.0:
        push(memory[0], entries[0], math.copysign(1.0, left))
    if scene.remember and right != 0.0:
        push(memory[1], entries[1], math.copysign(1.0, right))


@kernel
def take_back(scene: Scene, run: Run, speeds: Speeds, memory: Memory) -> None:
    """Undo a step that has failed."""
    left, right = speeds.left_start + speeds.left_end, speeds.right_start + speeds.right_end
    memory[0].travel, memory[1].travel = run.travel[0], run.travel[1]
    if scene.remember and left != 0.0:
        withdraw(memory[0], math.copysign(1.0, left))
    if scene.remember and right != 0.0:
        withdraw(memory[1], math.copysign(1.0, right))


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
    while run.time < piece.end:
        if count == steps.size:
            return STORE_FULL, count
        if max(memory[0].count, memory[1].count) + 1 >= entries.shape[1]:
            return RING_FULL, count
        left = piece.end - run.time
        h = length_to_try(min(run.step, settings.longest_step), left)
        speeds = speeds_between(piece, run.time, run.time + h)
        make_room(scene, speeds, memory, entries)
        error = try_step(scene, run, h, speeds, memory, entries, settings.tolerance)
        following = next_length(run, h, error)
        if error <= 1.0:
            accept(scene, run, h, speeds, memory, entries, steps[count])
            run.last_error = max(error, LEAST_LAST_ERROR)
            # A step that has been cut short says that the next can be as long as it, at least.
            run.step = max(following, run.step) if h == left else following
            if h == left:
                run.time = piece.end
            count += 1
            limit = limit_reached(scene, run, memory, entries)
            if limit != DONE:
                return limit, count
            if abs(run.pose[2] - steps[0].pose[0, 2]) >= settings.most_turn:
                return TURNED, count
        else:
            run.rejected += 1
            take_back(scene, run, speeds, memory)
            run.step = following
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
