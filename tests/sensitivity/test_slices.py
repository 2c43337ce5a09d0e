import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import ks_2samp

from trackctl.sensitivity.slices import SortedOutput, slice_distances, slice_labels


def distances(labels, output, weights, slices):
    in_order = SortedOutput.of(output)
    return slice_distances(labels[in_order.order], in_order.tie_ends, weights[in_order.order], slices)


@pytest.mark.parametrize(("rows", "slices"), [(100, 10), (103, 10), (97, 8), (20, 2)])
def test_slices_have_equal_counts_and_hold_every_row(rows, slices):
    inputs = np.random.default_rng(0).normal(size=(rows, 3))
    labels = slice_labels(inputs, slices)
    for x, label in zip(inputs.T, labels.T, strict=True):
        counts = np.bincount(label, minlength=slices)
        assert counts.sum() == rows
        assert set(counts) <= {rows // slices, -(-rows // slices)}
        assert label[np.argmax(x)] == slices - 1
        assert np.all(np.diff(label[np.argsort(x)]) >= 0)


@given(st.lists(st.integers(0, 6), min_size=20, max_size=60))
def test_equal_values_share_a_slice(values):
    column = np.array(values, dtype=float)
    labels = slice_labels(column[:, None], 10)[:, 0]
    for value in values:
        assert np.unique(labels[column == value]).size == 1


def test_labels_depend_on_order_alone():
    inputs = np.random.default_rng(1).normal(size=(503, 2))
    np.testing.assert_array_equal(slice_labels(np.exp(inputs), 7), slice_labels(inputs, 7))


@pytest.mark.parametrize("levels", [3, 40, 10**9])
def test_distances_are_those_of_scipy_with_and_without_ties(levels):
    generator = np.random.default_rng(2)
    inputs = generator.random((400, 2))
    output = np.floor(levels * (inputs[:, 0] ** 2 + generator.random(400)))
    labels = slice_labels(inputs, 8)
    weights = generator.integers(0, 4, size=400)
    found = distances(labels, output, weights, 8)
    y, y_labels = np.repeat(output, weights), np.repeat(labels, weights, axis=0)
    expected = [[ks_2samp(y[column == s], y).statistic for s in range(8)] for column in y_labels.T]
    # A handful of roundings of numbers up to 1 in either way of counting.
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("slices", [2, 5, 10])
def test_a_monotone_output_has_the_distances_of_a_shifted_step(slices):
    """Right before slice i its CDF is 0 and the reference i/S, at its end 1 and (i + 1)/S."""
    x = np.random.default_rng(3).permutation(np.arange(slices * 30.0))
    labels = slice_labels(x[:, None], slices)
    i = np.arange(slices)
    expected = np.maximum(i / slices, 1.0 - (i + 1) / slices)
    for output in (np.exp(0.01 * x), -(x**3)):
        found = distances(labels, output, np.ones(x.size, dtype=np.int64), slices)[0]
        # One rounding of the quotient and two of the expected value.
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=3e-16)


def test_a_constant_output_is_at_distance_zero():
    labels = slice_labels(np.random.default_rng(4).random((49, 2)), 7)
    assert np.all(distances(labels, np.full(49, 0.1), np.ones(49, dtype=np.int64), 7) == 0.0)


def test_an_empty_slice_has_no_distance():
    labels = np.repeat([0, 2], 10)[:, None]
    found = distances(labels, np.arange(20.0), np.ones(20, dtype=np.int64), 3)
    np.testing.assert_array_equal(found, [[0.5, np.nan, 0.5]])
