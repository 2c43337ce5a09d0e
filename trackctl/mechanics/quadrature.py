"""Quadrature along a stretch of track, with as many nodes as its integrand needs.

An integrand that is analytic inside the ellipse about the stretch through its nearest complex singularity is
integrated by n Gauss-Legendre nodes with an error that falls as rho^(-2n), rho the sum of the ellipse's half axes in
units of half the stretch. The singularities of the shear force are known: the sliding direction turns where the lateral
sliding vanishes, and the shear displacement returns towards zero where a shoe comes back over its point of entry.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel

Array = NDArray[np.float64]

#: Node counts to choose from; the largest is the reference rule.
COUNTS = (8, 12, 16, 24, 32, 48)
#: rho^(2n) must exceed exp of this; forces then differ by less than 1e-7 of the weight from the reference rule's.
DIGITS = 16.0
#: A boundary layer exp(-X t) on [0, 1] needs n^2 nodes of at least this times X.
LAYER = 9.0


class Rule(NamedTuple):
    """Gauss-Legendre rules on [0, 1], one a row, and when each is good enough.

    Attributes
    ----------
    nodes, weights
        Shape (n_rules, largest count); row i holds `count[i]` entries, then zeros.
    count
        Shape (n_rules,), int64.
    least_axis
        Least half major axis, in half stretches, of the ellipse of analyticity, shape (n_rules,).
    largest_layer
        Largest exponent of a boundary layer, shape (n_rules,).
    """

    nodes: Array
    weights: Array
    count: NDArray[np.int64]
    least_axis: Array
    largest_layer: Array


def rules(counts: tuple[int, ...] = COUNTS) -> Rule:
    """Rules of ascending node counts; a single count is used everywhere."""
    nodes = np.zeros((len(counts), counts[-1]))
    weights = np.zeros_like(nodes)
    for row, count in enumerate(counts):
        t, w = np.polynomial.legendre.leggauss(count)
        nodes[row, :count] = 0.5 * (t + 1.0)
        weights[row, :count] = 0.5 * w
    count = np.array(counts, dtype=np.int64)
    rho = np.exp(DIGITS / (2.0 * count))
    least_axis = 0.5 * (rho + 1.0 / rho)
    return Rule(nodes, weights, count, least_axis, count**2 / LAYER)


@kernel
def axis_through(real: float, imaginary: float, start: float, end: float) -> float:
    """Half major axis, in half stretches, of the ellipse with foci at the ends through a complex point."""
    square = imaginary * imaginary
    to_start = math.sqrt((real - start) ** 2 + square)
    to_end = math.sqrt((real - end) ** 2 + square)
    return (to_start + to_end) / abs(end - start)


@kernel
def choose(rule: Rule, axis: float, layer: float) -> int:
    """Row of the smallest rule that is good enough, or the last; NaN asks for the last."""
    last = rule.count.size - 1
    for row in range(last):
        if axis >= rule.least_axis[row] and layer <= rule.largest_layer[row]:
            return row
    return last
