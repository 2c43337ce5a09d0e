import csv
import io
import json
import math
import os
import subprocess
import sys

import numpy as np
import pytest
from system_words import IS_FOLDER
from typer.testing import CliRunner

from trackctl.cli.app import app
from trackctl.files.profile_yaml import load_vehicle, vehicle_to_yaml

COLUMNS = [
    "arc_length_m",
    "time_s",
    "x_m",
    "y_m",
    "yaw_rad",
    "yaw_rate_radps",
    "speed_mps",
    "slip_angle_rad",
    "yaw_gradient_1pm",
    "icr_offset_m",
    "force_total_n",
    "force_difference_n",
    "force_left_n",
    "force_right_n",
    "friction_moment_nm",
    "constraint_residual",
    "feasible",
]
SIMULATED = [
    "simulated_x_m",
    "simulated_y_m",
    "simulated_yaw_rad",
    "simulated_yaw_rate_radps",
    "simulated_speed_mps",
    "simulated_slip_angle_rad",
]
STEADY = ("--speed-profile", "constant", "--speed-mps", 4, "--gravity-mps2", 9.81)


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return lambda *words, stdin=None: CliRunner().invoke(app, ["forces", *map(str, words)], input=stdin)


def table(text):
    rows = list(csv.DictReader(io.StringIO(text)))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def path_text(x, y, end="\n", digits=None):
    def cell(value):
        return repr(float(value)) if digits is None else f"{value:.{digits}f}"

    return end.join(["x_m,y_m", *(f"{cell(a)},{cell(b)}" for a, b in zip(x, y, strict=True)), ""])


def straight_and_arc():
    s = np.arange(0.0, 30.0, 0.1)
    bend = np.maximum(s - 15.0, 0.0) / 8.0
    return path_text(np.minimum(s, 15.0) + 8.0 * np.sin(bend), 8.0 * (1.0 - np.cos(bend)))


def test_without_arguments_it_is_the_papers_example(run):
    result = run()
    assert result.exit_code == 0
    found = table(result.stdout)
    assert list(found) == COLUMNS
    assert found["arc_length_m"][-1] == pytest.approx(10.0 * math.pi)
    assert found["speed_mps"][[0, -1]] == pytest.approx(0.2)
    assert found["speed_mps"].max() == pytest.approx(3.0)
    assert found["feasible"].all()
    # a left turn
    assert (found["slip_angle_rad"] < 0.0).all()
    assert (found["yaw_rate_radps"] > 0.0).all()
    assert "the acceleration jumps at 1 place" in result.stderr
    assert "all 315 stations are drivable" in result.stderr


def test_columns_agree_with_each_other(run):
    found = table(run("--clothoid", "6,8,5,8", "--speed-profile", "smooth", "--speed-mps", 2).stdout)
    left, right = found["force_left_n"], found["force_right_n"]
    assert left + right == pytest.approx(found["force_total_n"])
    assert right - left == pytest.approx(found["force_difference_n"])
    assert found["yaw_rate_radps"] == pytest.approx(found["yaw_gradient_1pm"] * found["speed_mps"])
    tangent = found["yaw_rad"] + found["slip_angle_rad"]
    way = np.gradient(found["x_m"], found["arc_length_m"]), np.gradient(found["y_m"], found["arc_length_m"])
    assert tangent[5:-5] == pytest.approx(np.unwrap(np.arctan2(way[1], way[0]))[5:-5], abs=1e-3)


def test_a_verified_table_holds_the_simulated_motion(run, tmp_path):
    """It starts as the nominal one, and leaves it as far as the summary says."""
    summary = json.loads(run("--basis", "polynomial", "--verify", "--json", "-o", "out.csv").stdout)
    found = table((tmp_path / "out.csv").read_text())
    assert list(found) == COLUMNS + SIMULATED
    off = np.hypot(found["simulated_x_m"] - found["x_m"], found["simulated_y_m"] - found["y_m"])
    # the largest distance may lie between two stations
    assert off.max() == pytest.approx(summary["max_deviation_m"], rel=0.01)
    assert [found[name][0] for name in SIMULATED] == pytest.approx(
        [found[name.removeprefix("simulated_")][0] for name in SIMULATED]
    )


