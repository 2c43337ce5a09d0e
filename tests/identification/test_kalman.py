import numpy as np
import pytest

from trackctl.identification.kalman import ESTIMATE, WIDEST, drift, forget, make_independent, misfit, try_update, widen


def random_estimate(seed=0):
    random = np.random.default_rng(seed)
    memory = np.zeros(1, ESTIMATE)
    root, noise = random.standard_normal((11, 11)), random.standard_normal((3, 3))
    memory["P"], memory["R"] = root @ root.T, noise @ noise.T + 0.1 * np.eye(3)
    memory["H"], memory["p"] = random.standard_normal((1, 3, 11)), random.standard_normal(11)
    memory["innovation"], memory["prior"] = random.standard_normal(3), 1.0
    return memory


def textbook(memory, rows, scale=1.0):
    """Update with all rows at once."""
    use = slice(3 - rows, 3)
    P, p = memory["P"][0], memory["p"][0]
    H, R, z = memory["H"][0][use], scale * memory["R"][0][use, use], memory["innovation"][0][use]
    S = H @ P @ H.T + R
    K = P @ H.T @ np.linalg.inv(S)
    keep = np.eye(11) - K @ H
    return p + K @ z, keep @ P @ keep.T + K @ R @ K.T, z @ np.linalg.inv(S) @ z


@pytest.mark.parametrize("rows", [1, 3])
@pytest.mark.parametrize("scale", [1.0, 7.0])
def test_row_by_row_is_all_at_once(rows, scale):
    memory = random_estimate()
    expected_p, expected_P, expected = textbook(memory, rows, scale)
    assert try_update(memory[0], rows, scale) == pytest.approx(expected, rel=1e-9)
    assert memory["trial_p"][0] == pytest.approx(expected_p, rel=1e-9)
    assert memory["trial_P"][0] == pytest.approx(expected_P, rel=1e-8, abs=1e-9)


def test_the_covariance_stays_symmetric_and_positive():
    memory = random_estimate(1)
    for _ in range(1000):
        try_update(memory[0], 3, 1e-6)
        memory["P"] = memory["trial_P"]
    P = memory["P"][0]
    assert np.array_equal(P, P.T)
    assert np.linalg.eigvalsh(P).min() >= -1e-12 * np.linalg.eigvalsh(P).max()


@pytest.mark.parametrize("rows", [1, 3])
def test_misfit_is_the_weighted_square(rows):
    memory = random_estimate(2)
    make_independent(memory[0], rows, 2.0)
    z, use = np.array([0.3, -0.2, 0.5]), slice(3 - rows, 3)
    expected = z[use] @ np.linalg.inv(2.0 * memory["R"][0][use, use]) @ z[use]
    assert misfit(memory[0], rows, z) == pytest.approx(expected, rel=1e-9)


def test_what_is_not_learned_does_not_drift():
    memory = random_estimate(3)
    memory["P"], memory["prior"][0, :6], memory["drift"] = 0.0, 0.0, 1.0
    drift(memory[0], 2.0)
    assert memory["P"][0].diagonal().tolist() == [0.0] * 6 + [2.0] * 5


def test_variances_are_capped_and_correlations_kept():
    memory = random_estimate(4)
    memory["P"] *= 100.0
    before = memory["P"][0].copy()
    widen(memory[0])
    after = memory["P"][0]
    assert after.diagonal() == pytest.approx(np.full(11, WIDEST))
    grown = before + np.eye(11)
    scale = np.sqrt(grown.diagonal())
    assert after / WIDEST == pytest.approx(grown / np.outer(scale, scale), rel=1e-9)


def test_forgetting_leads_back_to_the_prior():
    memory = random_estimate(5)
    forget(memory[0])
    assert not memory["p"].any()
    assert np.array_equal(memory["P"][0], np.eye(11))
