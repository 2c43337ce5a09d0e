"""Slice distances under resampling: of the sample itself, and of a dummy input."""

from __future__ import annotations

import numpy as np

from trackctl.sensitivity.slices import Array, Integers, SortedOutput, slice_distances

Outputs = tuple[SortedOutput, ...]


def sample_distances(labels: Integers, outputs: Outputs, slices: int) -> Array:
    """Slice distances of the sample as it is, shape (outputs, inputs, slices)."""
    once = np.ones(len(labels), dtype=np.int64)
    return np.stack([slice_distances(labels[y.order], y.tie_ends, once, slices) for y in outputs])


def bootstrap_distances(
    labels: Integers, outputs: Outputs, slices: int, resamples: int, generator: np.random.Generator
) -> Array:
    """Slice distances of rows drawn with replacement, inputs and outputs together.

    A resample is a count per row, so that nothing is sorted anew, and the slices stay where the whole sample
    cut them.

    Parameters
    ----------
    labels : ndarray, shape (rows, inputs)
        Slice of each row.
    outputs
        The sorted outputs.
    slices
        Number of slices.
    resamples
        Number of resamples.
    generator
        Draws the rows.

    Returns
    -------
    ndarray, shape (resamples, outputs, inputs, slices)
        NaN where a resample leaves a slice empty.
    """
    rows, inputs = labels.shape
    sorted_labels = [labels[y.order] for y in outputs]
    distances = np.empty((resamples, len(outputs), inputs, slices))
    for resample in distances:
        drawn = np.bincount(generator.integers(rows, size=rows), minlength=rows)
        for y, y_labels, found in zip(outputs, sorted_labels, resample, strict=True):
            found[:] = slice_distances(y_labels, y.tie_ends, drawn[y.order], slices)
    return distances


def dummy_distances(
    labels: Integers, outputs: Outputs, slices: int, resamples: int, generator: np.random.Generator
) -> Array:
    """Slice distances of inputs that have nothing to do with the outputs.

    The dummy of an input has slices of the same sizes with rows dealt out at random, so that its distances
    are those of chance alone, exactly. Inputs with equal slice sizes share their dummy.

    Parameters
    ----------
    labels : ndarray, shape (rows, inputs)
        Slice of each row.
    outputs
        The sorted outputs.
    slices
        Number of slices.
    resamples
        Number of dummies drawn.
    generator
        Deals out the rows.

    Returns
    -------
    ndarray, shape (resamples, outputs, inputs, slices)
        NaN for empty slices.
    """
    dummies, dummy_of_input = np.unique(np.sort(labels, axis=0), axis=1, return_inverse=True)
    once = np.ones(len(labels), dtype=np.int64)
    distances = np.empty((resamples, len(outputs), dummies.shape[1], slices))
    for resample in distances:
        dealt = generator.permutation(dummies)
        for y, found in zip(outputs, resample, strict=True):
            found[:] = slice_distances(dealt, y.tie_ends, once, slices)
    return distances[:, :, dummy_of_input.ravel()]
