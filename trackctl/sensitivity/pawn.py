"""PAWN: how much each input moves the whole distribution of each output."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import product

import numpy as np

from trackctl.errors import UsageError
from trackctl.sensitivity.resampling import bootstrap_distances, dummy_distances, sample_distances
from trackctl.sensitivity.slices import Array, SortedOutput, slice_labels

# Chance alone keeps slices of 10 rows some 0.26 apart; with fewer there is nothing to tell from it.
ROWS_PER_SLICE = 10


class Statistic(StrEnum):
    """What is made of the distances of an input's slices."""

    MEDIAN = "median"
    MAX = "max"

    def over_slices(self, distances: Array) -> Array:
        """One number per row of the last axis, empty slices (NaN) left out."""
        summary = np.nanmedian if self is Statistic.MEDIAN else np.nanmax
        return np.asarray(summary(distances, axis=-1), dtype=np.float64)


@dataclass(frozen=True, slots=True)
class PawnIndex:
    """Sensitivity of one output to one input.

    Attributes
    ----------
    output, input
        Their names.
    statistic
        Median (how much the input matters over most of its range) or maximum (whether it matters anywhere).
    index
        Of the Kolmogorov-Smirnov distances of the slices, in [0, 1].
    ci_low, ci_high
        Ends of the bootstrap confidence interval.
    dummy
        What an input without influence stays below with the same confidence.
    """

    output: str
    input: str
    statistic: Statistic
    index: float
    ci_low: float
    ci_high: float
    dummy: float

    @property
    def is_influential(self) -> bool:
        """Whether the index stands above its dummy threshold."""
        return self.index > self.dummy


@dataclass(frozen=True, slots=True)
class PawnResult:
    """Indices of all outputs and inputs, and the sample they come from.

    Attributes
    ----------
    indices
        By output, then input, then statistic.
    rows
        Rows that were used.
    dropped_share
        Share of the given rows that held a NaN and were left out.
    """

    indices: tuple[PawnIndex, ...]
    rows: int
    dropped_share: float


def pawn_indices(
    inputs: Array,
    outputs: Array,
    input_names: Sequence[str],
    output_names: Sequence[str],
    *,
    slices: int = 10,
    resamples: int = 1000,
    confidence: float = 0.95,
    seed: int | np.random.Generator = 0,
) -> PawnResult:
    """PAWN indices of given data, with confidence intervals and the dummy threshold.

    The index of an input is the median or maximum, over slices of its range, of the Kolmogorov-Smirnov
    distance between the output in the slice and the output of the whole sample [1]_. It depends only on the
    order of inputs and outputs. Chance alone keeps the distances of a finite sample above zero, most of all
    the maximum.

    The interval tells how the index scatters between samples of this size: percentiles of the index over
    resampled rows, shifted to have their mean at the index, as resampling adds the same upward bias once
    more; without the shift the interval of a weak input would lie wholly above its index.

    The dummy threshold is the `confidence` quantile of the same statistic for a dummy input [2]_, one with
    slices of the same sizes dealt out at random: an input at or below it cannot be told from one without
    influence.

    Parameters
    ----------
    inputs : ndarray, shape (n, inputs)
        Sampled inputs, any units.
    outputs : ndarray, shape (n, outputs)
        Their outputs, any units; a row with a NaN anywhere is left out, so that the indices describe the part
        of the sample that has an answer.
    input_names, output_names
        One name per column.
    slices
        Slices of equal count per input, at least 2.
    resamples
        Bootstrap resamples, and dummies drawn, at least 1.
    confidence
        Level of the interval and of the dummy threshold, in (0, 1).
    seed
        Seed or generator of the resamples and dummies.

    Returns
    -------
    PawnResult

    Raises
    ------
    UsageError
        If a setting is out of range, or fewer than 10 rows per slice are left.

    References
    ----------
    .. [1] F. Pianosi, T. Wagener, "Distribution-based sensitivity analysis from a generic input-output
       sample", Environ. Model. Softw. 108 (2018), doi:10.1016/j.envsoft.2018.07.019.
    .. [2] F. Khorashadi Zadeh et al., "Comparison of variance-based and moment-independent global sensitivity
       analysis approaches by application to the SWAT model", Environ. Model. Softw. 91 (2017),
       doi:10.1016/j.envsoft.2017.02.001.
    """
    answered = ~(np.isnan(inputs).any(axis=1) | np.isnan(outputs).any(axis=1))
    rows = int(np.count_nonzero(answered))
    check_settings(slices, resamples, confidence, rows)
    labels = slice_labels(inputs[answered], slices)
    sorted_outputs = tuple(SortedOutput.of(output) for output in outputs[answered].T)
    generator = np.random.default_rng(seed)
    found = sample_distances(labels, sorted_outputs, slices)
    replicates = bootstrap_distances(labels, sorted_outputs, slices, resamples, generator)
    dummies = dummy_distances(labels, sorted_outputs, slices, resamples, generator)
    columns = {s: index_columns(s, found, replicates, dummies, confidence) for s in Statistic}
    indices = tuple(
        PawnIndex(y_name, x_name, s, *(float(column[y, x]) for column in columns[s]))
        for (y, y_name), (x, x_name), s in product(enumerate(output_names), enumerate(input_names), Statistic)
    )
    return PawnResult(indices, rows, (len(inputs) - rows) / len(inputs))


def check_settings(slices: int, resamples: int, confidence: float, rows: int) -> None:
    """Refuse settings out of range and samples too small for their slices."""
    if slices < 2:
        raise UsageError("--slices", slices, "2 or more")
    if resamples < 1:
        raise UsageError("--resamples", resamples, "1 or more")
    if not 0.0 < confidence < 1.0:
        raise UsageError("--confidence", confidence, "a share between 0 and 1, ends excluded")
    if rows < ROWS_PER_SLICE * slices:
        allowed = f"at least {ROWS_PER_SLICE * slices}, {ROWS_PER_SLICE} for each of {slices} slices"
        raise UsageError("--samples", f"{rows} with an answer", allowed)


def index_columns(
    statistic: Statistic, found: Array, replicates: Array, dummies: Array, confidence: float
) -> tuple[Array, Array, Array, Array]:
    """Index, both ends of its interval, and dummy threshold, each of shape (outputs, inputs)."""
    index = statistic.over_slices(found)
    low, high = centred_interval(index, statistic.over_slices(replicates), confidence)
    return index, low, high, np.quantile(statistic.over_slices(dummies), confidence, axis=0)


def centred_interval(index: Array, replicates: Array, confidence: float) -> tuple[Array, Array]:
    """Percentile interval of the replicates (first axis), shifted so that their mean is the index."""
    tail = 0.5 * (1.0 - confidence)
    shift = index - replicates.mean(axis=0)
    low, high = np.clip(np.quantile(replicates, (tail, 1.0 - tail), axis=0) + shift, 0.0, 1.0)
    return low, high
