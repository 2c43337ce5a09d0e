import numpy as np
import pytest
from shear_log import shear_log
from slip_simulation import (
    GAUGE,
    abrupt_change,
    errors_against,
    learn,
    locked_track,
    many_turns,
    mean_errors,
    reductions,
)

from trackctl.files.profile_yaml import load_vehicle
from trackctl.identification.identifier import FilterSettings, LearnedSlip, LogFilter, prior_std
from trackctl.identification.slip_model import SlipModel

HUSKY, HUSKY_GAUGE = "logs/husky_chained_fresh.csv", 0.55
WARTHOG, WARTHOG_GAUGE = "logs/warthog_chained_fresh.csv", 1.08
#: Vehicle, terrain and fastest track speed [m/s] of simulated logs.
SHEARED = {"small": ("utv-61cm", "asphalt", 1.8), "fast": ("m113", "hard-soil", 4.0)}
NAN = np.nan
PRIOR = prior_std(FilterSettings(GAUGE))


def converged_after(updates, since, truth, within):
    """Time from a change until the ICRs stay within a distance of the truth. [s]"""
    late = updates[updates["pose"]["time"] > since]
    off = np.abs(late["icr"] - truth).max(axis=1)
    wrong = late["pose"]["time"][off > within]
    return wrong.max() - since if wrong.size else 0.0


@pytest.mark.parametrize("model", ["parametric", "constant", "paper"])
def test_abrupt_change_is_tracked(model):
    """Case 4.1: within 0.2 m in 1.5 s; 2 s errors from true poses below 0.1 m and 0.02 rad."""
    truth = abrupt_change(0, noise=0.0)
    for seed in range(10):
        rows = abrupt_change(seed)
        updates, _ = learn(rows, model=model)
        assert converged_after(updates, 2.0, [2.232, -2.232, 0.5], 0.2) <= 1.5
        (position, heading), (without, _) = errors_against(truth, updates, rows, since=3.5)
        assert position < 0.1
        assert heading < 0.02
        assert without > 0.7


def test_slow_poses_are_used_better_than_by_velocities():
    """Case 4.2: a window filter at least 1.5 times as good as a velocity filter in the frame of the middle."""
    truth, window, velocity = abrupt_change(0, noise=0.0), [], []
    for seed in range(10):
        rows = abrupt_change(seed, pose_every=10)
        for kind, errors in (("window", window), ("velocity", velocity)):
            updates, _ = learn(rows, kind=kind)
            errors.append(errors_against(truth, updates, truth, since=4.0)[0, 0])
    assert np.mean(velocity) >= 1.5 * np.mean(window)
    assert np.mean(window) < 0.04


def test_locked_track():
    """Like case 5.2: at least 65 % and 65 % less error."""
    for seed in range(3):
        updates, _ = learn(locked_track(seed))
        assert (reductions(mean_errors(updates)) >= 65.0).all()


def test_heading_alone_still_helps():
    """Like case 5.3: 10 to 40 % less in position, at least 65 % in heading; p5, p6 and p9 stay unknown."""
    rows = locked_track(0)
    blind = rows.copy()
    blind[:, 3:5] = NAN
    updates, learner = learn(blind)
    position, heading = reductions(errors_against(rows, updates, rows))
    assert 10.0 <= position <= 40.0
    assert heading >= 65.0
    assert not updates["p"][:, [4, 5, 8]].any()
    assert np.isnan(updates["innovation"][:, :2]).all()
    assert np.isnan(updates["error"][:, 0]).all()
    unknown = [4, 5, 8]
    assert (np.sqrt(learner.learned().covariance.diagonal())[unknown] >= PRIOR[unknown]).all()


def test_a_position_outage_in_the_midst():
    rows = many_turns(1)
    rows[400:700, 3:5] = NAN
    updates, _ = learn(rows)
    assert updates["accepted"].mean() > 0.98
    assert (reductions(mean_errors(updates)) > 60.0).all()


