import numpy as np
import pytest
from slip_simulation import step, twist

from trackctl.identification.track_history import INTERVALS, MOTION, append, first_at, mean_twist, ring, travel_slopes
from trackctl.identification.track_history import travel as travel_in_ring

GAUGE = 0.6
P = np.array([0.02, 0.03, 0.01, 0.04, 0.05, -0.02, 0.1, -0.08, -0.03, 0.05, -0.04])


def history(speeds, interval=0.1, resolution=0.05):
    """A ring of these track speeds, one after the other, and its count."""
    intervals, count = ring(), 0
    for i, (left, right) in enumerate(speeds):
        count = append(intervals, count, i * interval, interval, left, right, resolution)
    return intervals, count


def random_history():
    return history(np.random.default_rng(1).uniform(-0.5, 1.5, (30, 2)))


def travel(intervals, count, p, start, end):
    pose = np.zeros(3)
    assert travel_in_ring(intervals, count, p, GAUGE, start, end, pose)
    return pose


def test_a_circle_closes():
    left, right = 0.6, 1.0
    intervals, count = history([(left, right)] * 200)
    around = 2 * np.pi / twist(P, GAUGE, left, right)[2]
    assert travel(intervals, count, P, 0.03, 0.03 + around) == pytest.approx([0.0, 0.0, 2 * np.pi], abs=1e-12)


def test_travel_composes_over_parts_of_intervals():
    intervals, count = random_history()
    first, second = travel(intervals, count, P, 0.53, 1.27), travel(intervals, count, P, 1.27, 2.9)
    cos, sin = np.cos(first[2]), np.sin(first[2])
    joined = first + np.array([cos * second[0] - sin * second[1], sin * second[0] + cos * second[1], second[2]])
    assert travel(intervals, count, P, 0.53, 2.9) == pytest.approx(joined, abs=1e-12)


def test_the_last_speeds_hold_on():
    intervals, count = history([(0.5, 0.5), (0.4, 0.8)])
    expected = step((0.0, 0.0, 0.0), *twist(P, GAUGE, 0.4, 0.8), 5.0)
    assert travel(intervals, count, P, 0.2, 5.2) == pytest.approx(expected, abs=1e-12)


def test_slopes_are_derivatives():
    intervals, count = random_history()
    motion, h = np.zeros(1, MOTION), 1e-6
    assert travel_slopes(intervals, count, P, GAUGE, 0.33, 2.61, motion[0])
    assert motion["pose"][0] == pytest.approx(travel(intervals, count, P, 0.33, 2.61), abs=1e-12)
    for i, slope in enumerate(motion["slope"][0].T):
        off = h * np.eye(11)[i]
        up, down = (travel(intervals, count, p, 0.33, 2.61) for p in (P + off, P - off))
        assert slope == pytest.approx((up - down) / (2 * h), abs=1e-7)


def test_noise_of_the_speeds_is_that_of_many_trials():
    """Covariance of the pose under independent noise of each row's track speeds."""
    random = np.random.default_rng(2)
    speeds = np.random.default_rng(1).uniform(0.2, 1.0, (20, 2))
    intervals, count = history(speeds)
    motion, std = np.zeros(1, MOTION), 1e-3
    travel_slopes(intervals, count, P, GAUGE, 0.0, 2.0, motion[0])
    poses = []
    for _ in range(2000):
        noisy, noisy_count = history(speeds + std * random.standard_normal(speeds.shape))
        poses.append(travel(noisy, noisy_count, P, 0.0, 2.0))
    sampled = np.cov(np.array(poses).T) / std**2
    # a and k count as given, which leaves a few per cent; 2000 samples leave as much.
    assert motion["noise"][0] == pytest.approx(sampled, rel=0.15, abs=0.1 * sampled.diagonal().max())


def test_short_intervals_are_joined_without_a_change_of_motion():
    speeds = np.repeat(np.random.default_rng(3).uniform(0.2, 1.0, (20, 2)), 10, axis=0)
    fine, fine_count = history(speeds, 0.01, 1e-9)
    joined, joined_count = history(speeds, 0.01, 0.1)
    assert joined_count < 0.2 * fine_count
    assert travel(joined, joined_count, P, 0.0, 2.0) == pytest.approx(travel(fine, fine_count, P, 0.0, 2.0), abs=2e-3)


def test_the_ring_forgets_and_says_so():
    intervals, count = history([(1.0, 1.0)] * (INTERVALS + 10), resolution=1e-9)
    assert first_at(intervals, count, 0.5) == -1
    assert first_at(intervals, count, 2.05) == 20
    assert not travel_in_ring(intervals, count, P, GAUGE, 0.5, 2.0, np.zeros(3))


def test_mean_twist_of_steady_speeds_is_the_twist():
    intervals, count = history([(0.4, 0.9)] * 20)
    motion = np.zeros(1, MOTION)
    assert mean_twist(intervals, count, P, GAUGE, 0.15, 1.35, motion[0])
    assert motion["pose"][0] == pytest.approx(1.2 * np.array(twist(P, GAUGE, 0.4, 0.9)), abs=1e-12)
