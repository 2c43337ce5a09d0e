"""Simulated motion of a vehicle under its track speeds."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import compile_for, kernel
from trackctl.mechanics.parameters import TrackModel
from trackctl.mechanics.slip import slip
from trackctl.simulation import integrator
from trackctl.simulation.collocation import NODES, TO_CUBIC
from trackctl.simulation.contact_memory import ENTRY, MEMORY
from trackctl.simulation.graded_quadrature import FEW_NODES, graded_rule
from trackctl.simulation.integrator import advance
from trackctl.simulation.run_state import RUN, STEP, Pieces, Settings, Steps
from trackctl.simulation.slopes import Slopes
from trackctl.simulation.track_speeds import TrackSpeeds, speed_pieces
from trackctl.simulation.vehicle_rates import Scene, track_loads

Array = NDArray[np.float64]

FIRST_STEP = 1e-4
FIRST_STORE, FIRST_RING = 1024, 1024
#: Pieces that a steady motion before the start is remembered in.
STEADY_PIECES = 32


class End(IntEnum):
    """How a simulation ends."""

    DONE = integrator.DONE
    TURNED = integrator.TURNED
    LIFTED = integrator.LIFTED
    PITCHED = integrator.PITCHED
    STUCK = integrator.STUCK


@dataclass(frozen=True, slots=True)
class State:
    """Where a vehicle is and how it moves: pose of the mass centre, velocities in the body frame."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0
    forward_velocity: float = 0.0
    lateral_velocity: float = 0.0
    yaw_rate: float = 0.0

    @property
    def pose(self) -> tuple[float, float, float]:
        """x, y [m] and yaw. [rad]"""
        return self.x, self.y, self.yaw

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Forward, lateral [m/s] and yaw rate. [rad/s]"""
        return self.forward_velocity, self.lateral_velocity, self.yaw_rate

    @property
    def is_rest(self) -> bool:
        """Whether nothing moves."""
        return self.velocity == (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Samples of a motion, arrays of shape (n,).

    Attributes
    ----------
    time
        [s]
    x, y, yaw
        Of the mass centre and of the body, in the slope plane. [m], [rad]
    forward_velocity, lateral_velocity, yaw_rate
        In the body frame. [m/s], [rad/s]
    track_speed_left, track_speed_right
        [m/s]
    slip_left, slip_right
        Positive driving, negative braking. [-]
    load_left, load_right
        On the tracks, from the accelerations. [N]
    """

    time: Array
    x: Array
    y: Array
    yaw: Array
    forward_velocity: Array
    lateral_velocity: Array
    yaw_rate: Array
    track_speed_left: Array
    track_speed_right: Array
    slip_left: Array
    slip_right: Array
    load_left: Array
    load_right: Array


@dataclass(slots=True, eq=False)
class Integration:
    """A simulation in progress: the integrator's memory, which grows as it has to.

    Attributes
    ----------
    scene
        Vehicle on the slope.
    run, memory, entries
        State of the integrator and of the contact, see `integrator` and `contact_memory`.
    steps, count
        Accepted steps, the first `count` of `steps`.
    """

    scene: Scene
    run: NDArray[np.void]
    memory: NDArray[np.void]
    entries: NDArray[np.void]
    steps: Steps = field(default_factory=lambda: np.zeros(FIRST_STORE, STEP))
    count: int = 0

    def advance(self, pieces: Pieces, settings: Settings) -> End:
        """Go on through pieces of track speeds."""
        self.run["piece"], self.run["begun"] = 0, False
        while True:
            status, self.count = advance(
                self.scene, self.run, pieces, settings, self.memory, self.entries, self.steps, self.count
            )
            if status == integrator.STORE_FULL:
                self.steps = np.concatenate((self.steps, np.zeros_like(self.steps)))
            elif status == integrator.RING_FULL:
                self.entries = grown(self.memory, self.entries)
            else:
                return End(status)

    @property
    def time(self) -> float:
        """Reached so far. [s]"""
        return float(self.run["time"][0])

    @property
    def pose(self) -> Array:
        """x, y [m] and yaw [rad] reached so far."""
        return np.asarray(self.run["pose"][0])


def grown(memory: NDArray[np.void], entries: NDArray[np.void]) -> NDArray[np.void]:
    """Rings of twice the size with the same pieces, which start at place 0."""
    larger = np.zeros((2, 2 * entries.shape[1]), ENTRY)
    for track in range(2):
        order = np.arange(memory["count"][track])
        larger[track, order] = entries[track, (memory["first"][track] + order) % entries.shape[1]]
    memory["first"] = 0
    return larger


