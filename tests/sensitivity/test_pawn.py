import numpy as np
import pytest
from scipy.stats import ks_2samp
from sensitivity_functions import G_COEFFICIENTS, ishigami, sobol_g

from trackctl.errors import UsageError
from trackctl.sensitivity.pawn import Statistic, pawn_indices
from trackctl.sensitivity.resampling import sample_distances
from trackctl.sensitivity.slices import SortedOutput, slice_labels

MEDIAN, MAX = Statistic


def analyse(inputs, *outputs, **settings):
    x_names = [f"x{i + 1}" for i in range(inputs.shape[1])]
    y_names = [f"y{i + 1}" for i in range(len(outputs))]
    return pawn_indices(inputs, np.column_stack(outputs), x_names, y_names, **{"resamples": 50, "seed": 0} | settings)


def unit_points(rows, columns, seed=0):
    return np.random.default_rng(seed).random((rows, columns))


def values(result, attribute="index"):
    return [getattr(found, attribute) for found in result.indices]


def test_an_output_that_is_one_input_has_the_closed_form_index():
    """Slices of a monotone output are at max(i/S, 1 - (i + 1)/S): 0.9 to 0.5 and back for S = 10."""
    x = unit_points(1000, 2)
    of_input, of_other = (analyse(x, np.exp(x[:, 0])).indices[i : i + 2] for i in (0, 2))
    # Two roundings of numbers below 1.
    assert [found.index for found in of_input] == pytest.approx([0.7, 0.9], abs=3e-16)
    assert all(found.is_influential for found in of_input)
    assert all(found.index < 0.3 for found in of_other)


def test_rows_come_by_output_then_input_then_statistic():
    x = unit_points(100, 2)
    found = analyse(x, x[:, 0], x[:, 1]).indices
    assert [(f.output, f.input, f.statistic) for f in found] == [
        (y, z, statistic) for y in ("y1", "y2") for z in ("x1", "x2") for statistic in Statistic
    ]


def test_outputs_share_the_sample_but_not_each_other():
    x = unit_points(300, 3)
    together = analyse(x, ishigami(x), np.round(x[:, 2], 1))
    apart = values(analyse(x, ishigami(x))) + values(analyse(x, np.round(x[:, 2], 1)))
    assert values(together) == apart


def test_monotone_transforms_change_nothing():
    x = unit_points(400, 3)
    assert analyse(np.exp(3.0 * x), ishigami(x) ** 3).indices == analyse(x, ishigami(x)).indices


def test_a_falling_transform_of_the_output_keeps_the_indices():
    x = unit_points(400, 3)
    assert values(analyse(x, -ishigami(x))) == values(analyse(x, ishigami(x)))


def test_the_order_of_rows_does_not_matter():
    x = unit_points(400, 3)
    shuffled = np.random.default_rng(5).permutation(x)
    assert values(analyse(shuffled, ishigami(shuffled))) == values(analyse(x, ishigami(x)))


def test_the_seed_decides():
    x = unit_points(400, 3)
    first = analyse(x, ishigami(x), seed=1)
    assert first == analyse(x, ishigami(x), seed=np.random.default_rng(1))
    other = analyse(x, ishigami(x), seed=2)
    assert values(other) == values(first)
    assert values(other, "ci_low") != values(first, "ci_low")
    assert values(other, "dummy") != values(first, "dummy")


def test_rows_without_an_answer_are_left_out_and_counted():
    x = unit_points(400, 3)
    y = ishigami(x)
    y[:40] = np.nan
    second = np.where(np.arange(400) < 390, x[:, 0], np.nan)
    result = analyse(x, y, second)
    assert result.indices == analyse(x[40:390], y[40:390], second[40:390]).indices
    assert (result.rows, result.dropped_share) == (350, 0.125)


def test_a_constant_output_is_moved_by_nothing():
    for found in analyse(unit_points(210, 2), np.full(210, 0.3)).indices:
        assert (found.index, found.ci_low, found.ci_high, found.dummy) == (0.0, 0.0, 0.0, 0.0)
        assert not found.is_influential


