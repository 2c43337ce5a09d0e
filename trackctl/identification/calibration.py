"""Ground under a vehicle from its steady motions: least squares on the slope-steering model, on level ground."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from trackctl.identification.steady_motion import steady_motions
from trackctl.identification.steady_windows import SteadyWindows, within_model
from trackctl.identification.uncertainty import standard_deviations
from trackctl.mechanics.parameters import TrackModel

Array = NDArray[np.float64]

NAMES = ("friction", "shear_modulus", "resistance")
#: Range of each, in its own unit; friction and K are sought as logarithms.
LOWER, UPPER = np.array([0.03, 1e-4, 0.0]), np.array([2.0, 0.3, 0.6])
IS_LOGARITHM = np.array([True, True, False])
#: A parameter is determined when its standard deviation is at most this share of it, or this much for the resistance.
DETERMINED, DETERMINED_RESISTANCE = 0.35, 0.01
#: At the end of its range, as a share of it.
AT_END = 1e-3
#: Ground tried for a first guess: friction, K and resistance.
TRIED = ((0.1, 0.2, 0.4, 0.8), (0.001, 0.005, 0.02, 0.08), (0.0, 0.05, 0.15))
PASSES = 3
#: Step of the difference quotients, in ln or in the resistance. [-]
STEP = 1e-3
#: A parameter that is not determined keeps the assumed value unless that costs more than this many half chi-squares.
MOST_COST = 2.0
#: Median absolute deviation of a normal distribution over its standard deviation.
MAD = 0.6745


@dataclass(frozen=True, slots=True)
class Estimate:
    """A parameter of the ground.

    Attributes
    ----------
    value
    noise_std
        Standard deviation with all others unknown, by what differs from motion to motion.
    misfit_std
        By an error of the model, which no longer log averages out; seen in what motions at like speeds have in common.
    determined
        Whether the motions tell it, as far as noise goes.
    """

    value: float
    noise_std: float
    misfit_std: float
    determined: bool

    @property
    def std(self) -> float:
        """Standard deviation by both."""
        return math.hypot(self.noise_std, self.misfit_std)

    @property
    def is_by_misfit(self) -> bool:
        """Whether the model's misfit is the larger part of the standard deviation."""
        return self.misfit_std > self.noise_std


@dataclass(frozen=True, slots=True)
class Calibration:
    """Ground parameters.

    Attributes
    ----------
    friction, shear_modulus, resistance
        mu [-], K [m] and f_r [-].
    windows
        Steady motions that were fitted.
    unsolved
        Those among them for which the fitted model has no equilibrium.
    residual_std
        Standard deviation of what the model leaves of forward and lateral velocity [m/s] and yaw rate. [rad/s]
    """

    friction: Estimate
    shear_modulus: Estimate
    resistance: Estimate
    windows: int
    unsolved: int
    residual_std: tuple[float, float, float]

    @property
    def estimates(self) -> dict[str, Estimate]:
        """The parameters by name."""
        return {name: getattr(self, name) for name in NAMES}


class Fit:
    """The model's steady motions against measured ones."""

    def __init__(self, model: TrackModel, windows: SteadyWindows) -> None:
        measured, self._back = within_model(windows, model.length)
        self._model, self.speeds, self.twists = model, measured.speeds, measured.twists
        self.sensor_stds = measured.stds
        self.stds = measured.stds
        self._last: Array | None = None

    def motions(self, values: Array) -> Array:
        """Motions of the model with these parameters, shape (n, 3); NaN where there is none."""
        model = self._model._replace(**dict(zip(NAMES, values.tolist(), strict=True)))
        behind = model._replace(cog_forward=-model.cog_forward, cog_left=-model.cog_left)
        result = np.empty_like(self.twists)
        for way, chosen in ((model, ~self._back), (behind, self._back)):
            starts = None if self._last is None else self._last[chosen]
            result[chosen] = steady_motions(way, self.speeds[chosen], starts)
        self._last = result
        return result

    def residuals(self, values: Array) -> Array:
        """Differences in standard deviations, shape (3 n,)."""
        # Without an equilibrium the vehicle goes nowhere, which is far off and steers the search away.
        return ((np.nan_to_num(self.motions(values)) - self.twists) / self.stds).ravel()


