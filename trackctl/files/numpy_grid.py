"""Elevation grids of NumPy: one array (`.npy`), or one with the place it has (`.npz`)."""

from __future__ import annotations

import io
import math
import struct
import tokenize
import warnings
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from trackctl.errors import MapError
from trackctl.files.height_grid import MAX_NODES, HeightGrid, check_size, known_heights
from trackctl.files.regular_file import read_bytes

Array = NDArray[np.float64]
Arrays = Mapping[str, NDArray[np.generic]]

LARGEST = 16 * MAX_NODES  # [bytes]
MOST_ARRAYS = 16
HEIGHTS = ("elevation", "height", "heights", "z", "dem")
#: What zipfile and NumPy raise for a damaged file.
DAMAGE = (
    OSError, ValueError, LookupError, EOFError, NotImplementedError, RuntimeError, zipfile.BadZipFile, zlib.error,
    struct.error,
)  # fmt: skip
#: Nodes may be off even spacing by this part of it.
UNEVEN = 1e-3


def read_npy(path: Path) -> HeightGrid:
    """Heights without a place, the first row the top.

    Raises
    ------
    MapError
        If the file is no such array.
    """
    heights = _array(path, io.BytesIO(read_bytes(path, LARGEST)))
    return _grid(path, heights, {})


def read_npz(path: Path) -> HeightGrid:
    """Heights named `elevation`, `height`, `heights`, `z` or `dem`, or else the only array with rows and columns.

    Their place is told by arrays `x`, `y` of the columns' and rows' centres; or by `dx`, `dy` (or `resolution`) and
    `xmin`, `ymin`, `xmax`, `ymax` of the outer borders, the first row being the top. `nodata` marks unknown heights.

    Raises
    ------
    MapError
        If the file is none, or says one thing twice in different ways.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(read_bytes(path, LARGEST))) as archive:
            names = [name for name in archive.namelist() if name.endswith(".npy")]
            if len(names) > MOST_ARRAYS:
                raise MapError(path, f"holds {len(names)} arrays; allowed: up to {MOST_ARRAYS}")
            arrays = {name.removesuffix(".npy"): _member(path, archive, name) for name in names}
    except DAMAGE as error:
        raise MapError(path, f"is no .npz file: {error}") from error
    tables = [name for name, array in arrays.items() if array.ndim == 2]
    chosen = [name for name in HEIGHTS if name in tables] or tables
    if len(chosen) != 1:
        raise MapError(path, f"holds {', '.join(arrays) or 'nothing'}; allowed: one array of heights, elevation")
    return _grid(path, arrays[chosen[0]], arrays)


def _member(path: Path, archive: zipfile.ZipFile, name: str) -> NDArray[np.generic]:
    with archive.open(name) as stream:
        return _array(path, stream)


def _array(path: Path, stream: IO[bytes]) -> NDArray[np.generic]:
    """An array of numbers, its size looked at before room is made for it."""
    try:
        with warnings.catch_warnings(action="ignore"):
            version = npy.read_magic(stream)
            read_header = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
            shape, is_fortran, kind = read_header(stream)
    except (*DAMAGE, SyntaxError, TypeError, RecursionError, tokenize.TokenError) as error:
        raise MapError(path, "holds what is no NumPy array") from error
    if kind.kind not in "iuf" or kind.itemsize > 8 or len(shape) > 2:
        raise MapError(path, f"holds an array of {kind} and shape {shape}; allowed: numbers in rows and columns")
    count = math.prod(shape)
    if min(shape, default=0) < 0 or count > MAX_NODES:
        raise MapError(path, f"holds an array of shape {shape}; allowed: up to {MAX_NODES} numbers")
    content = stream.read(count * kind.itemsize)
    if len(content) < count * kind.itemsize:
        raise MapError(path, "is cut short; allowed: a whole file")
    return np.frombuffer(content, kind).reshape(shape, order="F" if is_fortran else "C")


def _grid(path: Path, heights: NDArray[np.generic], arrays: Arrays) -> HeightGrid:
    if heights.ndim != 2:
        raise MapError(path, f"holds an array of shape {heights.shape}; allowed: rows and columns of heights")
    n_rows, n_columns = heights.shape
    check_size(path, n_rows, n_columns)
    known = known_heights(path, heights, _scalar(path, arrays, "nodata"))
    columns, rows = _axis(path, arrays, "x", n_columns), _axis(path, arrays, "y", n_rows)
    known = known[:: -1 if rows.ascends else 1, :: 1 if columns.ascends else -1]
    spacing = None if columns.spacing is None or rows.spacing is None else (columns.spacing, rows.spacing)
    corner = None if columns.low is None or rows.low is None else (columns.low, rows.low)
    return HeightGrid(known, spacing, corner)


@dataclass(frozen=True, slots=True)
class _Axis:
    """What a file tells of one axis: width and lower border of its cells, and which way it counts."""

    spacing: float | None
    low: float | None
    ascends: bool


def _axis(path: Path, arrays: Arrays, name: str, count: int) -> _Axis:
    if name in arrays and arrays[name].ndim == 1:
        return _centres(path, name, arrays[name].astype(np.float64), count)
    width = _scalar(path, arrays, f"d{name}" if f"d{name}" in arrays else "resolution")
    if width is not None and not 0.0 < abs(width) < math.inf:
        raise MapError(path, f"d{name}: {width:g} is not allowed; allowed: above 0")
    width = None if width is None else abs(width)
    low, high = (_scalar(path, arrays, f"{name}{end}") for end in ("min", "max"))
    if low is not None and high is not None:
        width, low = _between(path, name, (min(low, high), max(low, high)), count, width)
    return _Axis(width, low, ascends=name == "x")


def _between(path: Path, name: str, ends: tuple[float, float], count: int, width: float | None) -> tuple[float, float]:
    """Width and lower border of cells from end to end: outer borders, or where `width` says so outer centres."""
    span = ends[1] - ends[0]
    if not 0.0 < span < math.inf:
        raise MapError(path, f"{name}min, {name}max: {ends} are not allowed; allowed: two finite numbers")
    if width is None or math.isclose(span, count * width, rel_tol=UNEVEN):
        return span / count, ends[0]
    if math.isclose(span, (count - 1) * width, rel_tol=UNEVEN):
        return width, ends[0] - 0.5 * width
    raise MapError(path, f"{name}min and {name}max lie {span:g} apart, which {count} times {width:g} is not")


def _centres(path: Path, name: str, centres: Array, count: int) -> _Axis:
    step = (centres[-1] - centres[0]) / (count - 1) if centres.size == count else math.nan
    if not 0.0 < abs(step) < math.inf or np.abs(np.diff(centres) - step).max() > UNEVEN * abs(step):
        raise MapError(path, f"{name}: is no axis of the heights; allowed: {count} numbers evenly apart")
    return _Axis(float(abs(step)), float(centres.min() - 0.5 * abs(step)), ascends=bool(step > 0.0))


def _scalar(path: Path, arrays: Arrays, name: str) -> float | None:
    if name not in arrays:
        return None
    if arrays[name].size != 1:
        raise MapError(path, f"{name}: holds {arrays[name].size} numbers; allowed: one")
    return float(arrays[name].astype(np.float64).item())
