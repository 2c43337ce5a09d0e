"""Occupancy by the shades of grey of an image, as nav2's map_server reads them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from trackctl.files.map_image import GreyImage
from trackctl.planning.occupancy import OCCUPIED, UNKNOWN


class MapMode(StrEnum):
    """How shades become occupancy."""

    TRINARY = "trinary"
    SCALE = "scale"
    RAW = "raw"


@dataclass(frozen=True, slots=True)
class Shades:
    """How shades of grey are to be read.

    Attributes
    ----------
    mode
        See `occupancy_cells`.
    negate
        Whether white is occupied, not black.
    occupied, free
        From where on, and up to where, the darkness from 0 to 1 counts as such.
    """

    mode: MapMode
    negate: bool
    occupied: float
    free: float


def occupancy_cells(image: GreyImage, shades: Shades) -> NDArray[np.int8]:
    """Occupancy of each pixel, row 0 the lowest.

    `TRINARY`: occupied, free, or between the two unknown. `SCALE`: between the two in percent of the way. `RAW`: the
    shade itself, unknown above 100. What is not opaque is unknown but in `RAW`.

    Returns
    -------
    ndarray of int8, shape (n_rows, n_columns)
        -1 unknown, 0 free to 100 occupied.
    """
    grey = image.grey[::-1]
    table = raw_table() if shades.mode is MapMode.RAW else shade_table(shades)
    cells = table[grey]
    if shades.mode is not MapMode.RAW:
        cells[image.is_clear[::-1]] = UNKNOWN
    return cells


def raw_table() -> NDArray[np.int8]:
    """Occupancy of the 256 shades, taken as it."""
    shade = np.arange(256)
    return np.where(shade <= OCCUPIED, shade, UNKNOWN).astype(np.int8)


def shade_table(shades: Shades) -> NDArray[np.int8]:
    """Occupancy of the 256 shades by their darkness."""
    shade = np.arange(256)
    # Divided last, so that a threshold such as 0.8 is met by 204/255 to the last bit.
    darkness = (shade if shades.negate else 255 - shade) / 255
    between = np.full(256, float(UNKNOWN))
    if shades.mode is MapMode.SCALE and shades.occupied > shades.free:
        between = np.floor(OCCUPIED * (darkness - shades.free) / (shades.occupied - shades.free) + 0.5)
    return np.select((darkness >= shades.occupied, darkness <= shades.free), (OCCUPIED, 0), between).astype(np.int8)