def test_simulated_columns_agree_with_each_other(run):
    """Velocity and yaw rate are the derivatives of the simulated pose, the slip angle its direction minus the yaw."""
    found = table(run("--basis", "polynomial", "--order", 1, "--verify").stdout)
    time, inner = found["time_s"], slice(10, -10)
    x_rate, y_rate, turn = (np.gradient(found[f"simulated_{name}"], time)[inner] for name in ("x_m", "y_m", "yaw_rad"))
    assert np.hypot(x_rate, y_rate) == pytest.approx(found["simulated_speed_mps"][inner], rel=5e-3)
    assert turn == pytest.approx(found["simulated_yaw_rate_radps"][inner], rel=0.02)
    course = np.unwrap(np.arctan2(y_rate, x_rate))
    slip_angle = course - found["simulated_yaw_rad"][inner]
    assert slip_angle == pytest.approx(found["simulated_slip_angle_rad"][inner], abs=5e-3)


@pytest.mark.parametrize("words", [(), ("--basis", "polynomial"), ("--basis", "polynomial", "--order", 7)])
def test_the_exact_circle(run, words):
    found = table(run(*STEADY, *words).stdout)
    assert found["slip_angle_rad"] == pytest.approx(-0.1616753206, rel=1e-9)
    assert found["icr_offset_m"] == pytest.approx(0.8048595221, rel=1e-9)
    assert found["force_total_n"] == pytest.approx(1030.220188, rel=1e-9)
    assert found["force_difference_n"] == pytest.approx(8769.358207, rel=1e-9)


def test_waypoints_of_a_circle_come_close_to_it_whatever_the_line_ends(run):
    angle = np.linspace(0.0, 2.0 * np.pi, 201)
    x, y = 5.0 * np.sin(angle), 5.0 - 5.0 * np.cos(angle)
    for text, tolerance in ((path_text(x, y), 1e-4), (path_text(x, y, end="\r\n", digits=6), 5e-3)):
        found = table(run("-", *STEADY, stdin=text).stdout)
        assert found["force_difference_n"] == pytest.approx(8769.358207, rel=tolerance)
        assert found["slip_angle_rad"] == pytest.approx(-0.1616753206, rel=tolerance)


def test_speeds_of_the_csv_are_driven(run, tmp_path):
    x = np.linspace(0.0, 20.0, 201)
    speed = np.sqrt(0.5 * np.minimum(x, 20.0 - x) * (1.0 + 0.0 * x))
    rows = [f"{a},{0.0},{b}" for a, b in zip(x, speed, strict=True)]
    (tmp_path / "path.csv").write_text("\n".join(["x_m,y_m,velocity_mps", *rows]))
    found = table(run("path.csv").stdout)
    assert found["speed_mps"][[0, -1]] == pytest.approx(0.0, abs=0.05)
    # the kink in the middle is rounded
    assert found["speed_mps"].max() == pytest.approx(math.sqrt(5.0), rel=0.01)
    assert found["time_s"][-1] == pytest.approx(2.0 * math.sqrt(5.0) / 0.25, rel=0.01)
    over = table(run("path.csv", "--speed-profile", "constant", "--speed-mps", 2).stdout)
    assert (over["speed_mps"] == 2.0).all()


def test_its_own_table_is_a_path(run, tmp_path):
    smooth = ("--speed-profile", "smooth")
    (tmp_path / "first.csv").write_text(run("--clothoid", "8,8,5,8", *smooth).stdout)
    first, second = table((tmp_path / "first.csv").read_text()), table(run("first.csv").stdout)
    assert second["time_s"][-1] == pytest.approx(first["time_s"][-1], rel=1e-4)
    assert second["force_total_n"][100] == pytest.approx(
        np.interp(second["arc_length_m"][100], first["arc_length_m"], first["force_total_n"]), rel=0.01
    )


def test_a_straight_that_meets_an_arc_is_not_drivable_until_it_is_rounded(run):
    words = ("-", "--speed-profile", "constant", "--speed-mps", 1.5, "--json")
    result = run(*words, stdin=straight_and_arc())
    assert result.exit_code == 0
    summary = json.loads(result.stdout)
    assert not summary["feasible"]
    assert "not drivable" in result.stderr
    strict = run(*words, "--strict", stdin=straight_and_arc())
    assert strict.exit_code == 1
    assert json.loads(strict.stdout) == summary
    rounded = run(*words, "--strict", "--transition-length-m", 8, "--verify", stdin=straight_and_arc())
    assert rounded.exit_code == 0
    assert json.loads(rounded.stdout)["feasible"]
    assert json.loads(rounded.stdout)["max_deviation_m"] < 1e-5
    assert "rounding moves the path by up to 0.1" in rounded.stderr


