"""The sensitivity analysis inside a look-up table file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import h5py
import numpy as np

from trackctl.files import netcdf
from trackctl.files.lut_format import COORDINATES
from trackctl.lut.axes import Array

if TYPE_CHECKING:
    from trackctl.sensitivity.pawn import PawnIndex

INDEX_DIMENSIONS = ("output", "input", "statistic")
#: Numbers of a `PawnIndex`, with their long names.
INDEX_VARIABLES = {
    "index": "PAWN sensitivity index",
    "ci_low": "lower end of the confidence interval",
    "ci_high": "upper end of the confidence interval",
    "dummy": "threshold below which an input cannot be told from one without influence",
}


def add_sensitivity(
    group: h5py.Group, indices: Sequence[PawnIndex], sample_names: Sequence[str], samples: Array
) -> None:
    """Add indices over (output, input, statistic) and samples over (sample, quantity) to an empty group.

    Parameters
    ----------
    group
        Where to.
    indices
        One per output, input and statistic.
    sample_names
        The columns of `samples`.
    samples : ndarray, shape (n_samples, n_names)
        In SI units.
    """
    labels = {
        dimension: list(dict.fromkeys(str(getattr(index, dimension)) for index in indices))
        for dimension in INDEX_DIMENSIONS
    }
    coordinates = labels | {"quantity": list(sample_names)}
    for number, (name, values) in enumerate(coordinates.items(), start=len(COORDINATES)):
        netcdf.add_coordinate(group, name, values, number)
    netcdf.add_bare_dimension(group, "sample", len(samples), len(COORDINATES) + len(coordinates))
    for name, long_name in INDEX_VARIABLES.items():
        dataset = group.create_dataset(name, data=index_array(indices, name, labels))
        netcdf.attach_dimensions(dataset, INDEX_DIMENSIONS)
        netcdf.set_attributes(dataset, {"units": "1", "long_name": long_name})
    dataset = group.create_dataset("samples", data=np.asarray(samples, dtype="<f8"))
    netcdf.attach_dimensions(dataset, ("sample", "quantity"))
    netcdf.set_attributes(dataset, {"long_name": "sampled inputs and their outputs, in SI units"})


def index_array(indices: Sequence[PawnIndex], name: str, labels: dict[str, list[str]]) -> Array:
    """One number of all indices, over the labels; NaN where a combination is missing."""
    array = np.full([len(texts) for texts in labels.values()], np.nan)
    for index in indices:
        place = tuple(texts.index(str(getattr(index, dimension))) for dimension, texts in labels.items())
        array[place] = getattr(index, name)
    return array
