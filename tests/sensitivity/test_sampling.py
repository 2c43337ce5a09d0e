import numpy as np
import pytest

from trackctl.errors import UsageError
from trackctl.sensitivity.sampling import latin_hypercube

LOWER, UPPER = (0.5, 2.0, -3.0), (4.0, 2.0, 3.0)


@pytest.mark.parametrize("count", [1, 2, 100, 129])
def test_any_count_of_points_in_the_box(count):
    points = latin_hypercube(LOWER, UPPER, count, seed=0)
    assert points.shape == (count, 3)
    assert np.all((points >= LOWER) & (points <= UPPER))
    assert np.all(points[:, 1] == 2.0)


def test_one_point_lies_in_each_stratum_of_every_axis():
    points = latin_hypercube((0.0, 0.0), (1.0, 1.0), 61, seed=3)
    for column in points.T:
        np.testing.assert_array_equal(np.sort(np.floor(61 * column)), np.arange(61))


def test_the_seed_decides():
    first = latin_hypercube(LOWER, UPPER, 50, seed=1)
    np.testing.assert_array_equal(first, latin_hypercube(LOWER, UPPER, 50, seed=np.random.default_rng(1)))
    assert np.all(first[:, 0] != latin_hypercube(LOWER, UPPER, 50, seed=2)[:, 0])


def test_no_points_are_refused():
    with pytest.raises(UsageError, match=r"--samples: 0 .* 1 or more"):
        latin_hypercube(LOWER, UPPER, 0, seed=0)
