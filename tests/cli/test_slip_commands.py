"""`identify`, `predict` and `calibrate` as a user meets them."""

import csv
import io
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from shear_log import shear_log
from slip_simulation import abrupt_change, as_csv, many_turns, step
from typer.testing import CliRunner

from trackctl.cli.app import app
from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.files.slip_yaml import read_slip
from trackctl.identification.steady_motion import steady_motions
from trackctl.mechanics.parameters import track_model

HUSKY = "logs/husky_chained_fresh.csv"
CARRIER = ("--vehicle", "carrier-13t6")
IDENTIFY_COLUMNS = [
    "time_s", "icr_left_m", "icr_right_m", "icr_x_m", *(f"p{i}" for i in range(1, 10)),
    *(f"p{i}_std" for i in range(1, 10)), "innovation_x_m", "innovation_y_m", "innovation_yaw_rad", "accepted",
    "position_error_m", "yaw_error_rad", "no_slip_position_error_m", "no_slip_yaw_error_rad",
    "icr_left_std_m", "icr_right_std_m", "icr_x_std_m",
]  # fmt: skip
PREDICT_COLUMNS = [
    "time_s", "horizon_s", "x_m", "y_m", "yaw_rad", "x_std_m", "y_std_m", "yaw_std_rad",
    "position_error_m", "yaw_error_rad", "no_slip_position_error_m", "no_slip_yaw_error_rad",
    *(f"{pose}_{name}" for pose in ("start", "no_slip", "actual") for name in ("x_m", "y_m", "yaw_rad")),
]  # fmt: skip


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return lambda *words, stdin=None: CliRunner().invoke(app, [*map(str, words)], input=stdin)


@pytest.fixture
def log(run):
    Path("log.csv").write_text(as_csv(abrupt_change(0)))
    return "log.csv"


def rows(text):
    return list(csv.DictReader(io.StringIO(text)))


def test_identify_prints_one_row_for_each_pose(run, log):
    result = run("identify", log, *CARRIER)
    table = rows(result.stdout)
    assert result.exit_code == 0
    assert list(table[0]) == IDENTIFY_COLUMNS
    assert [float(row["time_s"]) for row in table] == pytest.approx(0.1 * np.arange(141))
    late = [float(row["icr_left_m"]) for row in table if float(row["time_s"]) > 4.0]
    assert late == pytest.approx([2.232] * len(late), abs=0.2)
    assert table[-21]["position_error_m"]
    assert not table[-20]["position_error_m"]


def test_identify_summary_is_the_mean_of_its_rows(run, log):
    result = run("identify", log, *CARRIER, "--json", "-o", "updates.csv", "--save", "slip.yaml")
    summary, table = json.loads(result.stdout), rows(Path("updates.csv").read_text())
    assert (summary["horizon_s"], summary["updates"]) == (2.0, 141)
    assert summary["rejected"] == sum(row["accepted"] == "0" for row in table)
    for key, column in (("position_error_m", "position_error_m"), ("heading_error_rad", "yaw_error_rad")):
        model = np.mean([float(row[column]) for row in table if row[column]])
        no_slip = np.mean([float(row[f"no_slip_{column}"]) for row in table if row[column]])
        assert summary[key]["model"] == pytest.approx(model)
        assert summary[key]["no_slip"] == pytest.approx(no_slip)
        assert summary[key]["reduction_percent"] == pytest.approx(100 * (1 - model / no_slip))
    slip = read_slip("slip.yaml")
    assert (slip.vehicle, slip.track_gauge, slip.log, slip.updates) == ("carrier-13t6", 2.464, "log.csv", 141)
    assert summary["parameters"]["p7"]["value"] == float(table[-1]["p7"])
    assert summary["parameters"]["p7"]["std"] == float(table[-1]["p7_std"])


def learned_and_predicted(run, text, vehicle):
    """Reductions of the errors over a log by what is learned from its first 600 rows. [%]"""
    lines = text.splitlines(keepends=True)
    Path("first.csv").write_text("".join(lines[:601]))
    Path("second.csv").write_text(lines[0] + "".join(lines[601:]))
    run("identify", "first.csv", "--vehicle", vehicle, "--save", "slip.yaml", "-o", "updates.csv")
    summary = json.loads(run("predict", "second.csv", "--json").stdout)
    return [summary[key]["reduction_percent"] for key in ("position_error_m", "heading_error_rad")]


