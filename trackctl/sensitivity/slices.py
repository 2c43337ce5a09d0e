"""Slices of an input, and how far the output within each stands from the output as a whole."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


def slice_labels(inputs: Array, slices: int) -> Integers:
    """Slice that each row falls into, input by input.

    The sorted values of an input are cut into slices of equal count, to within one row. A slice is closed
    below and open above, the last one closed, so that every row is in one. Equal values are never parted:
    they belong to the slice of the last cut that they reach, and an input of few distinct values leaves some
    slices empty.

    Parameters
    ----------
    inputs : ndarray, shape (rows, inputs)
        Sampled inputs, any units; only their order counts.
    slices
        Number of slices.

    Returns
    -------
    ndarray, shape (rows, inputs)
        Labels from 0, ascending with the input.
    """
    rows = len(inputs)
    cuts = np.arange(1, slices) * rows // slices
    labels = np.empty(inputs.shape, dtype=np.int64)
    for column, x in enumerate(inputs.T):
        order = np.argsort(x)
        ascending = x[order]
        starts = np.searchsorted(ascending, ascending[cuts], side="left")
        labels[order, column] = np.repeat(np.arange(slices), np.diff(starts, prepend=0, append=rows))
    return labels


@dataclass(frozen=True, slots=True, eq=False)
class SortedOutput:
    """Order of one output, found once for all resamples.

    Attributes
    ----------
    order : ndarray, shape (rows,)
        Rows by ascending output.
    tie_ends : ndarray, shape (distinct values,)
        Where, in that order, each run of equal values ends (exclusive).
    """

    order: Integers
    tie_ends: Integers

    @classmethod
    def of(cls, output: Array) -> SortedOutput:
        """Sort an output, shape (rows,)."""
        order = np.argsort(output)
        ascending = output[order]
        ends_run = np.append(ascending[1:] != ascending[:-1], True)
        return cls(order, np.flatnonzero(ends_run) + 1)


@kernel
def count(counts: Integers, labels: Integers, weights: Integers, start: int, end: int) -> int:
    """Add the rows from `start` to `end` to the counts of their slices, and return their total weight."""
    total = 0
    for row in range(start, end):
        total += weights[row]
        for column in range(labels.shape[1]):
            counts[column, labels[row, column]] += weights[row]
    return total


@kernel
def slice_distances(labels: Integers, tie_ends: Integers, weights: Integers, slices: int) -> Array:
    """Kolmogorov-Smirnov distance between the output within each slice and the whole output.

    sup over y of abs(F_slice(y) - F(y)) [1]_, with slices in place of fixed values of the input [2]_, in one
    pass over the sorted output: between two rows of a slice F_slice stands still while F rises, so that the
    extremes lie right before and right after the rows of that slice.

    Parameters
    ----------
    labels : ndarray, shape (rows, inputs)
        Slice of each row, rows by ascending output.
    tie_ends : ndarray, shape (distinct values,)
        Where each run of equal outputs ends (exclusive); both CDFs jump there only.
    weights : ndarray, shape (rows,)
        How often each row counts, rows in the same order.
    slices
        Number of slices.

    Returns
    -------
    ndarray, shape (inputs, slices)
        In [0, 1]; NaN for an empty slice.

    References
    ----------
    .. [1] F. Pianosi, T. Wagener, "A simple and efficient method for global sensitivity analysis based on
       cumulative distribution functions", Environ. Model. Softw. 67 (2015),
       doi:10.1016/j.envsoft.2015.01.004.
    .. [2] F. Pianosi, T. Wagener, "Distribution-based sensitivity analysis from a generic input-output
       sample", Environ. Model. Softw. 108 (2018), doi:10.1016/j.envsoft.2018.07.019.
    """
    rows, inputs = labels.shape
    sizes, below, gaps = np.zeros((3, inputs, slices), dtype=np.int64)
    total = count(sizes, labels, weights, 0, rows)
    reached, start = 0, 0
    for end in tie_ends:
        for right_after in (False, True):
            if right_after:
                reached += count(below, labels, weights, start, end)
            for row in range(start, end):
                for column in range(inputs):
                    label = labels[row, column]
                    # F_slice - F over the common denominator: integers keep ties and constant outputs exact.
                    gap = abs(below[column, label] * total - reached * sizes[column, label])
                    gaps[column, label] = max(gaps[column, label], gap)
        start = end
    return gaps / (sizes * total)
