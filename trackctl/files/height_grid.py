"""Heights as they stand in a file, before they are laid into a map."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from trackctl.errors import MapError

Array = NDArray[np.float64]

#: What a fit of slopes can hold in memory: 2000 x 2000.
MAX_NODES = 4_000_000
#: Heights beyond are no ground but a mark for unknown ones that the file does not declare. [m]
HIGHEST = 1e5


@dataclass(frozen=True, slots=True, eq=False)
class HeightGrid:
    """Heights of square or oblong cells, lengths in the unit of the file.

    Attributes
    ----------
    height
        At the cells' centres, shape (n_rows, n_columns), the first row the top; NaN where not known. [m]
    spacing
        Width and height of a cell; None where the file tells none.
    corner
        x and y of the lower left corner of the lower left cell; None where the file tells none.
    is_geographic
        Whether lengths are degrees of longitude and latitude; None where the file does not tell.
    """

    height: Array
    spacing: tuple[float, float] | None
    corner: tuple[float, float] | None
    is_geographic: bool | None = None


def check_size(path: Path, n_rows: int, n_columns: int) -> None:
    """Refuse a grid, before its heights are read, that is too small for a slope or too large for memory."""
    if min(n_rows, n_columns) < 2 or n_rows * n_columns > MAX_NODES:
        raise MapError(path, f"has {n_rows} x {n_columns} heights; allowed: 2 x 2 or more, up to {MAX_NODES}")


def known_heights(path: Path, values: NDArray[np.generic], nodata: float | None) -> Array:
    """Heights as floats, NaN in place of `nodata` and of what is not finite.

    Raises
    ------
    MapError
        If there is a height beyond `HIGHEST`, or none at all.
    """
    with np.errstate(invalid="ignore"):  # a damaged float may be a signalling NaN
        heights = values.astype(np.float64)
    heights[~np.isfinite(heights)] = np.nan
    if nodata is not None and np.isfinite(nodata):
        # Files state it in fewer digits than their heights have.
        heights[np.isclose(heights, nodata, rtol=1e-6, atol=0.0)] = np.nan
    if np.isnan(heights).all():
        raise MapError(path, "holds no known height")
    worst = float(heights.flat[np.nanargmax(np.abs(heights))])
    if abs(worst) > HIGHEST:
        raise MapError(path, f"holds a height of {worst:g} m; allowed: up to {HIGHEST:g}, others declared as NODATA")
    return heights
