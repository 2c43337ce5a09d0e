"""Arguments of the functions for Python: checked where the command line would, arrays made to go together."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trackctl.errors import UsageError

Array = NDArray[np.float64]


def unheard(*news: object) -> None:
    """For progress that nobody asked for."""


def check(name: str, value: object, is_allowed: bool, allowed: str) -> None:
    """Refuse a value."""
    if not is_allowed:
        raise UsageError(name, value, allowed)


def check_all(name: str, values: Array, are_allowed: NDArray[np.bool_], allowed: str) -> None:
    """Refuse the first value that is not allowed."""
    for value in values[~are_allowed]:
        raise UsageError(name, value, allowed)


def operating_points(given: Mapping[str, ArrayLike]) -> tuple[Array, tuple[int, ...]]:
    """Slope, velocity, curvature and heading, shape (4, n), and the shape that they broadcast to."""
    try:
        arrays = np.broadcast_arrays(*(np.asarray(values, np.float64) for values in given.values()))
    except (TypeError, ValueError) as error:
        raise UsageError(", ".join(given), error, "numbers, or arrays of shapes that go together") from None
    return np.stack([array.ravel() for array in arrays]), arrays[0].shape
