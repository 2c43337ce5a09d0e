"""Quadrature that stays exact for kinks and near-singularities at the ends of a stretch, wherever they come to lie.

Where the lateral sliding vanishes the sliding direction turns over s_x/r, and where a shoe comes back over its point of
entry its displacement has a kink: widths from a contact length down to nothing. With x = phi(t), phi a polynomial with
three vanishing derivatives at 0 and 1, Gauss-Legendre nodes in t crowd at the ends as t^4. The number of nodes is
fixed, so that force changes smoothly with the state.

References
----------
.. [1] Sidi, A new variable transformation for numerical integration, 1993.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: |x| softened over any width at an end is integrated to 1e-11 of its range, 1/|x| times the width to 1e-7.
NODES = 48
#: Enough for a Jacobian.
FEW_NODES = 16


class GradedRule(NamedTuple):
    """Nodes and weights on [0, 1], graded towards the ends."""

    nodes: Array
    weights: Array


def graded_rule(nodes: int = NODES) -> GradedRule:
    """A rule of so many nodes."""
    t, weights = np.polynomial.legendre.leggauss(nodes)
    t, weights = 0.5 * (t + 1.0), 0.5 * weights
    return GradedRule(grading(t), weights * 140.0 * (t * (1.0 - t)) ** 3)


def grading(t: Array) -> Array:
    """phi(t) = integral of 140 t^3 (1 - t)^3."""
    return t**4 * (35.0 - 84.0 * t + 70.0 * t**2 - 20.0 * t**3)
