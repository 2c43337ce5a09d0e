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

from trackctl.compiled import inlined, kernel

Array = NDArray[np.float64]

#: Node counts to choose from; the largest is the reference rule.
COUNTS = (8, 12, 16, 20, 24, 32, 40, 48)
#: rho^(2n) must exceed exp of this; forces then differ by less than 1e-7 of the weight from the reference rule's.
DIGITS = 16.0
#: A boundary layer exp(-X t) on [0, 1] needs n^2 nodes of at least this times X.
LAYER = 9.0


class Rule(NamedTuple):
    """Gauss-Legendre rules on [0, 1], one a row, and when each is good enough.

    Attributes
    ----------
    nodes, weights
        Shape (n_rules, largest count); row i holds `counts[i]` entries, then zeros.
    counts
        Shape (n_rules,), int64.
    least_axis
        Least half major axis, in half stretches, of the ellipse of analyticity, shape (n_rules,).
    largest_layer
        Largest exponent of a boundary layer, shape (n_rules,).
    joined
        Rules for two stretches end to end, in one sequence of nodes, shape (n_rules + 1, n_rules + 1, 4, 2 largest
        count). Entry [i, j] has rule i on the first and rule j on the second: the share of the first and of the second
        stretch that lies before a node, and the node's weight on each. Row `n_rules` has no nodes.
    """

    nodes: Array
    weights: Array
    counts: NDArray[np.int64]
    least_axis: Array
    largest_layer: Array
    joined: Array


def rules(counts: tuple[int, ...] = COUNTS) -> Rule:
    """Rules of ascending node counts; a single count is used everywhere."""
    nodes = np.zeros((len(counts), counts[-1]))
    weights = np.zeros_like(nodes)
    for row, n in enumerate(counts):
        t, w = np.polynomial.legendre.leggauss(n)
        nodes[row, :n] = 0.5 * (t + 1.0)
        weights[row, :n] = 0.5 * w
    count: NDArray[np.int64] = np.array(counts, dtype=np.int64)
    rho = np.exp(DIGITS / (2.0 * count))
    least_axis = 0.5 * (rho + 1.0 / rho)
    return Rule(nodes, weights, count, least_axis, count**2 / LAYER, joined(nodes, weights, count))


def joined(nodes: Array, weights: Array, count: NDArray[np.int64]) -> Array:
    """Every rule followed by every other, see `Rule`."""
    counts = [*count, 0]
    result = np.zeros((len(counts), len(counts), 4, 2 * nodes.shape[1]))
    for i, n in enumerate(counts):
        for j, m in enumerate(counts):
            first, second = result[i, j, :, :n], result[i, j, :, n : n + m]
            if n > 0:
                first[0], first[2] = nodes[i, :n], weights[i, :n]
            if m > 0:
                second[0], second[1], second[3] = 1.0, nodes[j, :m], weights[j, :m]
    return result


@inlined
def axis_through(real: float, imaginary: float, start: float, end: float) -> float:
    """Half major axis, in half stretches, of the ellipse with foci at the ends through a complex point."""
    square = imaginary * imaginary
    to_start = math.sqrt((real - start) ** 2 + square)
    to_end = math.sqrt((real - end) ** 2 + square)
    return (to_start + to_end) / abs(end - start)


@kernel
def choose(rule: Rule, axis: float, layer: float) -> int:
    """Row of the smallest rule that is good enough, or the last; NaN asks for the last."""
    last = rule.counts.size - 1
    for row in range(last):
        if axis >= rule.least_axis[row] and layer <= rule.largest_layer[row]:
            return row
    return last
