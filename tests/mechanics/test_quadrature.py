"""Gauss-Legendre rules, and the choice among them by what is known of the integrand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from trackctl.mechanics.quadrature import COUNTS, axis_through, choose, rules

Array = NDArray[np.float64]
RULE = rules()
# exp(-16), what a rule must leave of an error of order 1 to be chosen.
PROMISED = 1.2e-7


def row(index: int) -> tuple[Array, Array]:
    count = RULE.counts[index]
    return RULE.nodes[index, :count], RULE.weights[index, :count]


@pytest.mark.parametrize("index", range(len(COUNTS)))
def test_a_rule_of_n_nodes_is_exact_to_degree_2n_minus_1(index: int) -> None:
    nodes, weights = row(index)
    assert len(nodes) == COUNTS[index]
    for degree in range(0, 2 * len(nodes), 5):
        assert weights @ nodes**degree == pytest.approx(1.0 / (degree + 1), rel=1e-12)
    assert ((nodes > 0.0) & (nodes < 1.0)).all()


def test_rules_are_padded_with_zeros() -> None:
    for index, count in enumerate(COUNTS):
        assert not RULE.nodes[index, count:].any()
        assert not RULE.weights[index, count:].any()


def test_a_single_count_is_used_everywhere() -> None:
    single = rules((48,))
    assert single.counts.tolist() == [48]
    for axis, layer in ((1.0, 1e9), (math.inf, 0.0), (math.nan, math.nan)):
        assert choose(single, axis, layer) == 0


def test_ellipse_through_its_own_end_is_the_stretch() -> None:
    assert axis_through(0.0, 0.0, -2.0, 2.0) == 1.0
    assert axis_through(2.0, 0.0, -2.0, 2.0) == pytest.approx(1.0, rel=1e-15)


def test_ellipse_has_the_textbooks_half_axes() -> None:
    # Foci at -1 and 1, half axes a = 5/4 and b = 3/4: through (a, 0), (0, b) and a point between.
    for angle in (0.0, 0.7, math.pi / 2):
        real, imaginary = 1.25 * math.cos(angle), 0.75 * math.sin(angle)
        assert axis_through(real, imaginary, -1.0, 1.0) == pytest.approx(1.25, rel=1e-14)
    # The same, moved, stretched and run through backwards.
    assert axis_through(7.0, 4 * 0.75, 11.0, 3.0) == pytest.approx(1.25, rel=1e-14)


def test_harder_integrands_get_more_nodes_and_the_hardest_the_most() -> None:
    axes = np.geomspace(1.0, 100.0, 400)
    by_axis = [choose(RULE, a, 0.0) for a in axes.tolist()]
    assert by_axis == sorted(by_axis, reverse=True)
    layers = np.geomspace(0.1, 1000.0, 400)
    by_layer = [choose(RULE, math.inf, x) for x in layers.tolist()]
    assert by_layer == sorted(by_layer)
    assert {*by_axis} == {*by_layer} == {*range(len(COUNTS))}
    assert choose(RULE, math.nan, 0.0) == choose(RULE, math.inf, math.nan) == len(COUNTS) - 1


@pytest.mark.parametrize("pole", [complex(0.5, 0.3), complex(0.1, 0.1), complex(-0.05, 0.02)])
def test_error_falls_at_the_rate_of_the_ellipse_through_the_singularity(pole: complex) -> None:
    axis = axis_through(pole.real, pole.imag, 0.0, 1.0)
    rho = axis + math.sqrt(axis * axis - 1.0)
    # x -> 1/((x - a)^2 + b^2) has its poles at a +- i b.
    exact = (math.atan((1 - pole.real) / pole.imag) + math.atan(pole.real / pole.imag)) / pole.imag
    errors = []
    counts = np.arange(4, 36, 2)
    for count in counts.tolist():
        t, w = np.polynomial.legendre.leggauss(count)
        x = 0.5 * (t + 1.0)
        errors.append(abs(0.5 * w @ (1.0 / ((x - pole.real) ** 2 + pole.imag**2)) - exact))
    converging = np.array(errors) > 1e-12 * exact
    slope = np.polyfit(counts[converging], np.log(np.array(errors)[converging]), 1)[0]
    # The error swings about its bound with the angle of the pole, by less than a tenth of the rate.
    assert slope == pytest.approx(-2.0 * math.log(rho), rel=0.1)


@pytest.mark.parametrize("index", range(len(COUNTS)))
def test_a_chosen_rule_keeps_its_promise_at_a_pole(index: int) -> None:
    half_height = math.sqrt(RULE.least_axis[index] ** 2 - 1.0)
    pole = 0.5 * half_height * 1.001
    assert choose(RULE, axis_through(0.5, pole, 0.0, 1.0), 0.0) <= index
    nodes, weights = row(index)
    exact = 2.0 * math.atan(0.5 / pole) / pole
    found = weights @ (1.0 / ((nodes - 0.5) ** 2 + pole**2))
    # The residue at a pole of first order, the worst there is, multiplies the error by 2 pi.
    assert found == pytest.approx(exact, rel=2 * math.pi * PROMISED)


@pytest.mark.parametrize("share", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("index", range(len(COUNTS)))
def test_a_chosen_rule_keeps_its_promise_in_a_boundary_layer(index: int, share: float) -> None:
    exponent = share * RULE.largest_layer[index]
    assert choose(RULE, math.inf, exponent) <= index
    nodes, weights = row(index)
    exact = (1.0 - math.exp(-exponent)) / exponent
    assert weights @ np.exp(-exponent * nodes) == pytest.approx(exact, abs=PROMISED)
