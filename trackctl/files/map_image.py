"""Grey images of maps, as map_server reads them."""

from __future__ import annotations

import struct
import warnings
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from trackctl.errors import MapError
from trackctl.files.read_errors import why_unreadable
from trackctl.files.regular_file import check_regular
from trackctl.planning.planning_map import MAX_CELLS

if TYPE_CHECKING:
    from PIL.Image import Image

#: Not TIFF: its library writes what it thinks of a damaged file to stderr.
FORMATS = ("PPM", "PNG", "BMP", "JPEG", "GIF")
#: What the decoders raise for a damaged file.
DAMAGE = (OSError, ValueError, SyntaxError, EOFError, LookupError, TypeError, OverflowError, struct.error, zlib.error)
#: Shades of 16 bits to one of 8.
DEEP_SHADES = 257


@dataclass(frozen=True, slots=True, eq=False)
class GreyImage:
    """An image, its first row the top.

    Attributes
    ----------
    grey
        0 black to 255 white, uint8, shape (n_rows, n_columns).
    is_clear
        Where the image is not wholly opaque, shape of `grey`.
    """

    grey: NDArray[np.uint8]
    is_clear: NDArray[np.bool_]


def read_image(path: Path) -> GreyImage:
    """An image in 256 shades of grey: colours by their luma, deeper shades rounded.

    Raises
    ------
    MapError
        If the file is missing, not permitted, no image, cut short or larger than `MAX_CELLS`.
    """
    from PIL import Image, UnidentifiedImageError

    check_regular(path)
    try:
        with (
            warnings.catch_warnings(action="ignore"),
            path.open("rb") as stream,
            Image.open(stream, formats=FORMATS) as image,
        ):
            _check_size(path, image)
            return _grey(path, image)
    except UnidentifiedImageError as error:
        raise MapError(path, f"is no image; allowed: {', '.join(FORMATS)}") from error
    except Image.DecompressionBombError as error:
        raise MapError(path, f"is too large; allowed: up to {MAX_CELLS} pixels") from error
    except DAMAGE as error:
        raise MapError(path, why_unreadable(error, "cannot be read as an image")) from error


def _check_size(path: Path, image: Image) -> None:
    width, height = image.size
    if width * height > MAX_CELLS:
        raise MapError(path, f"has {width} x {height} pixels; allowed: up to {MAX_CELLS}")


def _grey(path: Path, image: Image) -> GreyImage:
    if image.mode == "F":
        raise MapError(path, "holds fractions; allowed: shades of 8 or 16 bits, or colours")
    if image.mode.startswith("I"):
        deep = np.clip(np.asarray(image, np.float64), 0.0, 255.0 * DEEP_SHADES)
        grey = np.round(deep / DEEP_SHADES).astype(np.uint8)
    elif image.has_transparency_data:
        clear = image.convert("RGBA")
        return GreyImage(np.asarray(clear.convert("L")), np.asarray(clear.getchannel("A")) < 255)
    else:
        grey = np.asarray(image.convert("L"))
    return GreyImage(grey, np.zeros(grey.shape, np.bool_))