def integration(scene: Scene, start: State, time: float, speeds: tuple[float, float] | None) -> Integration:
    """A simulation that is to begin.

    Parameters
    ----------
    scene
        Vehicle on the slope.
    start
        State at the start.
    time
        Of the start. [s]
    speeds
        Track speeds of the steady motion that has led to the start, None if the vehicle has just been put down. [m/s]
    """
    run, memory, entries = np.zeros(1, RUN), np.zeros(2, MEMORY), np.zeros((2, FIRST_RING), ENTRY)
    run["time"], run["pose"], run["velocity"], run["step"] = time, start.pose, start.velocity, FIRST_STEP
    run["to_come"] = 1.0
    for track in range(2):
        if speeds is None or speeds[track] == 0.0:
            pieces = put_down(scene, start, track)
            memory["fresh"][track] = True
        else:
            pieces = steady(scene, start, track, speeds[track])
        entries[track, : pieces.size] = pieces
        memory["count"][track] = pieces.size
    return Integration(scene, run, memory, entries)


def put_down(scene: Scene, start: State, track: int) -> NDArray[np.void]:
    """Memory of a track whose shoes all lie where they have entered, shape (1,)."""
    half = 0.5 * scene.model.length
    piece = np.zeros(1, ENTRY)
    piece["lower"] = piece["label"] = -half
    piece["upper"], piece["rate"] = half, 2.0 * half
    piece["span"] = 2.0 * half
    piece["rough_below"] = piece["rough_above"] = True
    rear, front = (end_of(scene, track, end, *start.pose) for end in (-half, half))
    piece["x"][0, :2] = rear[0], front[0] - rear[0]
    piece["y"][0, :2] = rear[1], front[1] - rear[1]
    piece["forward_x"][0, 0], piece["forward_y"][0, 0] = math.cos(start.yaw), math.sin(start.yaw)
    return piece


def steady(scene: Scene, start: State, track: int, speed: float) -> NDArray[np.void]:
    """Memory of a track after a steady motion, shape (STEADY_PIECES,), in ascending label."""
    half = math.copysign(0.5 * scene.model.length, speed)
    step = scene.model.length / abs(speed) / STEADY_PIECES
    pieces = np.zeros(STEADY_PIECES, ENTRY)
    first = step * (np.arange(STEADY_PIECES) - STEADY_PIECES)
    pieces["label"], pieces["rate"] = half + speed * first, speed * step
    pieces["span"] = scene.model.length
    pieces["lower"] = np.minimum(pieces["label"], pieces["label"] + pieces["rate"])
    pieces["upper"] = np.maximum(pieces["label"], pieces["label"] + pieces["rate"])
    time = first[:, None] + step * np.concatenate(([0.0], NODES))
    yaw = start.yaw + start.yaw_rate * time
    # The chord of the way turned on, which stays finite for a yaw rate of zero.
    chord = time * np.sinc(0.5 * start.yaw_rate * time / np.pi)
    middle = start.yaw + 0.5 * start.yaw_rate * time
    v_x, v_y = start.forward_velocity, start.lateral_velocity
    x = start.x + chord * (v_x * np.cos(middle) - v_y * np.sin(middle))
    y = start.y + chord * (v_x * np.sin(middle) + v_y * np.cos(middle))
    ends = end_of(scene, track, half, x, y, yaw)
    for name, values in zip(("x", "y", "forward_x", "forward_y"), (*ends, np.cos(yaw), np.sin(yaw)), strict=True):
        pieces[name] = values @ TO_CUBIC.T
    return pieces if speed > 0.0 else pieces[::-1]


def end_of(scene: Scene, track: int, end: float, x: Any, y: Any, yaw: Any) -> tuple[Any, Any]:
    """World position of the end of a track's contact."""
    ahead, arm = end - scene.model.cog_forward, (0.5 - track) * scene.model.gauge - scene.model.cog_left
    return x + ahead * np.cos(yaw) - arm * np.sin(yaw), y + ahead * np.sin(yaw) + arm * np.cos(yaw)


def simulate(
    scene: Scene,
    speeds: TrackSpeeds,
    start: State,
    tolerance: float,
    *,
    steady_start: bool = False,
    most_turn: float = math.inf,
) -> tuple[Integration, End]:
    """Simulate a vehicle under given track speeds, until they end or it has turned far enough.

    Parameters
    ----------
    scene
        Vehicle on the slope.
    speeds
        Of the tracks over time.
    start
        State at the first time.
    tolerance
        Relative error of the velocities in a step.
    steady_start
        Whether the state at the start has lasted; else the vehicle has just been put down.
    most_turn
        Turn at which to stop. [rad]
    """
    pieces = speed_pieces(speeds)
    before = (float(speeds.left[0]), float(speeds.right[0])) if steady_start else None
    simulation = integration(scene, start, float(speeds.time[0]), before)
    return simulation, simulation.advance(pieces, Settings(tolerance, math.inf, most_turn))


