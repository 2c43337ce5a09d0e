import numpy as np
from scipy.stats import ks_2samp
from sensitivity_functions import ishigami

from trackctl.sensitivity.resampling import bootstrap_distances, dummy_distances, sample_distances
from trackctl.sensitivity.slices import SortedOutput, slice_labels

SLICES = 5


def test_a_resample_is_the_drawn_rows_in_the_slices_of_the_whole_sample():
    inputs = np.random.default_rng(0).random((200, 3))
    outputs = np.stack([ishigami(inputs), np.round(inputs[:, 1], 1)])
    labels = slice_labels(inputs, SLICES)
    found = bootstrap_distances(labels, tuple(map(SortedOutput.of, outputs)), SLICES, 3, np.random.default_rng(7))
    draws = np.random.default_rng(7)
    for resample in found:
        rows = draws.integers(200, size=200)
        expected = [
            [[ks_2samp(y[rows][x[rows] == s], y[rows]).statistic for s in range(SLICES)] for x in labels.T]
            for y in outputs
        ]
        # A handful of roundings of numbers up to 1.
        np.testing.assert_allclose(resample, expected, rtol=0.0, atol=1e-15)


def test_dummies_behave_like_an_input_that_has_nothing_to_do_with_the_output():
    generator = np.random.default_rng(1)
    output = (SortedOutput.of(np.round(generator.normal(size=150), 1)),)
    labels = slice_labels(generator.random((150, 1)), SLICES)
    dummies = dummy_distances(labels, output, SLICES, 2000, generator).mean(axis=-1).ravel()
    independent = np.array(
        [sample_distances(slice_labels(generator.random((150, 1)), SLICES), output, SLICES).mean() for _ in range(2000)]
    )
    standard_error = np.hypot(dummies.std(), independent.std()) / np.sqrt(2000)
    assert abs(dummies.mean() - independent.mean()) < 4.0 * standard_error


def test_inputs_share_a_dummy_exactly_when_their_slices_have_the_same_sizes():
    generator = np.random.default_rng(2)
    inputs = np.column_stack([generator.random((100, 2)), np.repeat([0.0, 1.0], 50)])
    output = (SortedOutput.of(generator.random(100)),)
    dummies = dummy_distances(slice_labels(inputs, SLICES), output, SLICES, 50, generator)[:, 0]
    np.testing.assert_array_equal(dummies[:, 0], dummies[:, 1])
    # Two slices of 50 rows scatter less than five of 20.
    assert np.nanmean(dummies[:, 2]) < np.nanmean(dummies[:, 0])
