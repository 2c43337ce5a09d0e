"""Learning a slip model from a log, and predicting with one: blocks of rows in, updates out."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from trackctl.identification.filter_state import LOG_FILTER, POSE, POSES, ROWS_AT_ONCE, UPDATE, UPDATES
from trackctl.identification.log_filter import advance, settle_all
from trackctl.identification.slip_model import GEOMETRIC, PARAMETERS, FilterKind, SlipModel
from trackctl.identification.track_history import ring

Array = NDArray[np.float64]
#: An array of `UPDATE`.
Updates = NDArray[np.void]

#: Rows kept of a window, as a share of the shorter of window and horizon.
RESOLUTION = 1.0 / 40.0
#: Bounds of a window that follows the poses. [s]
WINDOWS = (1.0, 4.0)


@dataclass(frozen=True, slots=True)
class Noise:
    """What is assumed of sensors, model and ground.

    Attributes
    ----------
    position, heading, speed
        Standard deviations of a pose's coordinates [m] and heading [rad], and of a row's track speeds. [m/s]
    model
        First guess of the model's error, as a share of the motion; it is learned. [-]
    memory
        Time over which the model's error is averaged. [s]
    drift
        Growth of the parameters' variance, in prior variances a second. [1/s]
    acceleration, curvature
        Beside offsets, p1, p3 and p5 may shift an ICR by half the gauge (prior standard deviation) at this lateral
        acceleration [m/s2], and p2, p4 and p6 at this curvature. [1/m]
    speed_factor
        Prior standard deviation of the errors of the speeds' scale. [-]
    """

    position: float = 0.02
    heading: float = math.radians(0.1)
    speed: float = 0.02
    model: float = 0.02
    memory: float = 20.0
    drift: float = 0.02
    acceleration: float = 10.0
    curvature: float = 2.0
    speed_factor: float = 0.1


@dataclass(frozen=True, slots=True)
class FilterSettings:
    """How to learn.

    Attributes
    ----------
    track_gauge
        B. [m]
    model, kind
        Which parameters are learned, from what.
    window
        Time over which motions are compared; None for one that spans three poses, from 1 to 4 s. [s]
    horizon
        Time over which motions are predicted; 0 for none. [s]
    noise
        See `Noise`.
    """

    track_gauge: float
    model: SlipModel = SlipModel.PARAMETRIC
    kind: FilterKind = FilterKind.WINDOW
    window: float | None = None
    horizon: float = 2.0
    noise: Noise = field(default_factory=Noise)


@dataclass(frozen=True, slots=True, eq=False)
class LearnedSlip:
    """Parameters of a slip model and how sure they are.

    Attributes
    ----------
    p : ndarray, shape (11,)
        ICR parameters p1 to p9 and errors of the speeds' scale p10, p11.
    covariance : ndarray, shape (11, 11)
    position_error, heading_error
        The model's own error as a share of the distance rolled and of the angle turned. [-]
    """

    p: Array
    covariance: Array
    position_error: float
    heading_error: float


def prior_std(settings: FilterSettings) -> Array:
    """Standard deviations of the parameters before anything is learned, shape (11,); 0 of those that never are.

    Offsets may be half the gauge. Without them, in the paper's model, the other parameters make up for them.
    """
    noise, learned = settings.noise, list(settings.model.learned)
    std = np.full(PARAMETERS, 0.5 * settings.track_gauge)
    if GEOMETRIC - 1 in learned:
        std[0:6:2] /= noise.acceleration
        std[1:6:2] /= noise.curvature
    std[GEOMETRIC:] = noise.speed_factor
    std[[i for i in range(PARAMETERS) if i not in learned]] = 0.0
    return std


class LogFilter:
    """A filter fed by blocks of rows, with memory of constant size.

    Parameters
    ----------
    settings
        How to learn.
    known
        A slip model to predict with; without one it is learned.
    """

    def __init__(self, settings: FilterSettings, known: LearnedSlip | None = None) -> None:
        self._memory = np.zeros(1, LOG_FILTER)
        self._history = ring()
        self._poses = np.zeros(POSES, POSE)
        self._updates = np.zeros(UPDATES, UPDATE)
        noise, memory = settings.noise, self._memory
        shortest, longest = WINDOWS if settings.window is None else (settings.window, settings.window)
        memory["gauge"], memory["horizon"] = settings.track_gauge, settings.horizon
        memory["window"] = memory["shortest_window"] = shortest
        memory["longest_window"] = longest
        memory["resolution"] = RESOLUTION * min(shortest, settings.horizon or shortest)
        memory["position_variance"] = noise.position**2
        memory["heading_variance"] = noise.heading**2
        memory["speed_variance"] = noise.speed**2
        memory["by_velocity"] = settings.kind is FilterKind.VELOCITY
        memory["learns"] = known is None
        memory["gates"] = settings.model is not SlipModel.NONE
        estimate = memory["estimate"]
        estimate["prior"] = prior_std(settings) ** 2
        estimate["drift"], estimate["memory"] = noise.drift, noise.memory
        if known is None:
            estimate["P"] = np.diag(estimate["prior"][0])
            estimate["position_error"] = estimate["heading_error"] = noise.model**2
        else:
            estimate["p"], estimate["P"] = known.p, known.covariance
            estimate["position_error"], estimate["heading_error"] = known.position_error**2, known.heading_error**2

    def feed(self, rows: Array) -> Updates:
        """Take rows of a log.

        Parameters
        ----------
        rows : ndarray, shape (n, 6)
            Time [s], left and right track speed [m/s], x, y [m] and yaw [rad]; NaN where there is none.

        Returns
        -------
        ndarray of UPDATE
            What is settled by now, in order of time: one for each new pose.
        """
        rows = np.ascontiguousarray(rows, np.float64)
        done = [self._updates[:0]]
        for start in range(0, len(rows), ROWS_AT_ONCE):
            before = self._settled()
            part = rows[start : start + ROWS_AT_ONCE]
            advance(self._memory[0], self._history, self._poses, self._updates, part)
            done.append(self._settled_since(before))
        return np.concatenate(done)

    def finish(self) -> Updates:
        """The updates that still wait for a later pose, at the end of a log."""
        before = self._settled()
        settle_all(self._memory[0], self._history, self._updates)
        return self._settled_since(before)

    def learned(self) -> LearnedSlip:
        """What has been learned so far."""
        estimate = self._memory["estimate"][0]
        return LearnedSlip(
            estimate["p"].copy(),
            estimate["P"].copy(),
            math.sqrt(estimate["position_error"]),
            math.sqrt(estimate["heading_error"]),
        )

    @property
    def skipped(self) -> int:
        """Rows so far without a time, or late."""
        return int(self._memory["skipped"][0])

    @property
    def held(self) -> int:
        """Poses so far that only repeat the last."""
        return int(self._memory["held"][0])

    @property
    def gaps(self) -> int:
        """Gaps in the track speeds so far."""
        return int(self._memory["gaps"][0])

    @property
    def resets(self) -> int:
        """How often what was learned had to be forgotten."""
        return int(self._memory["resets"][0])

    def _settled(self) -> int:
        """Number of updates settled so far."""
        return int(self._memory["settled"][0])

    def _settled_since(self, before: int) -> Updates:
        """A copy of the updates settled since there were this many."""
        return np.asarray(self._updates[np.arange(before, self._settled()) % UPDATES])