def turn_time(simulation: Integration, turn: float) -> float:
    """Time at which the yaw has first changed by `turn` [rad] either way; NaN if it has not."""
    steps = simulation.steps[: simulation.count]
    turned = np.abs(steps["pose"][:, -1, 2] - steps["pose"][0, 0, 2])
    reached = np.flatnonzero(turned >= turn * (1.0 - 1e-12))
    if reached.size == 0:
        return math.nan
    step = steps[reached[0]]
    low, high = 0.0, 1.0
    coefficients = TO_CUBIC @ (step["pose"][:, 2] - steps["pose"][0, 0, 2])
    while high - low > 1e-12:
        theta = 0.5 * (low + high)
        low, high = (theta, high) if abs(np.polyval(coefficients[::-1], theta)) < turn else (low, theta)
    return float(step["time"] + high * step["length"])


def sample(simulation: Integration, mass: float, time: Array, ground: Slopes | None = None) -> Motion:
    """The motion at some times, which lie within what has been simulated, on the scene's plane or on given ground."""
    scene, steps = simulation.scene, simulation.steps[: simulation.count]
    which = np.clip(np.searchsorted(steps["time"], time, side="right") - 1, 0, None)
    step = steps[which]
    theta = (time - step["time"]) / step["length"]
    powers = theta[:, None] ** np.arange(4)
    slopes = np.arange(4) * theta[:, None] ** np.maximum(np.arange(4) - 1, 0) / step["length"][:, None]
    pose = np.ascontiguousarray(np.einsum("ni,ij,njk->kn", powers, TO_CUBIC, step["pose"]))
    velocity = np.einsum("ni,ij,njk->kn", powers, TO_CUBIC, step["velocity"])
    rate = np.einsum("ni,ij,njk->kn", slopes, TO_CUBIC, step["velocity"])
    left, right = (step[side][:, 0] + theta * (step[side][:, 1] - step[side][:, 0]) for side in ("left", "right"))
    arms = [side * scene.model.gauge - scene.model.cog_left for side in (0.5, -0.5)]
    load = np.empty((2, time.size))
    ahead, across = rate[0] - velocity[2] * velocity[1], rate[1] + velocity[2] * velocity[0]
    if ground is None:
        loads_along(scene, pose[2], ahead, across, load)
    else:
        for i, at in enumerate(time.tolist()):
            one, each = slice(i, i + 1), np.empty((2, 1))
            loads_along(ground.scene_at(scene, at), pose[2, one], ahead[one], across[one], each)
            load[:, one] = each
    load *= mass * scene.model.gravity
    return Motion(
        time,
        pose[0],
        pose[1],
        pose[2],
        velocity[0],
        velocity[1],
        velocity[2],
        left,
        right,
        slip(left, velocity[0] - velocity[2] * arms[0]),
        slip(right, velocity[0] - velocity[2] * arms[1]),
        load[0],
        load[1],
    )


@kernel
def loads_along(scene: Scene, yaw: Array, forward_acceleration: Array, left_acceleration: Array, result: Array) -> None:
    """Loads of the left and right track over the weight, shape (2, n)."""
    for i in range(yaw.size):
        weighing = track_loads(scene, yaw[i], forward_acceleration[i], left_acceleration[i])
        result[0, i], result[1, i] = weighing.left, weighing.right


def compile_simulation(model: TrackModel) -> None:
    """Compile what a simulation takes, but for the forces on the tracks, or load it."""
    motionless = Scene(model, 1.0, 0.0, 0.0, graded_rule(), graded_rule(FEW_NODES), True, 0)
    run, memory, entries = np.zeros(1, RUN), np.zeros(2, MEMORY), np.zeros((2, FIRST_RING), ENTRY)
    speed = np.array([0.0, 1.0])
    pieces, settings = speed_pieces(TrackSpeeds(speed, speed, speed)), Settings(1.0, math.inf, math.inf)
    compile_for(advance, motionless, run, pieces, settings, memory, entries, np.zeros(1, STEP), 0)
    compile_for(loads_along, motionless, speed, speed, speed, np.empty((2, 2)))
