"""State of an integration in progress: what a step is, where the run stands, and the memory that it works in."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from trackctl.simulation.collocation import STAGES

UNKNOWNS = 3 * STAGES
#: Jacobians that are kept, for as many lengths of steps.
JACOBIANS = 4

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
        ("left_speed", np.float64),  # of the tracks, at the end of the last step
        ("right_speed", np.float64),
        ("last_error", np.float64),  # of the last step, over the tolerance
        ("error", np.float64),  # of the velocities in a step [m/s]
        ("smooth", np.float64),  # length of a step in which the positions err by what is of no account [s]
        ("jacobian_step", np.float64, JACOBIANS),  # lengths of the steps of the Jacobians, 0 for one that is too old
        ("jacobian", np.int64),  # the one in use
        ("to_come", np.float64),  # what Newton's method leaves, over its last correction
        ("inverse", np.float64, (JACOBIANS, UNKNOWNS, UNKNOWNS)),
        ("filter", np.float64, (JACOBIANS, 3, 3)),
        ("change", np.float64, (STAGES, 3)),
        ("poses", np.float64, (STAGES + 1, 3)),
        ("velocities", np.float64, (STAGES + 1, 3)),
        ("stage_rate", np.float64, 3),
        ("force_rate", np.float64, 3),
        ("residual", np.float64, UNKNOWNS),
        ("beside", np.float64, UNKNOWNS),
        ("about", np.float64, UNKNOWNS),
        ("matrix", np.float64, (UNKNOWNS, UNKNOWNS)),
        ("small", np.float64, (3, 3)),
        ("travel", np.float64, 2),
        ("evaluations", np.int64),
        ("linearisations", np.int64),
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