@pytest.mark.parametrize("which", SHEARED)
def test_ground_that_shears(which):
    """Slip that no model of the filter makes: the default one is no worse than constant ICRs, and finds the true ICRs.

    Without slip the outer ones would be off by a sixth of the gauge.
    """
    gauge = load_vehicle(SHEARED[which][0]).track_gauge
    for seed in range(3):
        rows, icrs = shear_log(*SHEARED[which], seed=seed)
        updates, learner = learn(rows, gauge)
        found = reductions(mean_errors(updates))
        assert (found >= [70.0, 65.0]).all()
        assert (found >= reductions(mean_errors(learn(rows, gauge, "constant")[0])) - 4.0).all()
        assert learner.resets == 0
        off = np.abs(updates["icr"] - icrs)[updates["pose"]["time"] > 30.0]
        assert (np.nanmedian(off, axis=0) < 0.03 * gauge).all()


def test_encoders_of_a_wrong_scale():
    """What ICRs cannot show, speed factors do; those of straight driving hold the slip of a percent or two as well."""
    gauge = load_vehicle(SHEARED["small"][0]).track_gauge
    for seed in range(3):
        rows, icrs = shear_log(*SHEARED["small"], seed=seed, read_over_true=1.15)
        updates, learner = learn(rows, gauge, "factors")
        assert reductions(mean_errors(updates))[0] >= reductions(mean_errors(learn(rows, gauge)[0]))[0] + 20.0
        assert learner.learned().p[9:] == pytest.approx([1.0 / 1.15 - 1.0] * 2, abs=0.03)
        off = np.abs(updates["icr"] - icrs)[updates["pose"]["time"] > 30.0]
        assert (np.nanmedian(off, axis=0) < 0.05 * gauge).all()


def test_real_log(data_of_others):
    """The default filter is no worse than constant ICRs, and both far better than none; speed factors help more."""
    rows = np.loadtxt(data_of_others(HUSKY), delimiter=",", skiprows=1)
    position, heading = reductions(mean_errors(learn(rows, HUSKY_GAUGE)[0]))
    constant = reductions(mean_errors(learn(rows, HUSKY_GAUGE, "constant")[0]))
    assert position >= 47.0
    assert heading >= 85.0
    assert (np.array([position, heading]) >= constant - 2.0).all()
    assert reductions(mean_errors(learn(rows, HUSKY_GAUGE, "factors")[0]))[0] >= position + 2.0


def test_a_faster_vehicle(data_of_others):
    """At four times the Husky's speed, too, what depends on the motion must not spoil what constant ICRs tell."""
    rows = np.loadtxt(data_of_others(WARTHOG), delimiter=",", skiprows=1)
    updates, learner = learn(rows, WARTHOG_GAUGE)
    constant = reductions(mean_errors(learn(rows, WARTHOG_GAUGE, "constant")[0]))
    assert (reductions(mean_errors(updates)) >= constant - [2.0, 5.0]).all()
    assert learner.resets == 0


def test_without_a_model_nothing_is_learned():
    updates, learner = learn(many_turns(0), model="none")
    assert not learner.learned().p.any()
    assert updates["accepted"].all()
    errors = mean_errors(updates)
    assert errors[0] == pytest.approx(errors[1], rel=1e-12)


def test_straight_driving_teaches_no_icr():
    nominal = [0.5 * GAUGE, -0.5 * GAUGE, 0.0]
    updates, _ = learn(abrupt_change(0, noise=0.0)[:20])
    assert updates["icr"] == pytest.approx(np.tile(nominal, (len(updates), 1)), abs=1e-9)
    assert (updates["std"][:, :9] >= PRIOR[:9] * (1.0 - 1e-12)).all()
    noisy, _ = learn(abrupt_change(0)[:20])
    assert (np.abs(noisy["icr"] - nominal) < 0.5 * noisy["std"][:, 6:9]).all()


def test_straight_driving_knows_its_icrs_as_well_as_the_offsets():
    """a and k vanish there, and with other parameters nothing is added."""
    updates, _ = learn(abrupt_change(0, noise=0.0)[:20])
    assert updates["icr_std"] == pytest.approx(updates["std"][:, 6:9], rel=1e-12)
    assert (learn(many_turns(0), model="none")[0]["icr_std"] == 0.0).all()


