import numpy as np
import pytest
from slip_simulation import step

from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.identification.calibration import calibrate_ground
from trackctl.identification.steady_motion import steady_motions
from trackctl.identification.steady_windows import SteadyWindows, body_displacement, steady_windows, within_model
from trackctl.mechanics.equilibrium import balance
from trackctl.mechanics.operating_point import OperatingPoint
from trackctl.mechanics.parameters import track_model
from trackctl.mechanics.quadrature import rules

VEHICLE = load_vehicle("tracked-ugv-61kg")
ASSUMED = track_model(VEHICLE, load_terrain("asphalt"))
#: Friction, K and resistance.
GROUND = (0.6, 0.02, 0.1)
STDS = np.array([0.028, 0.028, 0.0025])


def ground(friction, shear_modulus, resistance):
    return ASSUMED._replace(friction=friction, shear_modulus=shear_modulus, resistance=resistance)


def measured(speeds, parameters=GROUND, seed=0, noise=1.0):
    """Steady motions on known ground, with noise."""
    stds = noise * STDS
    twists = steady_motions(ground(*parameters), speeds)
    known = np.isfinite(twists).all(axis=1)
    off = stds * np.random.default_rng(seed).standard_normal((int(known.sum()), 3))
    return SteadyWindows(speeds[known], twists[known] + off, stds)


def turns(top, seed=0):
    return np.random.default_rng(seed).uniform(0.3 * top, top, (60, 2))


def test_steady_motions_are_in_balance():
    model, speeds = ground(*GROUND), turns(3.0)
    motions = steady_motions(model, speeds)
    known = np.isfinite(motions).all(axis=1)
    assert known.mean() > 0.9
    for (left, right), (forward, lateral, turn) in zip(speeds[known], motions[known], strict=True):
        v, residual = np.hypot(forward, lateral), np.empty(3)
        point = OperatingPoint(0.0, 0.0, 1.0, turn / v, v * turn / model.gravity)
        unknowns = np.array([left / v, right / v, np.arctan2(lateral, forward)])
        balance(model, point, rules((48,)), unknowns, residual, np.empty((3, 3)), np.empty(2), True)
        assert np.abs(residual).max() < 1e-4  # of the weight: the coarser quadrature's


def test_steady_motions_mirror():
    speeds = turns(2.0)
    here, there = steady_motions(ground(*GROUND), speeds), steady_motions(ground(*GROUND), speeds[:, ::-1])
    assert there == pytest.approx(here * [1.0, -1.0, -1.0], abs=1e-6, nan_ok=True)


def test_straight_driving_slips_by_the_resistance_alone():
    """Without lateral sliding, V - v = slip V makes f_r of traction: mu (1 - K/(i L) (1 - exp(-i L/K))) = f_r."""
    friction, modulus, resistance = GROUND
    forward, lateral, turn = steady_motions(ground(*GROUND), np.array([[1.0, 1.0]]))[0]
    assert (lateral, turn) == pytest.approx((0.0, 0.0), abs=1e-9)
    j = (1.0 - forward) * VEHICLE.contact_length / modulus
    assert friction * (1.0 + np.expm1(-j) / j) == pytest.approx(resistance, rel=1e-6)


@pytest.mark.parametrize("parameters", [(0.4, 0.005, 0.03), (0.6, 0.02, 0.1), (0.8, 0.01, 0.05)])
def test_known_ground_is_found(parameters):
    """Turns near the limit of grip tell all three."""
    result = calibrate_ground(ASSUMED, measured(turns(2.5), parameters))
    for truth, estimate in zip(parameters, result.estimates.values(), strict=True):
        assert estimate.determined
        assert abs(estimate.value - truth) < 4.0 * estimate.std
        assert estimate.std < 0.3 * truth


def test_standard_deviations_are_those_of_many_logs():
    results = [calibrate_ground(ASSUMED, measured(turns(1.5), seed=seed)) for seed in range(12)]
    for name, truth in zip(results[0].estimates, GROUND, strict=True):
        assert not any(result.estimates[name].is_by_misfit for result in results)
        off = np.array([result.estimates[name].value - truth for result in results])
        std = np.median([result.estimates[name].std for result in results])
        assert 0.4 * std < np.sqrt(np.mean(off**2)) < 2.0 * std


def test_slow_turns_do_not_tell_the_friction():
    """At a crawl all forces are in proportion to the friction, but K shows."""
    result = calibrate_ground(ASSUMED, measured(turns(0.3), noise=0.05))
    assert not result.friction.determined
    assert result.friction.std > result.friction.value
    assert result.shear_modulus.determined
    assert abs(result.shear_modulus.value - GROUND[1]) < 4.0 * result.shear_modulus.std


def test_straight_driving_tells_nothing():
    speeds = np.repeat(np.linspace(0.3, 1.5, 40)[:, None], 2, axis=1)
    result = calibrate_ground(ASSUMED, measured(speeds))
    assert not result.friction.determined
    assert not result.shear_modulus.determined


def test_driving_backward_is_driving_forward_the_other_way():
    windows = measured(turns(2.0))
    backward = SteadyWindows(-windows.speeds[:, ::-1], windows.twists * [-1.0, -1.0, 1.0], STDS)
    here, there = calibrate_ground(ASSUMED, windows), calibrate_ground(ASSUMED, backward)
    for name, estimate in here.estimates.items():
        assert there.estimates[name].value == pytest.approx(estimate.value, rel=1e-3)