def test_inputs_and_outputs_of_few_values():
    generator = np.random.default_rng(6)
    x = np.column_stack([generator.integers(0, 2, 500), generator.integers(0, 4, 500)]).astype(float)
    y = np.round(x[:, 0] + 0.3 * x[:, 1] + generator.random(500), 1)
    expected = [[ks_2samp(y[z == level], y).statistic for level in np.unique(z)] for z in x.T]
    # A handful of roundings of numbers up to 1.
    assert values(analyse(x, y)) == pytest.approx(
        [statistic(d) for d in expected for statistic in (np.median, np.max)], abs=1e-15
    )


@pytest.mark.parametrize("statistic", Statistic)
def test_the_dummy_parts_the_inputs_that_matter_in_sobol_g(statistic):
    x = unit_points(4000, 8)
    found = [f for f in analyse(x, sobol_g(x), resamples=200).indices if f.statistic is statistic]
    matters = [f.is_influential for f in found]
    assert matters[:3] == [True, True, True]
    # The threshold lets one idle input in twenty through: at most 1 of 4 in 99 % of samples.
    assert sum(np.array(matters)[G_COEFFICIENTS == 99.0]) <= 1


def test_the_dummy_raises_the_promised_share_of_false_alarms():
    alarms = []
    for seed in range(300):
        x = unit_points(200, 1, seed)
        y = np.random.default_rng([seed, 1]).normal(size=200)
        alarms += [f.is_influential for f in analyse(x, y, resamples=200, seed=seed).indices]
    # 5 % +- four standard deviations of a share of 300 (the two statistics go together), and a little for
    # the scatter of the threshold itself, a quantile of 200.
    assert np.mean(alarms) == pytest.approx(0.05, abs=0.06)


def test_the_interval_covers_the_mean_over_samples():
    def index_of(seed):
        x = unit_points(500, 3, seed)
        labels, output = slice_labels(x, 10), (SortedOutput.of(ishigami(x)),)
        distances = sample_distances(labels, output, 10)[0]
        return np.stack([statistic.over_slices(distances) for statistic in Statistic], axis=1).ravel()

    expected = np.mean([index_of(seed) for seed in range(1000, 2000)], axis=0)
    hits = []
    for seed in range(120):
        x = unit_points(500, 3, seed)
        found = analyse(x, ishigami(x), resamples=200, seed=seed)
        assert all(f.ci_low <= f.index <= f.ci_high for f in found.indices)
        hits.append((values(found, "ci_low") <= expected) & (expected <= values(found, "ci_high")))
    # 95 % less four standard deviations of a share of 120 samples.
    assert np.all(np.mean(hits, axis=0) >= 0.87)


def test_a_higher_confidence_widens_the_interval_and_lifts_the_dummy():
    x = unit_points(400, 3)
    narrow, wide = (analyse(x, ishigami(x), confidence=level).indices for level in (0.8, 0.99))
    for one, other in zip(narrow, wide, strict=True):
        assert other.ci_high - other.ci_low > one.ci_high - one.ci_low
        assert other.dummy > one.dummy


def test_the_scatter_falls_with_the_root_of_the_sample_size():
    sizes = np.array([500, 1000, 2000, 4000, 8000])
    scatter = []
    for size in sizes:
        indices = []
        for seed in range(150):
            x = unit_points(size, 3, [seed, size])
            distances = sample_distances(slice_labels(x, 10), (SortedOutput.of(ishigami(x)),), 10)
            indices.append(MEDIAN.over_slices(distances)[0, :2])
        scatter.append(np.std(indices, axis=0))
    rates = np.polyfit(np.log(sizes), np.log(scatter), 1)[0]
    # A standard deviation of 150 samples is known to 6 %, the rate over a factor 16 thus to 0.03.
    np.testing.assert_allclose(rates, -0.5, atol=0.15)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"slices": 1}, "--slices: 1 .* 2 or more"),
        ({"resamples": 0}, "--resamples: 0 .* 1 or more"),
        ({"confidence": 1.0}, "--confidence: 1.0 .* between 0 and 1"),
        ({"slices": 21}, "--samples: 200 with an answer .* at least 210"),
    ],
)
def test_settings_out_of_range_are_refused(settings, message):
    x = unit_points(200, 1)
    with pytest.raises(UsageError, match=message):
        analyse(x, x[:, 0], **settings)


def test_a_sample_without_answers_is_refused():
    x = unit_points(200, 1)
    with pytest.raises(UsageError, match="--samples: 0 with an answer"):
        analyse(x, np.full(200, np.nan))
