"""What else a look-up table file tells, read in parts: cells beyond a limit, and the sensitivity analysis."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import h5py
import numpy as np

from trackctl.errors import LutFormatError
from trackctl.files import lut_format as layout
from trackctl.files import netcdf
from trackctl.files.lut_reader import COUNTED_CELLS, find_dataset, find_variable, opened_lut, read_axes
from trackctl.files.lut_sensitivity import INDEX_DIMENSIONS, INDEX_VARIABLES
from trackctl.lut.axes import Array
from trackctl.sensitivity.pawn import PawnIndex, Statistic


@dataclass(frozen=True, slots=True)
class StoredSensitivity:
    """The analysis that a table's steps were drawn from.

    Attributes
    ----------
    indices
        By output, then input, then statistic.
    attributes
        The steps, and the settings of the analysis.
    """

    indices: tuple[PawnIndex, ...]
    attributes: dict[str, object]


def count_cells_beyond(path: Path, names: Sequence[str], limit: float) -> int:
    """Number of cells where one of some variables exceeds a limit either way; constant memory.

    Parameters
    ----------
    path
        The table.
    names
        Of `VARIABLES`.
    limit
        In their unit.

    Raises
    ------
    LutFormatError
        If the file is no table.
    """
    with opened_lut(path) as file:
        axes = read_axes(path, file)
        datasets = [find_variable(path, file, name, axes) for name in names]
        return sum(
            int(np.count_nonzero(np.any([np.abs(part) > limit for part in parts], axis=0)))
            for parts in zip(*map(parts_of, datasets), strict=True)
        )


def parts_of(dataset: h5py.Dataset) -> Iterator[Array]:
    """A variable in parts of about `COUNTED_CELLS` cells, whole columns each."""
    slopes, velocities, curvatures, headings = dataset.shape
    step = max(1, COUNTED_CELLS // (velocities * headings))
    for slope, start in product(range(slopes), range(0, curvatures, step)):
        yield dataset[slope, :, start : start + step]


def read_sensitivity(path: Path) -> StoredSensitivity | None:
    """The sensitivity analysis in a table, None where its steps come from elsewhere; errors as above."""
    with opened_lut(path) as file:
        group = netcdf.present(file, layout.SENSITIVITY)
        if group is None:
            return None
        labels = [find_labels(path, group, name) for name in INDEX_DIMENSIONS]
        arrays = {name: find_dataset(path, group, name, "<f8")[()] for name in INDEX_VARIABLES}
        shape = tuple(len(texts) for texts in labels)
        for name, array in arrays.items():
            if array.shape != shape:
                raise LutFormatError(path, f"{layout.SENSITIVITY}/{name}: shape {array.shape}; the labels have {shape}")
        places = zip(np.ndindex(*shape), product(*labels), strict=True)
        indices = [
            PawnIndex(output, name, Statistic(statistic), *(float(array[place]) for array in arrays.values()))
            for place, (output, name, statistic) in places
        ]
        return StoredSensitivity(tuple(indices), netcdf.plain_attributes(group))


def find_labels(path: Path, group: h5py.Group, name: str) -> list[str]:
    """The texts of a coordinate of the analysis."""
    dataset = netcdf.present(group, name)
    if not isinstance(dataset, h5py.Dataset) or dataset.ndim != 1 or not h5py.check_string_dtype(dataset.dtype):
        raise LutFormatError(path, f"{layout.SENSITIVITY}/{name}: is missing or no list of texts")
    return [str(text) for text in dataset.asstr()]