def test_other_peoples_simulation(data_of_others):
    """A table made with friction 0.4, by a model of the same kind whose yaw rates differ by up to 3 %."""
    table = np.genfromtxt(data_of_others("slip_tables/tracked_ugv_sim_mu0p4.csv"), delimiter=",", names=True)
    speeds = np.column_stack((table["track_speed_left_mps"], table["track_speed_right_mps"]))
    names = ("forward_velocity_mps", "lateral_velocity_mps", "yaw_rate_radps")
    twists = np.column_stack([table[name] for name in names])
    result = calibrate_ground(ASSUMED, SteadyWindows(speeds, twists, np.full(3, 0.005)))
    assert result.friction.determined
    assert result.friction.value == pytest.approx(0.4, rel=0.15)
    assert result.shear_modulus.value < 0.003
    assert result.friction.is_by_misfit
    assert abs(result.friction.value - 0.4) < 3.0 * result.friction.std
    assert abs(result.friction.value - 0.4) > 3.0 * result.friction.noise_std


@pytest.mark.parametrize("parameters", [GROUND, (0.4, 0.005, 0.03)])
@pytest.mark.parametrize("changed", [{"length": 0.53}, {"gauge": 0.636}, {"cog_forward": 0.03}])
def test_an_error_of_the_model_is_owned_to(parameters, changed):
    """The vehicle is not quite as its profile has it: friction and K are within 3 deviations."""
    vehicle, stds = ground(*parameters)._replace(**changed), 0.1 * STDS
    for count in (40, 120):
        speeds = np.random.default_rng(1).uniform(0.6, 2.0, (count, 2))
        twists = steady_motions(vehicle, speeds)
        known = np.isfinite(twists).all(axis=1)
        noise = stds * np.random.default_rng(2).standard_normal((int(known.sum()), 3))
        result = calibrate_ground(ASSUMED, SteadyWindows(speeds[known], twists[known] + noise, stds))
        for truth, estimate in zip(parameters[:2], (result.friction, result.shear_modulus), strict=True):
            assert estimate.is_by_misfit
            assert abs(estimate.value - truth) < 3.0 * estimate.std


def test_what_is_outside_the_model_is_left_out():
    speeds = np.array([[1.0, 1.2], [-1.0, -1.2], [-1.0, 1.0], [0.0, 1.0], [0.1, 1.0], [0.005, 0.005]])
    twists = np.array([[1.1, 0, 0.3], [-1.1, 0, -0.3], [0, 0, 3.0], [0.5, 0, 1.5], [0.55, 0, 1.4], [0.005, 0, 0]])
    kept, back = within_model(SteadyWindows(speeds, twists, STDS), 0.5)
    assert kept.speeds.tolist() == [[1.0, 1.2], [1.2, 1.0]]
    assert kept.twists.tolist() == [[1.1, 0.0, 0.3], [1.1, 0.0, -0.3]]
    assert back.tolist() == [False, True]


@pytest.mark.parametrize("twist", [(1.0, 0.2, 0.7), (0.5, 0.0, 0.0), (-0.3, 0.1, -2.9), (1.0, 0.0, 1e-9)])
def test_displacement_of_a_constant_twist(twist):
    start = (3.0, -2.0, 2.9)
    assert body_displacement(np.array(start), np.array(step(start, *twist, 1.0))) == pytest.approx(twist, abs=1e-9)


def log(commands, interval=0.1):
    """A log of commands ((left, right), twist, duration)."""
    pose, time, rows = (0.0, 0.0, 3.0), 0.0, []
    for speeds, twist, duration in commands:
        for _ in range(round(duration / interval)):
            rows.append((time, *speeds, *pose))
            pose, time = step(pose, *twist, interval), time + interval
    return np.array(rows)


def test_windows_lie_within_steady_stretches():
    commands = [
        ((1.0, 1.2), (1.1, -0.1, 0.3), 3.0),
        ((2.0, 1.0), (1.4, 0.1, -1.0), 0.8),
        ((0.5, 0.5), (0.5, 0, 0), 4.0),
    ]
    windows = steady_windows(log(commands))
    assert len(windows.speeds) == 5
    for speeds, twist in zip(windows.speeds, windows.twists, strict=True):
        expected = commands[0] if speeds[0] > 0.8 else commands[2]
        assert speeds == pytest.approx(expected[0])
        assert twist == pytest.approx(expected[1], abs=1e-9)


@pytest.mark.parametrize("spoil", ["order", "gap", "empty", "poses"])
def test_windows_of_faulty_logs(spoil):
    rows = log([((1.0, 1.2), (1.1, -0.1, 0.3), 10.0)])
    whole = len(steady_windows(rows).speeds)
    if spoil == "order":
        rows[[30, 31]] = rows[[31, 30]]
    elif spoil == "gap":
        rows = np.delete(rows, range(40, 60), axis=0)
    elif spoil == "empty":
        rows = rows[:0]
    else:
        rows[5:, 3:] = np.nan
    windows = steady_windows(rows)
    assert len(windows.speeds) < whole or spoil == "order"
    assert windows.twists == pytest.approx(np.tile([1.1, -0.1, 0.3], (len(windows.twists), 1)), abs=1e-9)