def test_a_clothoid_without_length_is_a_jump(run):
    words = ("--clothoid", "8,0,10,8", "--speed-mps", 1, "--json", "--strict")
    refused = run(*words)
    assert refused.exit_code == 1
    assert json.loads(refused.stdout)["infeasible"]["curvature_jump"] == 1
    assert run(*words, "--transition-length-m", 8).exit_code == 0


def test_too_fast_is_said_station_by_station(run):
    words = ("--speed-profile", "constant", "--gravity-mps2", 9.81)
    assert table(run(*words, "--speed-mps", 6.54).stdout)["feasible"].all()
    assert not table(run(*words, "--speed-mps", 6.55).stdout)["feasible"].any()
    assert "D beyond L/2" in run(*words, "--speed-mps", 6.55, "--strict").stderr


def test_verify_says_how_far_the_forces_err(run):
    words = ("--verify", "--json", "--quiet", "--gravity-mps2", 9.81)
    smooth = run(*words, "--speed-profile", "smooth")
    assert (smooth.exit_code, smooth.stderr) == (0, "")
    assert json.loads(smooth.stdout)["max_deviation_m"] < 1e-5
    paper = json.loads(run(*words, "--basis", "polynomial").stdout)
    assert paper["max_deviation_m"] == pytest.approx(0.042, rel=0.05)
    assert set(paper) > {"max_residual", "feasible", "required_friction_coefficient"}


def test_optimal_speed_on_a_circle_is_the_limit(run):
    words = ("--speed-profile", "optimal", "--arc-deg", 720, "--gravity-mps2", 9.81, "--strict", "--json")
    summary = json.loads(run(*words, "-o", "fast.csv").stdout)
    assert 0.995 * 6.5433 < summary["max_speed_mps"] < 6.5433
    assert json.loads(run(*words, "--speed-mps", 3).stdout)["max_speed_mps"] == pytest.approx(3.0)


def test_a_slope_and_a_terrain(run):
    level, steep = (json.loads(run("--json", "--slope-deg", angle).stdout) for angle in (0, 8))
    assert steep["required_friction_coefficient"] > level["required_friction_coefficient"]
    assert run("--terrain", "snow", "--speed-mps", 5, "--strict").exit_code == 1
    assert run("--vehicle", "m113", "--circle-radius-m", -20).exit_code == 0