def test_icrs_of_a_turn_are_known_better_than_the_parameters():
    """Three parameters make each; in one turn only their sum shows. The truth lies within 4 of its deviations."""
    for seed in range(5):
        updates, _ = learn(abrupt_change(seed))
        late = updates[updates["pose"]["time"] > 5.0]
        assert (late["icr_std"] < late["std"][:, 6:9]).all()
        assert (np.abs(late["icr"] - [2.232, -2.232, 0.5]) < 4.0 * late["icr_std"]).mean() > 0.99


def test_standard_deviations_cover_the_truth():
    """Of a constant turn the ICRs are known; their error is within 3.5 sigma of the offsets' covariance."""
    for seed in range(10):
        _, learner = learn(abrupt_change(seed), model="constant")
        slip = learner.learned()
        off = slip.p[6:9] - [1.0, -1.0, 0.5]
        assert off @ np.linalg.solve(slip.covariance[6:9, 6:9], off) < 3.5**2 + 3.0


@pytest.mark.parametrize("size", [1, 7, 3000])
def test_blocks_do_not_matter(size):
    rows = many_turns(2, 600)
    whole, _ = learn(rows)
    learner = LogFilter(FilterSettings(GAUGE))
    parts = [learner.feed(rows[i : i + size]) for i in range(0, len(rows), size)]
    joined = np.concatenate([*parts, learner.finish()])
    for name in ("p", "std", "innovation", "error", "no_slip_error", "icr", "icr_std", "no_slip", "actual"):
        assert np.array_equal(joined[name], whole[name], equal_nan=True)
    assert joined["pose"].tolist() == whole["pose"].tolist()


def test_updates_appear_when_the_later_pose_does():
    rows = many_turns(3, 100)
    learner = LogFilter(FilterSettings(GAUGE))
    assert len(learner.feed(rows[:20])) == 0
    assert learner.feed(rows[20:40])["pose"]["time"] == pytest.approx(rows[:20, 0])
    assert len(learner.finish()) == 20
    assert len(LogFilter(FilterSettings(GAUGE, horizon=0.0)).feed(rows)) == 100


def test_a_turn_over_half_a_circle_is_no_jump():
    rows = many_turns(4)
    wrapped = rows.copy()
    wrapped[:, 5] = (rows[:, 5] + np.pi) % (2 * np.pi) - np.pi
    here, there = learn(rows)[0], learn(wrapped)[0]
    assert there["p"] == pytest.approx(here["p"], abs=1e-6)
    assert there["error"] == pytest.approx(here["error"], abs=1e-6, nan_ok=True)


@pytest.mark.parametrize("turn", [0.7, -2.5])
def test_the_frame_does_not_matter(turn):
    rows = many_turns(5, 600)
    moved = rows.copy()
    cos, sin = np.cos(turn), np.sin(turn)
    moved[:, 3] = 100.0 + cos * rows[:, 3] - sin * rows[:, 4]
    moved[:, 4] = -50.0 + sin * rows[:, 3] + cos * rows[:, 4]
    moved[:, 5] += turn
    assert learn(moved)[0]["p"] == pytest.approx(learn(rows)[0]["p"], abs=1e-6)


def test_a_gap_breaks_windows_and_predictions():
    rows = many_turns(6)
    cut = np.delete(rows, range(500, 620), axis=0)
    updates, learner = learn(cut)
    assert learner.gaps == 1
    before = (updates["pose"]["time"] > 48.05) & (updates["pose"]["time"] < 50.0)
    assert np.isnan(updates["error"][before]).all()
    assert mean_errors(updates)[0, 0] < 1.3 * mean_errors(learn(rows)[0])[0, 0]


def test_a_clock_set_back_starts_the_history_anew():
    rows = many_turns(7)
    rows[600:, 0] -= 1000.0
    updates, _ = learn(rows)
    assert len(updates) == len(rows)
    assert (reductions(mean_errors(updates)) > 60.0).all()


def test_held_poses_are_not_taken_for_new_ones():
    rows = many_turns(8)
    rows[1::2, 3:] = rows[::2, 3:]
    updates, learner = learn(rows)
    assert learner.held == 600
    assert len(updates) == 600
    assert (reductions(mean_errors(updates)) > 60.0).all()


