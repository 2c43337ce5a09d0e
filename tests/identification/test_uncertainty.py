import numpy as np
import pytest

from trackctl.identification.uncertainty import model_error, neighbours, standard_deviations

MOTIONS = 60
RANDOM = np.random.default_rng(0)
JACOBIAN = RANDOM.standard_normal((3 * MOTIONS, 2))
SPEEDS = RANDOM.uniform(0.5, 2.0, (MOTIONS, 2))
#: Of a turn to the left and its mirror image, by channel.
MIRROR = np.where((SPEEDS[:, 1] < SPEEDS[:, 0])[:, None], [1.0, -1.0, -1.0], 1.0)


def in_channel(values, channel):
    """Residuals of one channel, mirrored."""
    residuals = np.zeros((MOTIONS, 3))
    residuals[:, channel] = values
    return residuals * MIRROR


def test_without_misfit_the_spread_is_that_of_least_squares():
    """At small residuals the weights are 1."""
    residuals = 1e-3 * np.random.default_rng(1).standard_normal(3 * MOTIONS)
    noise, misfit = standard_deviations(JACOBIAN, residuals, SPEEDS)
    assert noise == pytest.approx(np.sqrt(np.diag(np.linalg.inv(JACOBIAN.T @ JACOBIAN))), rel=1e-5)
    assert (misfit == 0.0).all()


def test_noise_is_hardly_ever_taken_for_an_error_of_the_model():
    """3 channels, of each of which 1 % at most is beyond the limit."""
    found = [model_error(np.random.default_rng(seed).standard_normal((MOTIONS, 3)), SPEEDS) for seed in range(500)]
    assert np.mean(np.array(found) > 0.0) < 0.03 + 3.0 * np.sqrt(0.03 / 500)


@pytest.mark.parametrize("channel", [0, 1, 2])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_an_offset_is_shared_by_left_and_right_turns(channel, sign):
    residuals = in_channel(sign * 0.7, channel) + 0.1 * np.random.default_rng(1).standard_normal((MOTIONS, 3))
    assert model_error(residuals, SPEEDS) == pytest.approx(0.7 * np.sqrt(MOTIONS), rel=0.05)


def test_an_error_that_follows_the_speeds_is_found_though_its_mean_vanishes():
    values = np.sin(3.0 * SPEEDS.max(axis=1))
    residuals = in_channel(values - values.mean(), 2)
    assert model_error(residuals, SPEEDS) == pytest.approx(np.linalg.norm(residuals), rel=0.1)


def test_misfit_bounds_the_shift_of_the_parameters():
    """After Cauchy and Schwarz: no error of this size shifts a parameter by more, and one does by just so much."""
    size = 1e-3 * np.sqrt(MOTIONS)
    _, bound = standard_deviations(JACOBIAN, in_channel(1e-3, 2).ravel(), SPEEDS)
    solve = np.linalg.pinv(JACOBIAN)
    errors = np.random.default_rng(2).standard_normal((1000, 3 * MOTIONS))
    errors *= size / np.linalg.norm(errors, axis=1, keepdims=True)
    assert (np.abs(errors @ solve.T) <= bound * (1.0 + 1e-5)).all()
    for parameter in range(2):
        worst = solve[parameter] * size / np.linalg.norm(solve[parameter])
        assert solve[parameter] @ worst == pytest.approx(bound[parameter], rel=1e-5)


def test_few_motions_have_nothing_in_common():
    assert model_error(np.ones((0, 3)), SPEEDS[:0]) == model_error(np.ones((1, 3)), SPEEDS[:1]) == 0.0


def test_neighbours_are_others_even_in_the_same_place():
    places = np.array([[0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [1.0, 1.0], [1.0, 1.2]])
    found = neighbours(places)
    assert (found != np.arange(5)).all()
    assert (found[:3] < 3).all()
    assert found[3:].tolist() == [4, 3]
