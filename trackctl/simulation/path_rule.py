"""Track speeds that make the mass centre follow a path: the path rule, and the readings that it is compared with.

A table of steady turns makes the heading turn at v kappa. On a slope the sideslip changes with the heading, so that the
path turns at v kappa + d beta / dt, and commands read at the path's own curvature drift. The path rule solves the same
equilibrium with the motion prescribed: yaw rate v (kappa - d beta / ds), with the accelerations of the path and the
inertia of the yaw motion in the balance.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from trackctl.compiled import compile_for, kernel
from trackctl.lut.point import solve_points
from trackctl.lut.table import Status
from trackctl.mechanics.limits import FASTEST_TRACK, LARGEST_SIDESLIP, SLOWEST_TRACK
from trackctl.mechanics.parameters import TrackModel
from trackctl.mechanics.prescribed_motion import PrescribedMotion, prescribed_balance
from trackctl.mechanics.quadrature import Rule, rules
from trackctl.mechanics.slip import body_speed, slip
from trackctl.simulation.path import Path, hermite
from trackctl.simulation.vehicle_rates import Scene
from trackctl.solvers import levenberg_marquardt as lm
from trackctl.solvers.workspace import workspace

Array = NDArray[np.float64]

TOLERANCE = 1e-10
EVALUATIONS = 60
#: Of a start, over the speed: a shoe that does not slide at all has no direction of shear, nor a derivative.
LEAST_SLIDING = 1e-8
#: Sample spacing and width of the Gaussian of the derivative along the path, over the contact length.
SPACING, SMOOTHING = 1.0 / 24.0, 0.12
#: Steps at least, even, so that a way begins, peaks and ends at samples.
LEAST_STEPS = 12
#: Samples are no farther apart than this. [m]
LONGEST_STEP = 0.1
#: How far a path is extended at its ends, over the contact length.
EXTENSION = 3.0
#: Passes with the derivative of the sideslip, after one without.
PASSES = 2

LOWER: Array = np.array([SLOWEST_TRACK, SLOWEST_TRACK, -LARGEST_SIDESLIP])
UPPER: Array = np.array([FASTEST_TRACK, FASTEST_TRACK, LARGEST_SIDESLIP])


#: Reads a table of steady turns: speed [m/s], curvature [1/m] and heading from up-slope [rad], arrays of shape (n,), to
#: left and right track speed over speed [-] and sideslip [rad], shape (3, n), NaN where there is no answer.
Reading = Callable[[Array, Array, Array], Array]


@dataclass(frozen=True, slots=True, eq=False)
class PathCommands:
    """Track speeds over time along a path, arrays of shape (n,).

    Attributes
    ----------
    path
        What is to be followed.
    time
        From the start. [s]
    track_speed_left, track_speed_right
        [m/s]
    sideslip
        From the body's x axis to the tangent; the yaw is tangent - sideslip. [rad]
    yaw_rate
        [rad/s]
    slip_left, slip_right
        Of the tracks. [-]
    residual
        Largest residual of the balance, in weights and weights times contact length; 0 where none was solved. [-]
    traction_left, traction_right
        Forward force of the ground on the tracks, in weights; NaN where no balance was solved. [-]
    """

    path: Path
    time: Array
    track_speed_left: Array
    track_speed_right: Array
    sideslip: Array
    yaw_rate: Array
    slip_left: Array
    slip_right: Array
    residual: Array
    traction_left: Array
    traction_right: Array


class Balance(NamedTuple):
    """What was left and what it took where the balance was solved.

    Attributes
    ----------
    traction
        Forward force of the ground on left and right track, in weights, shape (n, 2). [-]
    residual
        The largest, in weights and weights times contact length, shape (n,). [-]
    """

    traction: Array
    residual: Array


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """Slope along a path, arrays of shape (n,), linear between samples.

    Attributes
    ----------
    arc_length
        Ascending. [m]
    slope
        Angle of the ground's plane under the vehicle. [rad]
    uphill_yaw
        Direction of up-slope, in the frame of the path's tangent, without jumps. [rad]
    """

    arc_length: Array
    slope: Array
    uphill_yaw: Array

    def at(self, arc_length: Array) -> tuple[Array, Array]:
        """Slope and direction of up-slope at arc lengths; beyond the ends as there."""
        return (
            np.interp(arc_length, self.arc_length, self.slope),
            np.interp(arc_length, self.arc_length, self.uphill_yaw),
        )


@kernel
def solve_along(
    model: TrackModel,
    motions: Array,
    rule: Rule,
    memory: NDArray[np.void],
    unknowns: Array,
    traction: Array,
    residual: Array,
) -> None:
    """Solve the prescribed balance at each sample.

    Parameters
    ----------
    model
        Vehicle on its terrain.
    motions
        Fields of the `PrescribedMotion` of each sample, shape (n, 5).
    rule
        Quadrature along the tracks.
    memory
        A `workspace(3)`, shape (1,).
    unknowns
        Left and right track speed over speed [-] and sideslip [rad], shape (n, 3): starts, replaced by the answers. A
        sample whose start is NaN starts where the one before has ended.
    traction
        Receives the forward force of the ground on left and right track, in weights, shape (n, 2).
    residual
        Receives the largest residual of each sample, shape (n,).
    """
    work = memory[0]
    x = np.empty(3)
    for i in range(motions.shape[0]):
        m = motions[i]
        motion = PrescribedMotion(m[0], m[1], m[2], m[3], m[4])
        start = i - 1 if math.isnan(unknowns[i, 0]) else i
        for k in range(3):
            x[k] = work.trial[k] = unknowns[start, k] + (LEAST_SLIDING if k < 2 else 0.0)
            work.residual[k] = math.inf
        damping = 0.0
        for _ in range(EVALUATIONS):
            # What solves is a trial that was taken, so that its tractions are those of the answer.
            prescribed_balance(model, motion, rule, work.trial, work.trial_residual, work.trial_jacobian, traction[i])
            damping = lm.judge(x, damping, work)
            while not lm.propose(x, damping, LOWER, UPPER, work) and damping < lm.LARGEST_DAMPING:
                damping = lm.more_damping(damping)
            if lm.is_solved(work, TOLERANCE) or damping >= lm.LARGEST_DAMPING:
                break
        residual[i] = lm.largest(work.residual)
        for k in range(3):
            unknowns[i, k] = x[k]


def resampled(path: Path, length: float) -> tuple[Path, slice]:
    """The path at even steps of a small share of the contact length, extended at both ends; and where it is in that."""
    count = max(math.ceil(path.length / min(SPACING * length, LONGEST_STEP)), LEAST_STEPS) + 1
    step = path.length / (count - 1)
    added = math.ceil(EXTENSION * length / step)
    beyond = step * np.arange(1.0, added + 1.0)
    s: Array = np.concatenate((-beyond[::-1], np.linspace(0.0, path.length, count), path.length + beyond))
    inside = np.clip(s, 0.0, path.length)
    curvature = np.interp(s, path.arc_length, path.curvature)
    x, y, tangent = (
        hermite(path.arc_length, values, slopes, inside)
        for values, slopes in (
            (path.x, np.cos(path.tangent)),
            (path.y, np.sin(path.tangent)),
            (path.tangent, path.curvature),
        )
    )
    # Linear in the square: constant acceleration between samples.
    speed: Array = np.sqrt(np.interp(s, path.arc_length, path.speed**2))
    return Path(s, x, y, tangent + curvature * (s - inside), curvature, speed), slice(added, -added)


def along(values: Array, step: float, length: float) -> Array:
    """Derivative along the path of the Gaussian-smoothed values."""
    return np.asarray(gaussian_filter1d(values, SMOOTHING * length / step, order=1, mode="nearest") / step)


def spacing(path: Path) -> float:
    """Distance of the samples of a path that `resampled` has made. [m]"""
    return float(path.arc_length[1] - path.arc_length[0])


def no_slip_ratios(model: TrackModel, curvature: Array) -> Array:
    """Track speeds over speed without slip, and no sideslip, shape (3, n)."""
    left, right = (1.0 - curvature * (side * model.gauge - model.cog_left) for side in (0.5, -0.5))
    return np.stack((left, right, np.zeros_like(curvature)))


def first_start(scene: Scene, path: Path, slope: float, uphill_yaw: float) -> Array:
    """Where to start solving a path's first sample: the steady turn there, or else no slip, shape (3,)."""
    heading = path.tangent[0] - uphill_yaw
    cell = solve_points(scene.model, np.array([[slope, path.speed[0], path.curvature[0], heading]]))[0]
    if cell["status"] == Status.CONVERGED:
        return np.asarray(cell["unknowns"], np.float64)
    return no_slip_ratios(scene.model, path.curvature[:1])[:, 0]


