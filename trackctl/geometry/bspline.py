"""B-splines: basis functions, their derivatives, and least squares in banded form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

#: Up to so many unknowns a dense solution is as quick, and spares the third of a second that scipy takes to load.
FEW = 64


@dataclass(frozen=True, slots=True, eq=False)
class SplineSpace:
    """All splines of a degree on a row of knots.

    Attributes
    ----------
    knots
        Ascending; the first and last each `degree` + 1 times.
    degree
        Of the polynomial between two knots.
    """

    knots: Array
    degree: int

    @property
    def size(self) -> int:
        """Number of coefficients."""
        return int(self.knots.size) - self.degree - 1

    def span(self, at: Array) -> Indices:
        """Index of the knot at or before each point, the last stretch including its end."""
        return np.clip(np.searchsorted(self.knots, at, side="right") - 1, self.degree, self.size - 1)

    def basis(self, at: Array, span: Indices, derivative: int = 0) -> Array:
        """The basis functions that do not vanish, or a derivative of theirs; Cox and de Boor's recursion.

        Parameters
        ----------
        at : ndarray, shape (n,)
            The points.
        span : ndarray, shape (n,)
            The stretch that each point is taken to lie in, as of `span`.
        derivative
            Its order, at most the degree.

        Returns
        -------
        ndarray, shape (degree + 1, n)
            Of the functions with indices span - degree to span.
        """
        after = [self.knots[span + 1 + j] for j in range(self.degree)]
        before = [self.knots[span - j] for j in range(self.degree)]
        values = [np.ones(at.size)]
        for degree in range(1, self.degree + 1):
            raised = [np.zeros(at.size) for _ in range(degree + 1)]
            for j, value in enumerate(values):
                right, left = after[j], before[degree - 1 - j]
                share = value / (right - left)
                if degree <= self.degree - derivative:
                    raised[j] += (right - at) * share
                    raised[j + 1] += (at - left) * share
                else:
                    raised[j] -= degree * share
                    raised[j + 1] += degree * share
            values = raised
        return np.stack(values)


@dataclass(frozen=True, slots=True, eq=False)
class Spline:
    """A spline function, of one or several components.

    Attributes
    ----------
    space
        What it is one of.
    coefficients
        Shape (space.size,) or (space.size, n_components).
    """

    space: SplineSpace
    coefficients: Array

    def __call__(self, at: Array, derivative: int = 0) -> Array:
        """Values or derivatives at points, shape (n,) or (n, n_components); from the right at knots."""
        span = self.space.span(at)
        first, basis = span - self.space.degree, self.space.basis(at, span, derivative)
        total = np.zeros((*self.coefficients.shape[1:], at.size))
        for k, weight in enumerate(basis):
            total += weight * self.coefficients[first + k].T
        return np.ascontiguousarray(total.T)


def clamped_knots(breaks: Array, degree: int, multiplicity: NDArray[np.intp] | int = 1) -> Array:
    """Knots at breaks, shape (n,): the inner ones with a multiplicity each, the ends with degree + 1."""
    inner = np.repeat(breaks[1:-1], multiplicity)
    return np.concatenate((np.full(degree + 1, breaks[0]), inner, np.full(degree + 1, breaks[-1])))


def solve_normal_equations(space: SplineSpace, span: Indices, rows: Array, right: Array) -> Array:
    """Coefficients of least sum of squares of the differences of rows and right sides.

    Parameters
    ----------
    space
        Of the spline.
    span : ndarray, shape (n,)
        The stretch that each row belongs to.
    rows : ndarray, shape (degree + 1, n)
        Weights of the coefficients span - degree to span, as of `SplineSpace.basis`.
    right : ndarray, shape (n,) or (n, n_components)
        Right sides.

    Returns
    -------
    ndarray, shape (space.size,) or (space.size, n_components)

    Raises
    ------
    numpy.linalg.LinAlgError
        If the rows do not determine the coefficients.
    """
    first = span - space.degree
    banded = np.zeros((space.degree + 1, space.size))
    columns = right.reshape(right.shape[0], -1).T
    totals = np.zeros((len(columns), space.size))
    for i, row in enumerate(rows):
        for j, other in enumerate(rows[i:]):
            banded[-1 - j] += np.bincount(first + i + j, row * other, space.size)
        for total, column in zip(totals, columns, strict=True):
            total += np.bincount(first + i, row * column, space.size)
    return solve_banded(banded, totals.T).reshape(space.size, *right.shape[1:])


def solve_banded(banded: Array, right: Array) -> Array:
    """Solve with a symmetric matrix whose upper diagonals are the rows, the main one last, each aligned right.

    Parameters
    ----------
    banded : ndarray, shape (n_diagonals, n)
        As in LAPACK.
    right : ndarray, shape (n, n_columns)
        Right sides.
    """
    size = banded.shape[1]
    if size > FEW:
        from scipy.linalg import solveh_banded

        return np.asarray(solveh_banded(banded, right))
    matrix = np.zeros((size, size))
    for j, diagonal in enumerate(banded[::-1, :]):
        row = np.arange(size - j)
        matrix[row, row + j] = matrix[row + j, row] = diagonal[j:]
    return np.asarray(np.linalg.solve(matrix, right), np.float64)