def test_the_saved_model_predicts_other_stretches(run):
    """It is of the ground of the log rather than of its last turn."""
    position, heading = learned_and_predicted(run, as_csv(shear_log("utv-61cm", "asphalt", 1.8)[0]), "utv-61cm")
    assert position > 60.0
    assert heading > 75.0


def test_the_saved_model_predicts_other_stretches_of_a_real_log(run, data_of_others):
    """A minute of ten commands is little to learn from."""
    position, heading = learned_and_predicted(run, data_of_others(HUSKY).read_text(), "husky")
    assert position > 0.0
    assert heading > 75.0


@pytest.mark.parametrize(
    ("model", "zero"), [("paper", (7, 8, 9)), ("constant", (1, 6)), ("none", (1, 9)), ("factors", ())]
)
@pytest.mark.parametrize("kind", ["window", "velocity"])
def test_models_and_filters(run, log, model, zero, kind):
    result = run("identify", log, *CARRIER, "--model", model, "--filter", kind)
    table = rows(result.stdout)
    assert ("p11_std" in table[0]) == (model == "factors")
    assert all(float(row[f"p{i}"]) == 0.0 for row in table for i in zero)
    moved = model != "none"
    assert any(float(row["p1"]) or float(row["p7"]) for row in table) == moved


def identified(run, log, vehicle, model):
    """Reductions of the errors. [%]"""
    summary = json.loads(run("identify", log, "--vehicle", vehicle, "--model", model, "--json").stdout)
    return np.array([summary[key]["reduction_percent"] for key in ("position_error_m", "heading_error_rad")])


def test_ground_that_shears(run):
    """A simulated drive whose slip no model makes; p10 and p11 tell that the encoders read 15 % too much."""
    Path("log.csv").write_text(as_csv(shear_log("utv-61cm", "asphalt", 1.8, read_over_true=1.15)[0]))
    parametric, constant, factors = (
        identified(run, "log.csv", "utv-61cm", model) for model in ("parametric", "constant", "factors")
    )
    assert (parametric >= [50.0, 85.0]).all()
    assert (parametric >= constant - 4.0).all()
    assert (factors >= [80.0, 85.0]).all()


def test_the_real_log(run, data_of_others):
    """As of the document: at least 47 and 85 % less error, and no worse than constant ICRs by 2 points."""
    log = data_of_others(HUSKY)
    parametric = identified(run, log, "husky", "parametric")
    assert (parametric >= [47.0, 85.0]).all()
    assert (parametric >= identified(run, log, "husky", "constant") - 2.0).all()


def test_sprocket_rates_are_track_speeds_over_the_radius(run, log):
    table = np.genfromtxt(log, delimiter=",", skip_header=1)
    table[:, 1:3] /= load_vehicle("carrier-13t6").sprocket_radius
    header = "time_s,sprocket_rate_left_radps,sprocket_rate_right_radps,x_m,y_m,yaw_rad"
    np.savetxt("rates.csv", table, delimiter=",", header=header, comments="", fmt="%.17g")
    one, other = (rows(run("identify", name, *CARRIER).stdout)[-1] for name in (log, "rates.csv"))
    assert float(other["icr_left_m"]) == pytest.approx(float(one["icr_left_m"]))


def test_standard_input_gives_what_the_file_gives(run, log):
    expected = run("identify", log, *CARRIER).stdout
    for words in ((), ("-",)):
        assert run("identify", *words, *CARRIER, stdin=Path(log).read_text()).stdout == expected


def test_a_stream_prints_as_it_goes(tmp_path):
    """Rows come before the pipe closes."""
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parent.parent.parent)}
    command = [sys.executable, "-m", "trackctl", "identify", "-", *CARRIER, "--quiet"]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen(command, env=environment, **pipes) as process:
        process.stdin.write(as_csv(many_turns(0, 60)).encode())
        process.stdin.flush()
        seen = [process.stdout.readline() for _ in range(40)]
        assert seen[0].startswith(b"time_s,icr_left_m")
        assert all(seen)
        process.stdin.close()
        rest = process.stdout.read()
    assert len(rest.splitlines()) == 21
    assert process.returncode == 0