def path_commands(scene: Scene, path: Path, ground: Ground | None = None) -> PathCommands:
    """Commands of the path rule, from the equilibrium with the motion prescribed.

    Three passes, the first of which takes the yaw to follow the path's curvature; see the module. Every residual is to
    be checked: one unsolved sample wrecks a path.

    Parameters
    ----------
    scene
        Vehicle on the slope.
    path
        What the mass centre is to follow, with a continuous tangent. A jump of curvature asks for a jump of sideslip,
        which no vehicle can do: blend it.
    ground
        Slope along the path, None for the scene's plane.
    """
    model = scene.model
    fine, inner = resampled(path, model.length)
    step = spacing(fine)
    motions, unknowns, balance = steady_turns(scene, fine, ground)
    motions[:, 0] -= 0.5 * np.gradient(fine.speed**2, step) / model.gravity
    gradient = fine.curvature
    for turn in range(PASSES + 1):
        if turn > 0:
            gradient = fine.curvature - along(unknowns[:, 2], step, model.length)
            turning = fine.speed * along(fine.speed * gradient, step, model.length)
            motions[:, 3] = gradient
            motions[:, 4] = scene.gyration_square * turning / (model.gravity * model.length)
        solve_along(model, motions, rules(), np.zeros(1, workspace(3)), unknowns, *balance)
    return commands_of(scene, fine, inner, unknowns.T, gradient, balance)


