"""One step of the motion as a system of equations, with the memory of the contact as part of it.

The unknowns are the changes of the body's velocities at the nodes of `collocation`; positions follow by integration.
The shear displacement of shoes that enter the ground during a step depends on the step itself: their points of entry
are those of the trial motion (a collocation method for delay equations, as in RADAR5 [1]_).

References
----------
.. [1] Guglielmi, Hairer, Implementing Radau IIA methods for stiff delay differential equations, 2001.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.simulation.collocation import DERIVATIVE, INTEGRAL, NODES, STAGES, TO_CUBIC
from trackctl.simulation.contact_memory import Entries, Memory, forget, newest, slot
from trackctl.simulation.run_state import Run, Speeds, Steps
from trackctl.simulation.vehicle_rates import Scene, vehicle_rates

Array = NDArray[np.float64]

#: What displacement may err by where memory is integrated as if it were smooth, over the shear modulus.
ROUGHNESS = 3e-5
#: Most that smoothness is taken to reach beyond a step, over its length.
MOST_SMOOTHNESS = 8.0


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


@inlined
def set_travel(run: Run, h: float, speeds: Speeds, memory: Memory, theta: float) -> None:
    """Way travelled by the tracks at theta."""
    left = theta * speeds.left_start + 0.5 * theta * theta * (speeds.left_end - speeds.left_start)
    right = theta * speeds.right_start + 0.5 * theta * theta * (speeds.right_end - speeds.right_start)
    memory[0].travel = run.travel[0] + h * left
    memory[1].travel = run.travel[1] + h * right


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
        entry.span = 0.5 * abs(start + end) * max(h, run.smooth)
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


@inlined
def smooth_time(scene: Scene, run: Run, h: float) -> float:
    """Length of a step whose positions would err by `ROUGHNESS`: how quickly the motion changes. [s]

    They err by the fifth power of the length.
    """
    error = max(run.error * h, 1e-300)
    return float(h * min(max((ROUGHNESS * scene.model.shear_modulus / error) ** 0.2, 1.0), MOST_SMOOTHNESS))


@kernel
def accept(scene: Scene, run: Run, h: float, speeds: Speeds, memory: Memory, entries: Entries, step: Steps) -> None:
    """Move the state to the end of the step and write it down."""
    run.smooth = smooth_time(scene, run, h)
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
    run.last_step, run.left_speed, run.right_speed = h, speeds.left_end, speeds.right_end