def test_late_rows_and_rows_without_a_time_are_skipped():
    rows = many_turns(9, 200)
    rows[[50, 51]] = rows[[51, 50]]
    rows[100, 0] = NAN
    updates, learner = learn(rows)
    assert learner.skipped == 2
    assert len(updates) == 198


def test_speeds_and_poses_in_rows_of_their_own():
    """As when two topics are merged: the motion is the same, whichever rows hold the poses."""
    rows = many_turns(10, 600)
    speeds, poses = rows.copy(), rows.copy()
    speeds[:, 3:], poses[:, 1:3] = NAN, NAN
    merged = np.stack((speeds, poses), axis=1).reshape(-1, 6)
    assert mean_errors(learn(merged)[0]) == pytest.approx(mean_errors(learn(rows)[0]), rel=0.05)


def delayed(rows, delay):
    """The poses of a while before, in the rows of now."""
    then = np.column_stack([np.interp(rows[:, 0] - delay, rows[:, 0], rows[:, column]) for column in (3, 4, 5)])
    return np.column_stack((rows[:, :3], then))


FUZZ = {
    "dropped": lambda rows, pick, random: rows[~pick],
    "duplicated": lambda rows, pick, random: np.repeat(rows, 1 + pick, axis=0),
    "swapped": lambda rows, pick, random: rows[np.argsort(np.arange(len(rows)) + 1.5 * pick, kind="stable")],
    "no numbers": lambda rows, pick, random: np.where(random.random(rows.shape) < 0.05, NAN, rows),
    "pose outliers": lambda rows, pick, random: rows + pick[:, None] * [0, 0, 0, 10, -10, 2] * np.sin(rows[:, :1]),
    "small pose outliers": lambda rows, pick, random: rows + pick[:, None] * [0, 0, 0, 0.5, -0.5, 0.1],
    "speed spikes": lambda rows, pick, random: rows + pick[:, None] * [0, 5, -3, 0, 0, 0],
    "absurd speeds": lambda rows, pick, random: np.where(pick[:, None], rows * [1, 1e300, -1e200, 1, 1, 1], rows),
    "clock errors": lambda rows, pick, random: rows + (pick * random.normal(0, 100, len(rows)))[:, None] * np.eye(6)[0],
}
FUZZ |= {
    "late rows": lambda rows, pick, random: rows[np.argsort(rows[:, 0] + pick * random.uniform(0.1, 0.5, len(rows)))],
    "old poses": lambda rows, pick, random: delayed(rows, pick * random.uniform(0.1, 0.5, len(rows))),
    "poses at odd times": lambda rows, pick, random: delayed(rows, random.uniform(0.0, 0.1, len(rows))),
}


