"""What the solvers leave behind for each cell."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Status of a cell not decided yet.
PENDING = 255

#: One cell: track speed ratios of the left and right track [-] and sideslip [rad], NaN where no root was found; shear
#: force on the left and right track [m g]; largest residual (without a root, the least met) [-]; a code of
#: `trackctl.lut.table.Status`, or `PENDING`.
CELL = np.dtype(
    [
        ("unknowns", np.float64, 3),
        ("traction", np.float64, 2),
        ("residual", np.float64),
        ("status", np.uint8),
    ],
    align=True,
)

#: An array of `CELL`.
Cells = NDArray[Any]


def pending_cells(shape: tuple[int, ...]) -> Cells:
    """Cells that nothing is known of."""
    cells = np.zeros(shape, CELL)
    for name in ("unknowns", "traction", "residual"):
        cells[name] = np.nan
    cells["status"] = PENDING
    return cells
