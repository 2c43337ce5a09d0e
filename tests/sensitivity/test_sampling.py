import numpy as np
import pytest

from trackctl.errors import UsageError
from trackctl.sensitivity.sampling import sobol_sample

LOWER, UPPER = (0.5, 2.0, -3.0), (4.0, 2.0, 3.0)


@pytest.mark.parametrize("count", [1, 2, 100, 129])
def test_any_count_of_points_in_the_box(count):
    points = sobol_sample(LOWER, UPPER, count, seed=0)
    assert points.shape == (count, 3)
    assert np.all((points >= LOWER) & (points <= UPPER))
    assert np.all(points[:, 1] == 2.0)


def test_a_power_of_two_puts_one_point_in_each_stratum_of_every_axis():
    points = sobol_sample((0.0, 0.0), (1.0, 1.0), 64, seed=3)
    for column in points.T:
        np.testing.assert_array_equal(np.sort(np.floor(64 * column)), np.arange(64))


def test_the_seed_decides():
    first = sobol_sample(LOWER, UPPER, 50, seed=1)
    np.testing.assert_array_equal(first, sobol_sample(LOWER, UPPER, 50, seed=np.random.default_rng(1)))
    assert np.all(first[:, 0] != sobol_sample(LOWER, UPPER, 50, seed=2)[:, 0])


def test_no_points_are_refused():
    with pytest.raises(UsageError, match=r"--samples: 0 .* 1 or more"):
        sobol_sample(LOWER, UPPER, 0, seed=0)
