"""The balance of one operating point, solved from a start near its root."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import carray, types  # type: ignore[attr-defined]
from numpy.typing import NDArray

from trackctl.compiled import call_by_address, inlined, kernel, procedure
from trackctl.mechanics.equilibrium import balance
from trackctl.mechanics.limits import FASTEST_TRACK, LARGEST_SIDESLIP, SLOWEST_TRACK, outside_box
from trackctl.mechanics.operating_point import OperatingPoint
from trackctl.mechanics.parameters import TrackModel
from trackctl.mechanics.quadrature import rules
from trackctl.solvers import levenberg_marquardt as lm
from trackctl.solvers.continuation import curve
from trackctl.solvers.particle_swarm import swarm
from trackctl.solvers.workspace import workspace

Array = NDArray[np.float64]

#: Largest residual of an accepted cell, in units of m g and m g L.
TOLERANCE = 1e-10
#: Determinant of the balance, over the product of its rows' largest entries, that is too small to be taken from nearby:
#: the step to a root is some 1e-6 long, over which the derivatives change by a share of 1e-4.
NEAR_FOLD = 1e-2


class Effort(NamedTuple):
    """When a solver stops: at a largest residual, or after so many evaluations."""

    tolerance: float
    evaluations: int


#: Slip of a start that knows no better. [-]
SLIP_SCALE = 0.01
#: From a start near the root, and from one that owes nothing to a neighbour.
WARM, COLD = Effort(TOLERANCE, 8), Effort(TOLERANCE, 40)

#: Quadrature of the answers, and of a swarm that only has to find the valley.
FINE, COARSE = rules(), rules((8,))
MODEL_SIZE = len(TrackModel._fields)
POINT_SIZE = len(OperatingPoint._fields)

DOUBLES = types.CPointer(types.float64)
#: What is compiled once and called by address: its memory is that of a solver.
LINEARISE = types.void(types.voidptr, DOUBLES, DOUBLES, DOUBLES)
RESIDUALS = types.void(types.voidptr, DOUBLES, DOUBLES)
IMPROVE = types.int64(types.voidptr, DOUBLES, types.float64, types.int64)
FOLLOW = types.int64(types.voidptr, DOUBLES, DOUBLES)
SEARCH = types.int64(types.voidptr, types.CPointer(types.uint64), DOUBLES)
call_linearise, call_residuals = call_by_address(LINEARISE), call_by_address(RESIDUALS)
call_improve = call_by_address(IMPROVE)


#: A record of the type `SOLVER`: what a thread needs to solve cells.
Solver = Any

PARTICLES = 16
#: Highest order of the differences that a start is predicted from.
MOST_DIFFERENCES = 7
SOLVER = np.dtype(
    [
        ("numbers", np.float64, MODEL_SIZE + POINT_SIZE),  # of the model, then of the operating point; first, so that
        # its address is the record's
        ("coarse", np.bool_),  # whether the balance is the swarm's
        ("lower", np.float64, 3),  # physical box of the unknowns
        ("upper", np.float64, 3),
        ("traction", np.float64, 2),  # track forces of the last evaluation [-]
        ("work", workspace(3)),  # holds the balance of the last solution
        ("flock", swarm(PARTICLES, 3)),
        ("root", np.float64, 3),  # best of a search
        ("least", np.float64),  # least residual that it met
        ("flock_lower", np.float64, 3),  # box of the swarm's coordinates
        ("flock_upper", np.float64, 3),
        ("quadratic", np.float64),  # residual after the last Newton step, over the square of that before it
        ("curve", curve(3)),
        ("way", np.float64, 2 * POINT_SIZE),  # first and last operating point of the curve
        ("difference", np.float64, (MOST_DIFFERENCES + 1, 3)),  # backward differences of the last roots along a row
        # Addresses of what is called by address.
        ("linearise", np.int64),
        ("residuals", np.int64),
        ("improve", np.int64),
        ("follow", np.int64),
        ("search", np.int64),
    ],
    align=True,
)


def cell_solver(model: TrackModel) -> NDArray[np.void]:
    """A thread's solver, shape (1,): track speeds from 0.01 to 6 times the vehicle's, sideslip up to 60 degrees."""
    memory = np.zeros(1, SOLVER)
    memory["numbers"][0, :MODEL_SIZE] = model
    memory["lower"] = (SLOWEST_TRACK, SLOWEST_TRACK, -LARGEST_SIDESLIP)
    memory["upper"] = (FASTEST_TRACK, FASTEST_TRACK, LARGEST_SIDESLIP)
    memory["quadratic"] = np.inf
    memory["linearise"], memory["residuals"] = linearise_there.address, residuals_there.address
    memory["improve"] = improve_there.address
    return memory


@inlined
def model_of(solver: Solver) -> TrackModel:
    """The model that a solver was made for."""
    n = solver.numbers
    return TrackModel(n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7], n[8], n[9])


@inlined
def no_slip_speed(model: TrackModel, curvature: float, track: int) -> float:
    """Speed ratio of a track (0 left, 1 right) that does not slip, kept in the physical box."""
    arm = (0.5 - track) * model.gauge - model.cog_left
    return min(max(1.0 - curvature * arm, 2.0 * SLOWEST_TRACK), 0.5 * FASTEST_TRACK)


@kernel
def near_no_slip(model: TrackModel, curvature: float, x: Array) -> None:
    """Track speed ratios with hardly any slip, and no sideslip, into x.

    Without any, a track on a straight line would not slide at all, and the direction of its shear would be undefined.
    """
    for track in range(2):
        x[track] = no_slip_speed(model, curvature, track) + SLIP_SCALE
    x[2] = 0.0


@kernel
def set_point(solver: Solver, point: OperatingPoint) -> None:
    """Make an operating point the one to be balanced."""
    for i, value in enumerate(point):
        solver.numbers[MODEL_SIZE + i] = value


@inlined
def point_in(solver: Solver) -> OperatingPoint:
    """The operating point that was set."""
    n = solver.numbers
    return OperatingPoint(n[10], n[11], n[12], n[13], n[14])


@procedure(LINEARISE)
def linearise_there(memory, unknowns, residual, jacobian):  # type: ignore[no-untyped-def]
    """`linearise` by address."""
    solver = carray(memory, 1, SOLVER)[0]
    rule = COARSE if solver.coarse else FINE
    x, r, J = carray(unknowns, 3), carray(residual, 3), carray(jacobian, (3, 3))
    balance(model_of(solver), point_in(solver), rule, x, r, J, solver.traction, True)


@procedure(RESIDUALS)
def residuals_there(memory, unknowns, residual):  # type: ignore[no-untyped-def]
    """`residuals` by address."""
    solver = carray(memory, 1, SOLVER)[0]
    rule = COARSE if solver.coarse else FINE
    x, r = carray(unknowns, 3), carray(residual, 3)
    balance(model_of(solver), point_in(solver), rule, x, r, solver.work.trial_jacobian, solver.traction, False)


@inlined
def linearise(solver: Solver, x: Array, residual: Array, jacobian: Array) -> None:
    """Balance at x of the operating point that was set, with its derivatives."""
    call_linearise(solver.linearise, solver.numbers.ctypes, x.ctypes, residual.ctypes, jacobian.ctypes)


@inlined
def residuals(solver: Solver, x: Array, residual: Array) -> None:
    """Balance at x of the operating point that was set, without derivatives."""
    call_residuals(solver.residuals, solver.numbers.ctypes, x.ctypes, residual.ctypes)


@kernel
def evaluate(solver: Solver, point: OperatingPoint, x: Array, residual: Array, jacobian: Array) -> None:
    """Balance at x."""
    set_point(solver, point)
    linearise(solver, x, residual, jacobian)


@kernel
def residual_at(solver: Solver, point: OperatingPoint, x: Array) -> float:
    """Largest residual at x; `solver.work` holds the balance there."""
    evaluate(solver, point, x, solver.work.residual, solver.work.jacobian)
    return lm.largest(solver.work.residual)


@inlined
def forget(solver: Solver) -> None:
    """Let the next solution owe nothing to those before it."""
    solver.quadratic = np.inf


@kernel
def evaluate_trial(solver: Solver, newton: bool, tolerance: float) -> int:
    """Balance at the trial point, without derivatives where that is expected to be the root; the number of evaluations.

    Newton's step squares the residual, up to a factor that the last such step has shown. The derivatives are then those
    at the start of the step.
    """
    work = solver.work
    square = lm.largest(work.residual) ** 2
    expected = newton and solver.quadratic * square <= tolerance
    if expected:
        for i in range(3):
            for j in range(3):
                work.trial_jacobian[i, j] = work.jacobian[i, j]
        residuals(solver, work.trial, work.trial_residual)
    else:
        linearise(solver, work.trial, work.trial_residual, work.trial_jacobian)
    remaining = lm.largest(work.trial_residual)
    if newton:
        solver.quadratic = remaining / square
    if expected and not remaining <= tolerance:
        linearise(solver, work.trial, work.trial_residual, work.trial_jacobian)
        return 2
    return 1


@inlined
def branch_sign(jacobian: Array) -> float:
    """Determinant of the balance: positive on the branch that goes on from low speed, negative beyond its fold."""
    a = jacobian
    return float(
        a[0, 0] * (a[1, 1] * a[2, 2] - a[1, 2] * a[2, 1])
        - a[0, 1] * (a[1, 0] * a[2, 2] - a[1, 2] * a[2, 0])
        + a[0, 2] * (a[1, 0] * a[2, 1] - a[1, 1] * a[2, 0])
    )


@kernel
def is_near_fold(jacobian: Array) -> bool:
    """Whether the derivatives must be those at the root itself to tell on which side of the fold it is."""
    size = lm.largest(jacobian[0]) * lm.largest(jacobian[1]) * lm.largest(jacobian[2])
    return abs(branch_sign(jacobian)) < NEAR_FOLD * size


@kernel
def improve(solver: Solver, x: Array, effort: Effort) -> bool:
    """Levenberg-Marquardt from x, in place, for the operating point that was set.

    `solver.work` holds the balance at x; its derivatives may be those of one Newton step before, away from a fold.
    """
    work = solver.work
    linearise(solver, x, work.residual, work.jacobian)
    evaluations = 1
    damping = 0.0
    while not lm.is_solved(work, effort.tolerance):
        if evaluations >= effort.evaluations or damping > lm.LARGEST_DAMPING:
            return False
        if lm.propose(x, damping, solver.lower, solver.upper, work):
            evaluations += evaluate_trial(solver, damping == 0.0, effort.tolerance)
            damping = lm.judge(x, damping, work)
        else:
            damping = lm.more_damping(damping)
    if is_near_fold(work.jacobian):
        linearise(solver, x, work.residual, work.jacobian)
    return True


@procedure(IMPROVE)
def improve_there(memory, unknowns, tolerance, evaluations):  # type: ignore[no-untyped-def]
    """`improve` by address."""
    return int(improve(carray(memory, 1, SOLVER)[0], carray(unknowns, 3), Effort(tolerance, evaluations)))


@kernel
def solve_from(solver: Solver, point: OperatingPoint, x: Array, effort: Effort) -> bool:
    """Levenberg-Marquardt from x, which is improved in place; whether the tolerance was met.

    `solver.work` holds the balance at x.
    """
    set_point(solver, point)
    return bool(call_improve(solver.improve, solver.numbers.ctypes, x.ctypes, effort.tolerance, effort.evaluations))


@kernel
def is_answer(solver: Solver, x: Array) -> bool:
    """Whether a root just found is on the branch that goes on from low speed, inside the physical box."""
    return branch_sign(solver.work.jacobian) > 0.0 and not outside_box(x)


@kernel
def solve_warm(solver: Solver, point: OperatingPoint, x: Array) -> bool:
    """Solve from a start near the root; True if the root found is the answer."""
    solved = solve_from(solver, point, x, WARM)
    return solved and is_answer(solver, x)


@kernel
def solve_cold(solver: Solver, point: OperatingPoint, x: Array) -> bool:
    """Solve from a start that may be far from the root; True if the root found is the answer."""
    solved = solve_from(solver, point, x, COLD)
    return solved and is_answer(solver, x)