def test_predict_from_each_pose(run, log):
    run("identify", log, *CARRIER, "--save", "slip.yaml", "-o", "updates.csv")
    result = run("predict", log, "--slip", "slip.yaml", "--horizon-s", 1.5)
    table = rows(result.stdout)
    assert list(table[0]) == PREDICT_COLUMNS
    assert len(table) == 141
    assert {row["horizon_s"] for row in table} == {"1.5"}
    truth = np.genfromtxt(log, delimiter=",", skip_header=1)
    for row, later in zip(table[30:120], truth[45:135], strict=True):
        off = np.hypot(float(row["x_m"]) - later[3], float(row["y_m"]) - later[4])
        assert off == pytest.approx(float(row["position_error_m"]), abs=1e-9)
        assert off < 0.2
        assert abs(float(row["yaw_rad"]) - later[5]) < 5.0 * float(row["yaw_std_rad"]) + 0.01
    assert all(row["x_m"] for row in table)
    assert not table[-1]["position_error_m"]
    summary = json.loads(run("predict", log, "--slip", "slip.yaml", "--json").stdout)
    assert summary["predictions"] == 141
    assert summary["heading_error_rad"]["reduction_percent"] > 85.0


def test_the_poses_between_which_a_prediction_lies(run, log):
    """Where it starts, where the tracks lead without slip, and where the vehicle was."""
    run("identify", log, *CARRIER, "--save", "slip.yaml", "-o", "updates.csv")
    table = rows(run("predict", log, "--slip", "slip.yaml", "--horizon-s", 1.5).stdout)
    truth = np.genfromtxt(log, delimiter=",", skip_header=1)

    def pose(row, name):
        return np.array([float(row[f"{name}_{quantity}"] or "nan") for quantity in ("x_m", "y_m", "yaw_rad")])

    for first in (0, 15, 40, 125):
        row, end = table[first], truth[first, 3:]
        assert pose(row, "start") == pytest.approx(end)
        for left, right in truth[first : first + 15, 1:3]:
            end = step(end, 0.5 * (left + right), 0.0, (right - left) / 2.464, 0.1)
        assert pose(row, "no_slip") == pytest.approx(end, abs=1e-9)
        assert pose(row, "actual") == pytest.approx(truth[first + 15, 3:])
        off = pose(row, "no_slip") - pose(row, "actual")
        assert float(row["no_slip_position_error_m"]) == pytest.approx(np.hypot(off[0], off[1]))
        assert float(row["no_slip_yaw_error_rad"]) == pytest.approx(abs(off[2]))
    assert np.isfinite(pose(table[-1], "no_slip")).all()
    assert np.isnan(pose(table[-1], "actual")).all()


def test_what_identify_and_predict_write_is_drawn(run, log):
    run("identify", log, *CARRIER, "--save", "slip.yaml", "-o", "updates.csv")
    run("predict", log, "-o", "poses.csv")
    for name, kind in (("updates", "identification"), ("poses", "prediction")):
        result = run("plot", f"{name}.csv", "-o", f"{name}.svg")
        assert (result.exit_code, result.stderr) == (0, f"{name}.csv: {kind}, drawn to {name}.svg\n")


def test_a_single_pose_is_predicted_by_speeds_that_hold(run, log):
    run("identify", log, *CARRIER, "--model", "none", "--save", "slip.yaml", "-o", "updates.csv")
    line = "time_s,track_speed_left_mps,track_speed_right_mps,x_m,y_m,yaw_deg\n5,1,1,2,3,90\n"
    (row,) = rows(run("predict", stdin=line).stdout)
    assert (float(row["x_m"]), float(row["y_m"])) == pytest.approx((2.0, 5.0))