def compile_path_rule(model: TrackModel) -> None:
    """Compile what solves a path's track speeds, or load it."""
    motions, unknowns = np.zeros((1, len(PrescribedMotion._fields))), np.zeros((1, 3))
    balance = Balance(np.empty((1, 2)), np.empty(1))
    compile_for(solve_along, model, motions, rules(), np.zeros(1, workspace(3)), unknowns, *balance)


def naive_commands(scene: Scene, path: Path) -> PathCommands:
    """Commands of steady turns of the path's own curvature, as a table has them: on a slope they drift."""
    fine, inner = resampled(path, scene.model.length)
    motions, unknowns, balance = steady_turns(scene, fine, None)
    solve_along(scene.model, motions, rules(), np.zeros(1, workspace(3)), unknowns, *balance)
    return commands_of(scene, fine, inner, unknowns.T, fine.curvature, balance)


def steady_turns(scene: Scene, path: Path, ground: Ground | None) -> tuple[Array, Array, Balance]:
    """`PrescribedMotion` of steady turns of a path's curvature, and unknowns and balance to be solved for."""
    size = path.speed.size
    if ground is None:
        ground = Ground(path.arc_length[:1], np.array([scene.slope]), np.array([scene.uphill_yaw]))
    slope, uphill_yaw = ground.at(path.arc_length)
    heading, down = path.tangent - uphill_yaw, np.sin(slope)
    motions = np.zeros((size, len(PrescribedMotion._fields)))
    motions[:, 0] = -down * np.cos(heading)
    motions[:, 1] = down * np.sin(heading) - path.speed**2 * path.curvature / scene.model.gravity
    motions[:, 2] = np.cos(slope)
    motions[:, 3] = path.curvature
    unknowns = np.full((size, 3), np.nan)
    unknowns[0] = first_start(scene, path, float(slope[0]), float(uphill_yaw[0]))
    return motions, unknowns, Balance(np.empty((size, 2)), np.empty(size))


def read_path_commands(scene: Scene, path: Path, read: Reading) -> PathCommands:
    """Commands of the path rule from a table of steady turns, read at the yaw rate that the path asks for.

    What a table does not know is left out: the difference between the path's acceleration and that of a steady turn,
    and the inertia of the yaw motion.
    """
    fine, inner = resampled(path, scene.model.length)
    ratios, gradient = np.zeros((3, fine.speed.size)), fine.curvature
    for turn in range(PASSES + 1):
        if turn > 0:
            gradient = fine.curvature - along(ratios[2], spacing(fine), scene.model.length)
        ratios = read(fine.speed, gradient, fine.tangent - ratios[2] - scene.uphill_yaw)
    return commands_of(scene, fine, inner, ratios, gradient, unread(ratios))


def read_naive_commands(scene: Scene, path: Path, read: Reading) -> PathCommands:
    """Commands of a table of steady turns read at the path's own curvature; see `naive_commands`."""
    fine, inner = resampled(path, scene.model.length)
    ratios = np.zeros((3, fine.speed.size))
    for _ in range(PASSES + 1):
        ratios = read(fine.speed, fine.curvature, fine.tangent - ratios[2] - scene.uphill_yaw)
    return commands_of(scene, fine, inner, ratios, fine.curvature, unread(ratios))


def no_slip_commands(scene: Scene, path: Path) -> PathCommands:
    """Commands that would follow the path without slip, for comparison."""
    fine, inner = resampled(path, scene.model.length)
    ratios = no_slip_ratios(scene.model, fine.curvature)
    return commands_of(scene, fine, inner, ratios, fine.curvature, unread(ratios))


def unread(ratios: Array) -> Balance:
    """In place of a balance: residuals of 0 where there is an answer, else infinity."""
    return Balance(np.full((ratios.shape[1], 2), np.nan), np.where(np.isnan(ratios).any(axis=0), math.inf, 0.0))


def commands_of(
    scene: Scene, fine: Path, inner: slice, ratios: Array, gradient: Array, balance: Balance
) -> PathCommands:
    """Commands along the inner part of a path, from track speed ratios and sideslip, shape (3, n)."""
    s, x, y, tangent, curvature, speed = (
        values[inner] for values in (fine.arc_length, fine.x, fine.y, fine.tangent, fine.curvature, fine.speed)
    )
    left, right, sideslip = ratios[:, inner]
    gradient = gradient[inner]
    bodies = [
        body_speed(1.0, gradient, sideslip, side * scene.model.gauge - scene.model.cog_left) for side in (0.5, -0.5)
    ]
    return PathCommands(
        Path(s, x, y, tangent, curvature, speed),
        np.concatenate(([0.0], np.cumsum(2.0 * np.diff(s) / (speed[1:] + speed[:-1])))),
        left * speed,
        right * speed,
        sideslip,
        gradient * speed,
        slip(left, bodies[0]),
        slip(right, bodies[1]),
        balance.residual[inner],
        *balance.traction[inner].T,
    )
