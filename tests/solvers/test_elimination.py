"""Gaussian elimination against numpy."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from trackctl.solvers.elimination import eliminate

Array = NDArray[np.float64]


def eliminated(matrix: Array, vector: Array) -> tuple[float, Array]:
    """Determinant and solution; the arguments stay as they are."""
    solution = np.array(vector, dtype=np.float64)
    return eliminate(np.array(matrix, dtype=np.float64), solution), solution


@pytest.mark.parametrize("n", [1, 2, 3, 4, 6])
def test_random_systems_are_solved(n: int) -> None:
    generator = np.random.default_rng(n)
    for _ in range(100):
        matrix, vector = generator.standard_normal((n, n)), generator.standard_normal(n)
        determinant, solution = eliminated(matrix, vector)
        # Both are backward stable: they differ by rounding times the condition.
        tolerance = 1e-14 * np.linalg.cond(matrix)
        assert determinant == pytest.approx(np.linalg.det(matrix), rel=tolerance)
        np.testing.assert_allclose(
            solution, np.linalg.solve(matrix, vector), rtol=0, atol=tolerance * np.abs(solution).max()
        )


def test_rows_are_exchanged_for_the_largest_pivot() -> None:
    # Without pivoting the small pivot would wipe out the second equation: (0, 1) instead of (1, 1).
    determinant, solution = eliminated(np.array([[1e-20, 1.0], [1.0, 1.0]]), np.array([1.0, 2.0]))
    assert solution == pytest.approx([1.0, 1.0], rel=1e-15)
    assert determinant == pytest.approx(-1.0, rel=1e-15)


@pytest.mark.parametrize("order", [(0, 1, 2), (1, 0, 2), (2, 0, 1), (2, 1, 0)])
def test_determinant_of_a_permutation_is_its_sign(order: tuple[int, int, int]) -> None:
    matrix = np.eye(3)[list(order)]
    determinant, solution = eliminated(matrix, np.array([1.0, 2.0, 3.0]))
    assert determinant == round(float(np.linalg.det(matrix)))
    np.testing.assert_array_equal(matrix @ solution, [1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    "matrix",
    [np.zeros((2, 2)), np.array([[1.0, 2.0], [2.0, 4.0]]), np.diag([1.0, 0.0, 1.0])],
    ids=["zero", "rank one", "rank two"],
)
def test_singular_matrix_has_determinant_zero(matrix: Array) -> None:
    assert eliminated(matrix, np.ones(len(matrix)))[0] == 0.0


def test_rows_of_very_different_size() -> None:
    scale = np.array([1e-150, 1.0, 1e150])
    matrix = scale[:, None] * np.array([[2.0, 1.0, 0.0], [1.0, 3.0, 1.0], [0.0, 1.0, 4.0]])
    expected = np.array([1.0, -2.0, 3.0])
    determinant, solution = eliminated(matrix, matrix @ expected)
    assert solution == pytest.approx(expected, rel=1e-14)
    assert determinant == pytest.approx(18.0, rel=1e-14)


def test_nan_is_not_taken_for_a_solution() -> None:
    determinant, solution = eliminated(np.array([[np.nan, 1.0], [1.0, 1.0]]), np.ones(2))
    assert np.isnan(determinant) or np.isnan(solution).any()