def calibrate_ground(model: TrackModel, windows: SteadyWindows) -> Calibration:
    """Fit friction, K and resistance, and say which of them the motions determine.

    Of those that they do not, the loosest stay as `model` has them until the rest can be fitted.

    On level ground at low speed all forces are in proportion to the friction, and it cannot be told: only the lateral
    acceleration and the resistance, over the friction, show.

    Parameters
    ----------
    model
        Vehicle, and the ground that is assumed.
    windows
        Steady motions; at least one that is usable.
    """
    fit = Fit(model, windows)
    assumed = np.clip([getattr(model, name) for name in NAMES], LOWER, UPPER)
    free = np.ones(3, np.bool_)
    joint = found = fitted(fit, first_guess(fit, assumed), free)
    while (loose := free & ~is_determined(found)).any():
        worst = int(np.argmax(np.where(loose, looseness(found), -1.0)))
        free[worst] = False
        found = without(fit, found, worst, assumed[worst], free)
    left = fit.motions(found.values) - fit.twists
    known = np.all(np.isfinite(left), axis=1)
    friction, modulus, resistance = (
        Estimate(float(value), float(std), float(misfit), bool(known))
        for value, std, misfit, known in zip(found.values, joint.std, joint.misfit, is_determined(joint), strict=True)
    )
    stds = np.sqrt(np.mean(left[known] ** 2, axis=0)).tolist() if known.any() else [math.inf] * 3
    unsolved = int(np.count_nonzero(~known))
    return Calibration(friction, modulus, resistance, len(known), unsolved, (stds[0], stds[1], stds[2]))


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """Values of the parameters, standard deviations by noise and by misfit, and half the chi-square that they leave."""

    values: Array
    std: Array
    misfit: Array
    cost: float


def first_guess(fit: Fit, assumed: Array) -> Array:
    """The best of the assumed ground and of a coarse grid."""
    tried = [assumed, *map(np.array, itertools.product(*TRIED))]
    return min(tried, key=lambda values: float(np.abs(fit.residuals(values)).sum()))


def without(fit: Fit, found: Found, index: int, assumed: float, free: NDArray[np.bool_]) -> Found:
    """A fit with one parameter fewer: as assumed if that fits, or else left where it is best."""
    values = found.values.copy()
    values[index] = assumed
    again = fitted(fit, values, free, passes=1)
    return again if again.cost <= found.cost + MOST_COST else fitted(fit, found.values, free, passes=1)


def looseness(found: Found) -> Array:
    """Standard deviations over what would count as determined."""
    share = DETERMINED * found.values
    return found.std / np.where(IS_LOGARITHM, share, np.maximum(share, DETERMINED_RESISTANCE))


def is_determined(found: Found) -> NDArray[np.bool_]:
    """Whether parameters are known well enough, and not just at the end of their range."""
    values = found.values
    inside = (values > LOWER * (1.0 + AT_END)) & (values < UPPER * (1.0 - AT_END))
    return np.asarray((looseness(found) <= 1.0) & (inside | ~IS_LOGARITHM))


def fitted(fit: Fit, start: Array, free: NDArray[np.bool_], passes: int = PASSES) -> Found:
    """Fit the free parameters, the others stay.

    The noise of each channel is what a fit leaves; all but a single pass adapt it.
    """
    if not free.any():
        return Found(start, np.zeros(3), np.zeros(3), math.inf)
    least, values = fit.sensor_stds, start
    lower, upper = sought(LOWER)[free], sought(UPPER)[free]

    def at(x: Array) -> Array:
        full = start.copy()
        full[free] = np.where(IS_LOGARITHM[free], np.exp(x), x)
        return full

    def residuals(x: Array) -> Array:
        return fit.residuals(at(x))

    def slopes(x: Array) -> Array:
        steps = STEP * np.eye(len(x))
        return np.stack([residuals(x + h) - residuals(x - h) for h in steps], axis=1) / (2.0 * STEP)

    for _ in range(passes):
        x = np.clip(sought(values)[free], lower + 1e-9, upper - 1e-9)
        solution = least_squares(residuals, x, jac=slopes, bounds=(lower, upper), loss="soft_l1")
        values = at(solution.x)
        if passes > 1:
            off = np.abs(fit.residuals(values)).reshape(-1, 3) * fit.stds
            fit.stds = np.maximum(least, np.median(off, axis=0) / MAD)
    scale = np.where(IS_LOGARITHM, values, 1.0)
    std, misfit = np.zeros(3), np.zeros(3)
    std[free], misfit[free] = standard_deviations(slopes(solution.x), fit.residuals(values), fit.speeds)
    return Found(values, std * scale, misfit * scale, float(solution.cost))


def sought(values: Array) -> Array:
    """The parameters as they are sought: logarithms of friction and K."""
    return np.where(IS_LOGARITHM, np.log(np.maximum(values, 1e-300)), values)
