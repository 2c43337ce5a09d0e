"""Polynomials for exp, sin and cos against the standard library's functions."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from trackctl.mechanics.elementary_functions import (
    LARGEST_EXPONENT,
    LARGEST_HALF_ANGLE,
    cosine,
    decay,
    monomials,
    sinc,
)

# What `decay` promises: six squarings make 64 times a rounding error of 1e-16.
DECAY_ERROR = 1e-14
# Rounding of nine terms: the first one left out, of order (1.6^2/4)^9 / 18!, is below 1e-17.
ROTATION_ERROR = 3e-15


def test_decay_is_the_exponential() -> None:
    exponents = np.concatenate(([0.0], np.geomspace(1e-300, LARGEST_EXPONENT, 2000)))
    assert max(abs(decay(z) - math.exp(-z)) for z in exponents.tolist()) < DECAY_ERROR


@pytest.mark.parametrize("exponent", [LARGEST_EXPONENT, 41.0, 1e10, math.inf])
def test_decay_stays_below_rounding_beyond_its_range(exponent: float) -> None:
    assert 0.0 <= decay(exponent) < 1e-17


def test_decay_falls_nowhere_steeper_than_the_exponential() -> None:
    exponents = np.linspace(0.0, 45.0, 5001)
    values = np.array([decay(z) for z in exponents.tolist()])
    slopes = np.diff(values) / np.diff(exponents)
    assert slopes.max() <= 2 * DECAY_ERROR / 0.009
    assert slopes.min() >= -1.0


@pytest.mark.parametrize(("approximation", "function"), [(sinc, lambda a: math.sin(a) / a), (cosine, math.cos)])
def test_rotation_polynomials_are_sine_and_cosine(
    approximation: Callable[[float], float], function: Callable[[float], float]
) -> None:
    angles = np.linspace(1e-8, LARGEST_HALF_ANGLE, 2000).tolist()
    assert max(abs(approximation(a * a) - function(a)) for a in angles) < ROTATION_ERROR


def test_rotation_by_nothing_changes_nothing() -> None:
    assert sinc(0.0) == pytest.approx(1.0, abs=ROTATION_ERROR)
    assert cosine(0.0) == pytest.approx(1.0, abs=ROTATION_ERROR)


def test_fit_gains_digits_with_its_degree() -> None:
    z = np.linspace(0.0, 1.0, 201)
    errors = [
        np.abs(np.polynomial.polynomial.polyval(z, monomials(np.exp, 1.0, n)) - np.exp(z)).max() for n in range(2, 9)
    ]
    # Chebyshev coefficients of exp on [0, 1] fall as (1/4)^n / n!: by more than 1/8 a degree from the second on.
    assert all(later < earlier / 8.0 for earlier, later in pairwise(errors))