@pytest.mark.parametrize("kind", FUZZ)
@pytest.mark.parametrize("model", ["parametric", "factors"])
def test_a_log_with_faults_still_teaches(kind, model):
    for seed in range(3):
        rows, random = many_turns(seed), np.random.default_rng(seed)
        updates, learner = learn(FUZZ[kind](rows, random.random(len(rows)) < 0.05, random), model=model)
        assert np.isfinite(updates["p"]).all()
        assert np.isfinite(learner.learned().covariance).all()
        assert (reductions(mean_errors(updates)) > 50.0).all()
        assert np.median(np.abs(updates["icr"][len(updates) // 4 :, 2] - 0.2)) < 0.15


@pytest.mark.parametrize("model", ["parametric", "factors"])
@pytest.mark.parametrize(("delay", "most"), [(0.1, 0.5), (0.2, 0.9), (0.5, 1.5), (1.0, 1.5)])
def test_poses_that_all_come_late_do_no_harm(delay, most, model):
    """Less is learned, and at half a second about nothing; errors stay within the bound of `doubt`, as does P."""
    for seed in range(3):
        rows = many_turns(seed)
        updates, learner = learn(delayed(rows, delay), model=model)
        errors, covariance = mean_errors(updates), learner.learned().covariance
        assert (errors[0] <= most * errors[1]).all()
        assert np.linalg.eigvalsh(covariance).min() > -1e-9
        assert (
            np.sqrt(covariance.diagonal()) <= 2.0 * prior_std(FilterSettings(GAUGE, SlipModel(model))) * (1.0 + 1e-9)
        ).all()
        assert np.abs(updates["icr"]).max() <= 5.0 * GAUGE * (1.0 + 1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_noise_without_meaning_does_no_harm(seed):
    random = np.random.default_rng(seed)
    rows = random.standard_normal((3000, 6)) * 10.0 ** random.integers(-320, 300, (3000, 6))
    if seed % 2:
        rows[:, 0] = 0.1 * np.arange(3000)
    if seed == 3:
        rows = np.where(random.random(rows.shape) < 0.3, np.inf, random.standard_normal(rows.shape))
        rows[:, 0] = 0.1 * np.arange(3000)
    updates, learner = learn(rows)
    assert np.isfinite(updates["p"]).all()
    assert np.linalg.eigvalsh(learner.learned().covariance).min() > -1e-9
    assert np.abs(updates["icr"]).max(initial=0.0) <= 5.0 * GAUGE * (1.0 + 1e-12)


def test_what_leads_astray_is_forgotten():
    """Poses of another drive: what is learned from them must not stay worse than nothing."""
    rows = many_turns(0, 3000)
    rows[:, 3:] = many_turns(99, 3000)[:, 3:]
    errors = mean_errors(learn(rows)[0])
    assert (errors[0] <= 1.6 * errors[1] + 0.1).all()


def test_prediction_with_a_known_model():
    """With the truth's parameters the errors are those of the sensors, and their spread is as stated."""
    rows = abrupt_change(0, end=60.0)[20:]
    p = np.zeros(11)
    p[6:9] = 1.0, -1.0, 0.5
    known = LearnedSlip(p, np.zeros((11, 11)), 0.0, 0.0)
    learner = LogFilter(FilterSettings(GAUGE), known)
    updates = np.concatenate([learner.feed(rows), learner.finish()])
    assert len(updates) == len(rows)
    assert not np.isnan(updates["predicted"]).any()
    later = updates["pose"][20:]
    off = updates["predicted"][:-20] - np.column_stack((later["x"], later["y"], later["yaw"]))
    # The later pose is measured, too.
    spread = off / np.sqrt(updates["predicted_std"][:-20] ** 2 + [0.02**2, 0.02**2, np.radians(0.1) ** 2])
    assert np.sqrt(np.mean(spread**2, axis=0)) == pytest.approx(np.ones(3), rel=0.35)
    assert np.array_equal(learner.learned().p, p)


def test_the_last_row_holds_on_at_the_end_of_a_log():
    rows = np.array([[0.0, 1.0, 1.0, 0.0, 0.0, 0.0], [0.1, 2.0, 2.0, 0.1, 0.0, 0.0]])
    known = LearnedSlip(np.zeros(11), np.zeros((11, 11)), 0.0, 0.0)
    learner = LogFilter(FilterSettings(GAUGE), known)
    updates = np.concatenate([learner.feed(rows), learner.finish()])
    assert updates["predicted"][:, 0] == pytest.approx([0.1 + 1.9 * 2.0, 0.1 + 2.0 * 2.0])


def test_prediction_covariance_is_that_of_samples():
    random = np.random.default_rng(0)
    rows = many_turns(3, 40)
    rows[1:, 3:] = NAN
    p, root = np.zeros(11), np.diag([0.0] * 6 + [0.05, 0.04, 0.08, 0.0, 0.0])
    root[7, 6] = 0.03

    def predicted(p, covariance=None):
        known = LearnedSlip(p, np.zeros((11, 11)) if covariance is None else covariance, 0.0, 0.0)
        learner = LogFilter(FilterSettings(GAUGE), known)
        return np.concatenate([learner.feed(rows), learner.finish()])[0]

    poses = [predicted(p + root @ random.standard_normal(11))["predicted"] for _ in range(500)]
    spread = predicted(p, root @ root.T)["predicted_std"] ** 2 - predicted(p)["predicted_std"] ** 2
    assert np.sqrt(spread) == pytest.approx(np.std(poses, axis=0), rel=0.1)