def test_predict_refuses_the_slip_of_another_vehicle(run, log):
    run("identify", log, *CARRIER, "--save", "slip.yaml", "-o", "updates.csv")
    assert run("predict", log, *CARRIER).exit_code == 0
    result = run("predict", log, "--vehicle", "m113")
    assert result.exit_code == 2
    assert "slip.yaml: is of carrier-13t6, track gauge 2.464 m" in result.stderr


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("identify", "none.csv"), "none.csv: cannot be read"),
        (("identify", "."), ".: cannot be read"),
        (("identify", "log.csv", "--window-s", "0"), "--window-s: 0.0 is not allowed; allowed: from 0.02 to 60"),
        (("identify", "log.csv", "--window-s", "nan"), "--window-s: nan is not allowed"),
        (("identify", "log.csv", "--horizon-s", "-1"), "--horizon-s: -1.0 is not allowed"),
        (("identify", "log.csv", "--horizon-s", "1e9"), "--horizon-s: 1000000000.0 is not allowed"),
        (("identify", "log.csv", "--model", "best"), "--model"),
        (("identify", "log.csv", "--filter", "best"), "--filter"),
        (("identify", "log.csv", "--vehicle", "none"), "no vehicle profile has this name"),
        (("identify", "log.csv", "-o", "log.csv"), "log.csv: exists already; --force replaces it"),
        (("identify", "log.csv", "--save", "log.csv"), "log.csv: exists already; --force replaces it"),
        (("identify", "log.csv", "--save", "a", "-o", "a"), "--save: a is not allowed"),
        (("identify", "log.csv", "--json", "-o", "-"), "--output: - is not allowed"),
        (("identify", "bad.csv"), "bad.csv, line 3: has 2 cells; the header has 6"),
        (("predict", "log.csv"), "slip.yaml: cannot be read"),
        (("predict", "log.csv", "--slip", "bad.csv"), "bad.csv"),
        (("predict", "log.csv", "--slip", "slip.txt", "--horizon-s", "0"), "slip.txt"),
        (("calibrate", "none.csv"), "none.csv: cannot be read"),
        (("calibrate", "bad.csv"), "bad.csv, line 3"),
        (("calibrate", "speeds.csv"), "speeds.csv: has neither time_s, x_m, y_m and yaw_rad nor forward_velocity_mps"),
        (("calibrate", "log.csv", "--gravity-mps2", "0"), "not allowed"),
        (("calibrate", "log.csv", "--terrain", "cheese"), "no terrain profile has this name"),
    ],
)
def test_bad_input_exits_2_with_one_message(run, log, words, message):
    header = Path(log).read_text().partition("\n")[0]
    Path("bad.csv").write_text(f"{header}\n0,1,1,0,0,0\n1,1\n")
    Path("speeds.csv").write_text("track_speed_left_mps,track_speed_right_mps\n1,1\n")
    result = run(*words)
    assert result.exit_code == 2
    assert message in result.stderr
    assert result.stderr.count("Error") == 1
    assert not Path("a").exists()


@pytest.mark.parametrize("command", ["identify", "predict", "calibrate"])
def test_a_log_without_an_answer_exits_1(run, log, command):
    run("identify", log, *CARRIER, "--save", "slip.yaml", "-o", "updates.csv")
    header = Path(log).read_text().partition("\n")[0]
    Path("blind.csv").write_text(header + "\n0,1,1,,,\n0.1,1,1,,,\n")
    if command == "calibrate":
        Path("blind.csv").write_text(header + "\n0,0,0,0,0,0\n0.1,0,0,0,0,0\n")
    result = run(command, "blind.csv")
    assert result.exit_code == 1
    assert "blind.csv: " in result.stderr


def test_a_fault_late_in_a_log_leaves_no_file(run, log):
    Path(log).write_text(Path(log).read_text() + "x\n")
    result = run("identify", log, *CARRIER, "-o", "updates.csv", "--save", "slip.yaml")
    assert result.exit_code == 2
    assert "log.csv, line 143" in result.stderr
    assert sorted(path.name for path in Path().iterdir()) == ["log.csv"]


