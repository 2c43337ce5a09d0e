"""Fastest speed along a line under limits of speed and acceleration."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel

Array = NDArray[np.float64]


@kernel
def fastest_speed(arc_length: Array, most: Array, acceleration: Array, first: float, last: float) -> Array:
    """Largest speed that changes no faster than allowed, by one pass forwards and one backwards.

    Between samples the acceleration is constant.

    Parameters
    ----------
    arc_length
        Of the samples, ascending, shape (n,). [m]
    most
        Speed limit at the samples, shape (n,). [m/s]
    acceleration
        Largest acceleration either way at the samples, shape (n,); between two the lesser counts. [m/s2]
    first, last
        Largest speeds at the ends. [m/s]

    Returns
    -------
    ndarray, shape (n,)
        [m/s]
    """
    count = arc_length.size
    square = most * most
    square[0] = min(square[0], first * first)
    square[count - 1] = min(square[count - 1], last * last)
    for i in range(1, count):
        gain = 2.0 * min(acceleration[i - 1], acceleration[i]) * (arc_length[i] - arc_length[i - 1])
        square[i] = min(square[i], square[i - 1] + gain)
    for i in range(count - 2, -1, -1):
        gain = 2.0 * min(acceleration[i], acceleration[i + 1]) * (arc_length[i + 1] - arc_length[i])
        square[i] = min(square[i], square[i + 1] + gain)
    return np.sqrt(square)