def test_output_file_and_step(run, tmp_path):
    assert run("-o", "out.csv", "--step-m", 5).stdout == ""
    assert len(table((tmp_path / "out.csv").read_text())["time_s"]) == 8 + 1  # the peak is a station, too
    assert run("-o", "out.csv").exit_code == 2
    assert run("-o", "out.csv", "--force").exit_code == 0


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["--circle-radius-m", 0], "--circle-radius-m: 0.0 is not allowed; allowed: 0.01 to 1e+06"),
        (["--circle-radius-m", "nan"], "--circle-radius-m: nan is not allowed"),
        (["--circle-radius-m", 1e6], "--arc-deg: 360.0 is not allowed; allowed: a path longer than 0 and up to 100000"),
        (["--arc-deg", -90], "--arc-deg: -90.0 is not allowed; allowed: above 0 to 36000"),
        (["--clothoid", "5,4,6"], "--clothoid: 5,4,6 is not allowed; allowed: RADIUS,ENTRY,ARC,EXIT"),
        (["--clothoid", "5,4,-6,4"], "--clothoid: 5,4,-6,4 is not allowed"),
        (["--clothoid", "5,0,0,0"], "--clothoid: 0,0,0 is not allowed; allowed: a path longer than 0"),
        (
            ["--clothoid", "5,4,6,4", "--arc-deg", 9],
            "--arc-deg: 9.0 is not allowed; allowed: nothing beside --clo",
        ),
        (["--speed-mps", 0], "--speed-mps: 0.0 is not allowed; allowed: above 0 to 100"),
        (["--speed-mps", -1], "--speed-mps: -1.0 is not allowed"),
        (["--speed-mps", 1e9], "--speed-mps: 1000000000.0 is not allowed"),
        (["--speed-start-mps", -1], "--speed-start-mps: -1.0 is not allowed; allowed: 0 to 100"),
        (["--speed-start-mps", 5], "--speed-start-mps: 5.0 is not allowed; allowed: up to the peak, 3 m/s"),
        (
            ["--speed-start-mps", 0, "--speed-profile", "smooth"],
            "--speed-start-mps: 0.0 is not allowed; allowed: above",
        ),
        (["--speed-start-mps", 1, "--speed-profile", "constant"], "allowed: nothing with --speed-profile constant"),
        (["--order", 3], "--order: 3 is not allowed; allowed: a number beside --basis polynomial"),
        (["--order", -1, "--basis", "polynomial"], "--order"),
        (["--step-m", 0], "--step-m: 0.0 is not allowed; allowed: above 0 or more"),
        (["--step-m", 1e-9], "--step-m: 1e-09 is not allowed; allowed: 3.14159e-05 or more"),
        (["--transition-length-m", 2], "--transition-length-m: 2.0 is not allowed; allowed: nothing with a circle"),
        (["--slope-deg", 45], "--slope-deg: 45.0 is not allowed; allowed: 0 and below 45"),
        (["--vehicle", "tank"], "no vehicle profile has this name"),
        (["nothing.csv"], "nothing.csv: cannot be read"),
        (["."], f".: cannot be read: {IS_FOLDER}"),
        (["-", "--arc-deg", 90], "--arc-deg: 90.0 is not allowed; allowed: nothing beside a CSV"),
    ],
)
def test_wrong_usage_exits_2(run, words, problem):
    result = run(*words)
    assert (result.exit_code, result.stdout) == (2, "")
    assert problem in result.stderr


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "<stdin>, line 1: is empty"),
        ("0,0\n1,1\n", "<stdin>, line 1: begins with numbers"),
        ("x_m,y_m\n0,0\n", "<stdin>: has 1 waypoints at one place"),
        ("x_m,y_m\n0,0\n1,nan\n", "<stdin>, line 3: column y_m: 'nan' is not allowed"),
        ("x_m,y_m\n0,0\n2,0\n1,0\n", "<stdin>, line 3: the path turns back here"),
        ("x_m,y_m,speed_mps\n0,0,0\n1,0,0\n", "<stdin>: all speeds are 0"),
        ("x_m,y_m,speed_mps\n0,0,1\n1,0,-2\n", "<stdin>, line 3: column speed_mps: '-2' is not allowed"),
        ("x_m,y_m\n0,0\n1e6,0\n", "<stdin>: the path is 1e+06 m long; allowed: up to 100000 m"),
    ],
)
def test_what_is_no_path_exits_2(run, text, problem):
    result = run("-", stdin=text)
    assert (result.exit_code, result.stdout) == (2, "")
    assert problem in result.stderr


def test_a_drive_too_weak_to_turn_has_no_optimal_speed(run, tmp_path):
    weak = vehicle_to_yaml(load_vehicle("m113")) + "max_track_force_n: 100\n"
    (tmp_path / "weak.yaml").write_text(weak)
    result = run("--speed-profile", "optimal", "--vehicle", "weak.yaml")
    assert (result.exit_code, result.stdout) == (1, "")
    assert "found no speed along this path" in result.stderr


def test_a_closed_pipe_ends_quietly():
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "trackctl", "forces", "--quiet"]
    done = subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writing)
    assert (done.returncode, done.stderr) == (0, "")


def test_ten_kilometres_of_waypoints(run, tmp_path):
    heading = np.cumsum(0.002 * np.sin(np.arange(100_000) / 800.0))
    x, y = np.cumsum(0.1 * np.cos(heading)), np.cumsum(0.1 * np.sin(heading))
    (tmp_path / "long.csv").write_text(path_text(x, y))
    result = run("long.csv", "-o", "out.csv", "--json", "--speed-profile", "smooth")
    summary = json.loads(result.stdout)
    assert summary["length_m"] == pytest.approx(1e4, rel=1e-4)
    assert summary["feasible"]
    assert summary["max_residual"] < 1e-8