def test_calibrate_finds_the_ground_of_a_log(run):
    """Turns of 3 s each, with the paper's sensor noise."""
    vehicle, random = load_vehicle("tracked-ugv-61kg"), np.random.default_rng(0)
    model = track_model(vehicle, load_terrain("asphalt"))._replace(friction=0.6, shear_modulus=0.02, resistance=0.1)
    speeds = random.uniform(0.7, 2.5, (60, 2))
    twists = steady_motions(model, speeds)
    known = np.isfinite(twists).all(axis=1)
    pose, log = (0.0, 0.0, 0.0), []
    for pair, twist in zip(speeds[known], twists[known], strict=True):
        for _ in range(30):
            noisy = np.array(pose) + random.standard_normal(3) * [0.02, 0.02, 0.002]
            log.append((0.1 * len(log), *(pair + 0.005 * random.standard_normal(2)), *noisy))
            pose = step(pose, *twist, 0.1)
    Path("log.csv").write_text(as_csv(np.array(log)))
    words = ("calibrate", "log.csv", "--vehicle", "tracked-ugv-61kg")
    result = run(*words, "-o", "ground.yaml", "--json")
    assert result.exit_code == 0
    summary = json.loads(result.stdout)
    ground = load_terrain(str(Path("ground.yaml").absolute()))
    for key, value, truth in (
        ("friction_coefficient", ground.friction_coefficient, 0.6),
        ("shear_deformation_modulus_m", ground.shear_deformation_modulus, 0.02),
        ("motion_resistance_coefficient", ground.motion_resistance_coefficient, 0.1),
    ):
        found = summary["parameters"][key]
        assert found["value"] == value
        assert found["determined"]
        assert abs(value - truth) < 4.0 * found["std"] + 0.05 * truth
    text = Path("ground.yaml").read_text()
    assert "# fitted, standard deviation" in text
    assert run(*words, "--quiet").stdout == text


STEADY_COLUMNS = (
    "track_speed_left_mps", "track_speed_right_mps", "forward_velocity_mps", "lateral_velocity_mps", "yaw_rate_radps",
)  # fmt: skip


def steady_table(top, ground, noise):
    """Rows of steady turns on known ground, up to a track speed; beside them a column that is not asked for."""
    random = np.random.default_rng(0)
    assumed = track_model(load_vehicle("tracked-ugv-61kg"), load_terrain("asphalt"))
    model = assumed._replace(friction=ground[0], shear_modulus=ground[1], resistance=ground[2])
    speeds = random.uniform(0.3 * top, top, (60, 2))
    twists = steady_motions(model, speeds)
    twists += noise * random.standard_normal(twists.shape)
    known = np.isfinite(twists).all(axis=1)
    table = np.column_stack((speeds, twists, np.arange(60)))[known]
    lines = [",".join((*STEADY_COLUMNS, "run")), *(",".join(map(repr, row)) for row in table.tolist())]
    return "\n".join(lines) + "\n"


def test_calibrate_reads_steady_motions(run):
    Path("turns.csv").write_text(steady_table(2.5, (0.4, 0.005, 0.03), 0.0025))
    parameters = json.loads(run("calibrate", "turns.csv", "--vehicle", "tracked-ugv-61kg", "--json").stdout)[
        "parameters"
    ]
    for key, truth in (
        ("friction_coefficient", 0.4),
        ("shear_deformation_modulus_m", 0.005),
        ("motion_resistance_coefficient", 0.03),
    ):
        assert parameters[key]["determined"]
        assert abs(parameters[key]["value"] - truth) < 4.0 * parameters[key]["std"] < truth


def assert_does_not_tell_the_modulus(result):
    assert result.exit_code == 0
    assert "the log does not determine K" in result.stderr
    (line,) = (line for line in result.stdout.splitlines() if line.startswith("shear_deformation_modulus_m"))
    assert "# not determined by the log" in line


def test_calibrate_says_what_it_cannot_tell(run):
    """Ground stiffer than any that is sought."""
    Path("turns.csv").write_text(steady_table(1.5, (0.4, 5e-5, 0.02), 0.001))
    assert_does_not_tell_the_modulus(run("calibrate", "turns.csv", "--vehicle", "tracked-ugv-61kg"))


def test_calibrate_says_what_another_simulator_s_table_cannot_tell(run, data_of_others):
    table = data_of_others("slip_tables/tracked_ugv_sim_mu0p4.csv")
    assert_does_not_tell_the_modulus(run("calibrate", table, "--vehicle", "tracked-ugv-61kg"))
