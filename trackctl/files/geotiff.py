"""Elevation grids in GeoTIFF, read by tifffile (the extra `geo`)."""

from __future__ import annotations

import logging
import math
import struct
import warnings
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from trackctl.errors import MapError, MissingLibraryError
from trackctl.files.height_grid import MAX_NODES, HeightGrid, check_size, known_heights
from trackctl.files.read_errors import why_unreadable
from trackctl.files.regular_file import check_regular

#: Tags of GeoTIFF 1.1 and, the last, of GDAL.
PIXEL_SCALE, TIE_POINT, TRANSFORMATION, KEY_DIRECTORY, NODATA = 33550, 33922, 34264, 34735, 42113
#: Keys of its directory, and values of them.
MODEL_TYPE, RASTER_TYPE, LINEAR_UNIT = 1024, 1025, 3076
GEOGRAPHIC, POINTS, METRE = 2, 2, 9001
#: What the decoders raise for a damaged file.
DAMAGE = (OSError, ValueError, LookupError, TypeError, ArithmeticError, AttributeError, EOFError, MemoryError,
          RuntimeError, struct.error, zlib.error)  # fmt: skip


def read_geotiff(path: Path) -> HeightGrid:
    """The first band of the first image.

    Raises
    ------
    MapError
        If the file is none, holds no single band of numbers, or lies askew or in another unit than metres or degrees.
    MissingLibraryError
        If tifffile is not installed.
    """
    try:
        import tifffile
    except ImportError as error:
        raise MissingLibraryError("tifffile", "reading GeoTIFF", "pip install 'trackctl[geo]'") from error
    check_regular(path)
    # What it has to say of a damaged file, the error says.
    logging.getLogger("tifffile").setLevel(logging.CRITICAL)
    try:
        with warnings.catch_warnings(action="ignore"), path.open("rb") as stream, tifffile.TiffFile(stream) as tiff:
            return _grid(path, tiff.pages[0])
    except (*DAMAGE, tifffile.TiffFileError) as error:
        raise MapError(path, why_unreadable(error, "cannot be read as a GeoTIFF")) from error


def _grid(path: Path, page: Any) -> HeightGrid:
    if page.samplesperpixel != 1 or page.dtype is None or page.dtype.kind not in "iuf" or page.imagedepth != 1:
        raise MapError(path, "is no image of one band of numbers; allowed: an elevation grid")
    check_size(path, page.imagelength, page.imagewidth)
    if math.prod(page.chunks) > MAX_NODES:
        raise MapError(path, f"is laid out in tiles of {page.chunks}; allowed: up to {MAX_NODES} heights each")
    tags = {code: page.tags[code].value for code in (PIXEL_SCALE, TIE_POINT, TRANSFORMATION, KEY_DIRECTORY, NODATA)
            if code in page.tags}  # fmt: skip
    keys = _directory(tags.get(KEY_DIRECTORY, ()))
    if keys.get(LINEAR_UNIT, METRE) != METRE:
        raise MapError(path, f"has lengths in unit {keys[LINEAR_UNIT]} of EPSG; allowed: metre (9001) or degrees")
    nodata = _nodata(path, tags.get(NODATA))
    spacing, corner = _place(path, tags, page.imagelength, is_points=keys.get(RASTER_TYPE) == POINTS)
    heights = known_heights(path, np.asarray(page.asarray()).reshape(page.imagelength, page.imagewidth), nodata)
    is_geographic = keys[MODEL_TYPE] == GEOGRAPHIC if MODEL_TYPE in keys else None
    return HeightGrid(heights, spacing, corner, is_geographic)


def _directory(values: tuple[int, ...]) -> dict[int, int]:
    """The keys whose value stands in the directory itself: a header of four numbers, then four for each key."""
    entries = (values[start : start + 4] for start in range(4, len(values) - 3, 4))
    return {key: value for key, place, _, value in entries if place == 0}


def _nodata(path: Path, text: Any) -> float | None:
    if text is None:
        return None
    try:
        return float(str(text).strip("\0 "))
    except ValueError as error:
        raise MapError(path, f"declares {text!r} as NODATA; allowed: a number") from error


def _place(
    path: Path, tags: dict[int, Any], n_rows: int, *, is_points: bool
) -> tuple[tuple[float, float] | None, tuple[float, float] | None]:
    """Spacing and lower left corner, where the file tells."""
    if TRANSFORMATION in tags:
        a, b, _, x, d, e, _, y = tags[TRANSFORMATION][:8]
        width, height = a, -e
        if b or d:
            raise MapError(path, "lies askew to its coordinates; allowed: north up")
    elif PIXEL_SCALE in tags and TIE_POINT in tags:
        width, height = tags[PIXEL_SCALE][:2]
        column, row, _, tie_x, tie_y = tags[TIE_POINT][:5]
        x, y = tie_x - column * width, tie_y + row * height
    else:
        return None, None
    if not (0.0 < width < np.inf and 0.0 < height < np.inf and abs(x) < np.inf and abs(y) < np.inf):
        raise MapError(path, f"has cells of {width:g} x {height:g} at ({x:g}, {y:g}); allowed: north up, above 0")
    # The tie is to a border of the first cell, or to its centre.
    shift = 0.5 if is_points else 0.0
    return (width, height), (x - shift * width, y - (n_rows - shift) * height)
