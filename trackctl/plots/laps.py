"""Laps of a driven path."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from trackctl.plots.style import Array


def laps(yaw: Array) -> list[slice]:
    """Rows of each lap: 2 pi of yaw from the start, whole laps only; the row that ends a lap begins the next.

    Parameters
    ----------
    yaw : ndarray, shape (n_rows,)
        Wrapped or not, less than half a turn between rows. [rad]
    """
    turned = np.abs(np.unwrap(yaw) - yaw[0]) / (2.0 * np.pi)
    # Rounding must not lose a last lap that ends with the file.
    whole = int(turned[-1] + 1e-6)
    ends = [int(np.argmax(turned >= lap - 1e-6)) for lap in range(whole + 1)]
    return [slice(start, end) for start, end in pairwise(ends)]
