import numpy as np
from scipy.interpolate import CubicHermiteSpline

from trackctl.simulation.path import hermite


def test_cubics_between_samples_are_those_of_scipy():
    stream = np.random.default_rng(0)
    place = np.cumsum(stream.uniform(0.01, 1.0, 40))
    values, slopes = stream.normal(size=(2, 40))
    at = np.concatenate((place, stream.uniform(place[0], place[-1], 500)))
    np.testing.assert_array_equal(hermite(place, values, slopes, at), CubicHermiteSpline(place, values, slopes)(at))
