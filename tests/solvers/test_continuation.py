"""Continuation along curves whose folds are known."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from trackctl.solvers import continuation

Array = NDArray[np.float64]
System = Callable[[Array, float], tuple[Array, Array]]


def circle(x: Array, parameter: float) -> tuple[Array, Array]:
    """x^2 + l^2 = 1/4: the branch from x = 1/2 folds at l = 1/2, x = 0."""
    return np.array([x[0] ** 2 + parameter**2 - 0.25]), np.array([[2.0 * x[0]]])


def line(x: Array, parameter: float) -> tuple[Array, Array]:
    """x = 1/2 + 2 l: no fold."""
    return np.array([x[0] - 0.5 - 2.0 * parameter]), np.array([[1.0]])


def quarter(x: Array, parameter: float) -> tuple[Array, Array]:
    """x^2 = 1/4 + 2 l: no fold for l from 0 to 1."""
    return np.array([x[0] ** 2 - 0.25 - 2.0 * parameter]), np.array([[2.0 * x[0]]])


def spiral(x: Array, parameter: float) -> tuple[Array, Array]:
    """Two unknowns, x = (1 + l, l^2) beside a regular factor: no fold."""
    first, second = x[0] - 1.0 - parameter, x[1] - parameter**2
    jacobian = np.array([[math.exp(first), 0.0], [second, 1.0 + first]])
    return np.array([math.exp(first) - 1.0, second * (1.0 + first)]), jacobian


def border(curve: continuation.Curve, system: System) -> float:
    """Set up the bordered system at the curve's point; the largest residual there."""
    x, parameter = curve["point"][:-1], float(curve["point"][-1])
    residual, jacobian = system(x, parameter)
    beside, _ = system(x, parameter + continuation.DIFFERENCE)
    continuation.differentiate(curve, residual, beside)
    continuation.border(curve, jacobian, residual)
    return float(np.abs(residual).max())


def started(system: System, x: Array) -> continuation.Curve:
    curve = np.zeros(1, continuation.curve(x.size))[0]
    continuation.start(curve, x)
    border(curve, system)
    assert continuation.turn(curve)
    return curve


def advance(curve: continuation.Curve, system: System, step: float) -> None:
    """One step of the curve, corrected to rounding."""
    continuation.predict(curve, step)
    for _ in range(8):
        if border(curve, system) < 1e-14:
            break
        assert continuation.correct(curve)
    border(curve, system)
    assert continuation.turn(curve)


def test_curve_starts_at_its_root_towards_growing_parameter() -> None:
    curve = started(circle, np.array([0.5]))
    np.testing.assert_array_equal(curve["point"], [0.5, 0.0])
    # The circle rises straight up there; the derivative by the parameter is a difference over 1e-6.
    np.testing.assert_allclose(curve["tangent"], [0.0, 1.0], atol=2e-6)
    assert not continuation.has_folded(curve)


@pytest.mark.parametrize("step", [0.02, 0.1, 0.3])
def test_fold_of_a_circle_is_where_it_is(step: float) -> None:
    curve = started(circle, np.array([0.5]))
    while not continuation.has_folded(curve):
        before = curve["point"].copy()
        advance(curve, circle, step)
    # The fold lies between the last two points of the circle, which the curve passes without losing it.
    assert before[0] > 0.0 > curve["point"][0]
    assert max(before[1], curve["point"][1]) <= 0.5 + 1e-12
    # A step s along a circle of radius 1/2 turns by 2 s at most: one of both ends is within half of that.
    assert max(before[1], curve["point"][1]) >= 0.5 * math.cos(step) - 1e-9


def test_points_lie_on_the_curve_and_the_tangent_is_a_unit_vector_along_it() -> None:
    curve = started(circle, np.array([0.5]))
    for _ in range(20):
        advance(curve, circle, 0.1)
        x, parameter = curve["point"]
        assert math.hypot(x, parameter) == pytest.approx(0.5, abs=1e-13)
        assert np.linalg.norm(curve["tangent"]) == pytest.approx(1.0, abs=1e-14)
        # Normal to the radius, and always onwards: past the fold the parameter falls.
        np.testing.assert_allclose(curve["tangent"], [-2.0 * parameter, 2.0 * x], atol=1e-5)


@pytest.mark.parametrize(("system", "x"), [(line, [0.5]), (spiral, [1.0, 0.0])], ids=["line", "two unknowns"])
def test_curve_without_a_fold_reaches_the_end(system: System, x: list[float]) -> None:
    curve = started(system, np.array(x))
    while curve["point"][-1] < 1.0 - 1e-9:
        step = min(0.2, (1.0 - curve["point"][-1]) / curve["tangent"][-1])
        advance(curve, system, step)
        assert not continuation.has_folded(curve)
    residual, _ = system(curve["point"][:-1], float(curve["point"][-1]))
    assert np.abs(residual).max() < 1e-13


@pytest.mark.parametrize("system", [line, quarter], ids=["line", "curve"])
def test_end_is_corrected_at_parameter_one(system: System) -> None:
    curve = started(system, np.array([0.5]))
    advance(curve, system, 0.3)
    assert continuation.way_to_go(curve) == pytest.approx(
        (1.0 - curve["point"][-1]) * math.hypot(*(curve["tangent"] / curve["tangent"][-1]))
    )
    continuation.predict_end(curve)
    for _ in range(8):
        if border(curve, system) < 1e-14:
            break
        assert continuation.correct(curve)
    assert curve["point"][-1] == 1.0
    assert np.abs(system(curve["point"][:-1], 1.0)[0]).max() < 1e-14


def test_correction_converges_quadratically() -> None:
    curve = started(circle, np.array([0.5]))
    continuation.predict(curve, 0.2)
    errors = [border(curve, circle)]
    for _ in range(4):
        continuation.correct(curve)
        errors.append(border(curve, circle))
    logarithms = np.log([error for error in errors if error > 1e-14])
    # The derivative by the parameter is a difference: quadratic down to its error of 1e-6, faster than linear below.
    assert (logarithms[2] - logarithms[1]) / (logarithms[1] - logarithms[0]) == pytest.approx(2.0, abs=0.3)


def test_step_back_returns_to_the_last_point() -> None:
    curve = started(circle, np.array([0.5]))
    advance(curve, circle, 0.1)
    kept = curve["point"].copy()
    continuation.predict(curve, 0.3)
    assert not np.array_equal(curve["point"], kept)
    continuation.step_back(curve)
    np.testing.assert_array_equal(curve["point"], kept)


def test_a_curve_that_crosses_itself_has_no_tangent_there() -> None:
    curve = np.zeros(1, continuation.curve(1))[0]
    continuation.start(curve, np.array([0.0]))
    continuation.border(curve, np.zeros((1, 1)), np.zeros(1))
    assert not continuation.turn(curve)
    continuation.border(curve, np.zeros((1, 1)), np.zeros(1))
    assert not continuation.correct(curve)
