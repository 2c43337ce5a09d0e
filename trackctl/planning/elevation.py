"""Height of the ground over a grid, and its slope at the scale of a vehicle."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.planning.slope_field import SlopeField
from trackctl.profiles.footprint import Footprint

Array = NDArray[np.float64]

#: Weights beyond this many standard deviations are left out.
REACH = 4.0
#: A window narrower than the grid still weighs the neighbours: by exp(-2), its standard deviation in spacings being
NARROWEST = 0.5
#: Nodes in a window lie on one line where the determinant of their second moments is below this part of its largest.
COLLINEAR = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Elevation:
    """Heights at the nodes of a grid along the world's axes.

    Attributes
    ----------
    height
        Shape (n_rows, n_columns), row 0 the lowest y; NaN where not known. [m]
    spacing_x, spacing_y
        Of the nodes. [m]
    x, y
        Node (0, 0) in the world. [m]
    source
        The file it comes from, for messages.
    """

    height: Array
    spacing_x: float
    spacing_y: float
    x: float
    y: float
    source: str

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Lowest x, y and highest x, y that a node stands for: half a spacing beyond the outermost. [m]"""
        n_rows, n_columns = self.height.shape
        left, low = self.x - 0.5 * self.spacing_x, self.y - 0.5 * self.spacing_y
        return left, low, left + n_columns * self.spacing_x, low + n_rows * self.spacing_y


def footprint_scale(footprint: Footprint) -> float:
    """Standard deviation of a footprint's area about its centre along one axis, the mean of all headings. [m]

    For a rectangle that of its sides' lengths: sqrt((length^2 + width^2) / 24).
    """
    x, y = np.array(footprint).T
    length, width = np.ptp(x), np.ptp(y)
    return math.sqrt((length * length + width * width) / 24.0)


def fitted_slopes(elevation: Elevation, scale: float) -> SlopeField:
    """Gradient of the plane that fits the heights about each node best.

    Least squares over the known nodes, weighted by exp(-r^2 / (2 scale^2)): exact for a plane, also beside unknown
    nodes, and for waves of wave number k smaller by exp(-(k scale)^2 / 2).

    Parameters
    ----------
    elevation
        The heights.
    scale
        Standard deviation of the weights along either axis, such as `footprint_scale`; half a spacing at least. [m]

    Returns
    -------
    SlopeField
        NaN where the height is not known, or the known nodes about lie on a line.
    """
    known = np.isfinite(elevation.height)
    mean = elevation.height[known].mean() if known.any() else 0.0
    windows = (
        _Window.of(scale, elevation.spacing_y, elevation.height.shape[0]),
        _Window.of(scale, elevation.spacing_x, elevation.height.shape[1]),
    )
    with np.errstate(invalid="ignore"):  # far from all that is known
        gradient_x, gradient_y = _plane_gradient(known, np.where(known, elevation.height - mean, 0.0), windows)
    return SlopeField(gradient_x, gradient_y, elevation.spacing_x, elevation.spacing_y, elevation.x, elevation.y)


@dataclass(frozen=True, slots=True, eq=False)
class _Window:
    """Weights along one axis, and the distances that they stand at. [m]"""

    weight: Array
    distance: Array

    @classmethod
    def of(cls, scale: float, spacing: float, count: int) -> _Window:
        deviation = max(scale, NARROWEST * spacing)
        reach = min(math.ceil(REACH * deviation / spacing), max(count - 1, 1))
        distance: Array = spacing * np.arange(-reach, reach + 1.0)
        return cls(np.exp(-0.5 * (distance / deviation) ** 2), distance)


def _plane_gradient(known: NDArray[np.bool_], height: Array, windows: tuple[_Window, _Window]) -> tuple[Array, Array]:
    """Slopes of the planes by the normal equations about each window's mean."""
    total, x, y, xx, xy, yy = _known_moments(known, windows)
    h, xh, yh = _moments(height, windows, ((0, 0), (1, 0), (0, 1)))
    xx, xy, yy = xx - x * x / total, xy - x * y / total, yy - y * y / total
    xh, yh = xh - x * h / total, yh - y * h / total
    determinant = xx * yy - xy * xy
    determinant[~known | (determinant <= COLLINEAR * xx * yy)] = np.nan
    return (yy * xh - xy * yh) / determinant, (xx * yh - xy * xh) / determinant


def _known_moments(known: NDArray[np.bool_], windows: tuple[_Window, _Window]) -> list[Array]:
    """Those of the known nodes alone, of the powers (0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2) of x and y."""
    powers = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    if not known.all():
        return _moments(known.astype(np.float64), windows, powers)
    along_y, along_x = (
        [_weighed(np.ones(count), window, power, 0) for power in range(3)]
        for window, count in zip(windows, known.shape, strict=True)
    )
    return [np.multiply.outer(along_y[power_y], along_x[power_x]) for power_x, power_y in powers]


def _moments(values: Array, windows: tuple[_Window, _Window], powers: tuple[tuple[int, int], ...]) -> list[Array]:
    """Weighted sums about each node of the values times powers of the distances along x and y."""
    along_x = {power: _weighed(values, windows[1], power, 1) for power in {power_x for power_x, _ in powers}}
    return [_weighed(along_x[power_x], windows[0], power_y, 0) for power_x, power_y in powers]


def _weighed(values: Array, window: _Window, power: int, axis: int) -> Array:
    from scipy.ndimage import correlate1d

    return correlate1d(values, window.weight * window.distance**power, axis=axis, mode="constant")
