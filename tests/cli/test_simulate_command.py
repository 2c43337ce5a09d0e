import csv
import io
import json
import math
from pathlib import Path

import pytest
import yaml
from solved_tables import solved_table
from typer.testing import CliRunner

from trackctl.cli.app import app
from trackctl.files.lut_writer import write_lut

COLUMNS = [
    *("time_s", "x_m", "y_m", "yaw_rad", "forward_velocity_mps", "lateral_velocity_mps", "yaw_rate_radps"),
    *("track_speed_left_mps", "track_speed_right_mps", "slip_left", "slip_right", "load_left_n", "load_right_n"),
]
RATES = "time_s,sprocket_rate_left_radps,sprocket_rate_right_radps\n0,3,5\n2,3,5\n"


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return lambda *words, stdin=None: CliRunner().invoke(app, ["simulate", *map(str, words)], input=stdin)


def rows(text):
    return [
        {key: float(cell) if cell else math.nan for key, cell in row.items()}
        for row in csv.DictReader(io.StringIO(text))
    ]


def test_constant_speeds(run):
    result = run("--track-speeds-mps", "0.3,0.5", "--duration-s", 2)
    assert result.exit_code == 0, result.output
    found = rows(result.stdout)
    assert list(found[0]) == COLUMNS
    assert [row["time_s"] for row in found] == pytest.approx([0.1 * k for k in range(21)])
    assert found[0]["forward_velocity_mps"] == 0.0
    assert found[-1]["yaw_rad"] > 0.2


def test_sprocket_rates_and_degrees_a_second_are_the_same(run, tmp_path):
    (tmp_path / "a.csv").write_text(RATES)
    degrees = [f"{math.degrees(rate)}" for rate in (3, 5)]
    (tmp_path / "b.csv").write_text(
        "time_ms;sprocket_rate_left_degps;sprocket_rate_right_degps\r\n"
        + "".join(f"{t};{';'.join(degrees)}\r\n" for t in (0, 2000))
    )
    first, second, constant = run("a.csv"), run("b.csv"), run("--track-speeds-mps", "0.3,0.5", "--duration-s", 2)
    for one, other, third in zip(rows(first.stdout), rows(second.stdout), rows(constant.stdout), strict=True):
        assert other == pytest.approx(one, rel=1e-8, abs=1e-9)
        assert third == pytest.approx(one, rel=1e-8, abs=1e-9)


def test_standard_input_and_output_file(run, tmp_path):
    words = ("-", "-o", "out.csv", "--json")
    result = run(*words, stdin=RATES)
    assert (result.exit_code, json.loads(result.stdout)["laps"]) == (0, [])
    assert len(rows((tmp_path / "out.csv").read_text())) == 21
    assert run(*words, stdin=RATES).exit_code == 2
    assert run(*words, "--force", stdin=RATES).exit_code == 0


def test_laps_of_a_circle(run):
    result = run("--circle-radius-m", -1.5, "--speed-mps", 0.8, "--laps", 2, "--json", "--no-contact-memory")
    assert result.exit_code == 0, result.output
    summary = json.loads(result.stdout)
    assert [lap["radius_m"] for lap in summary["laps"]] == pytest.approx([1.5, 1.5], rel=0.005)
    assert summary["laps"][0]["centre_y_m"] == pytest.approx(-1.5, abs=0.01)
    assert summary["drift_m_per_lap"] < 0.02
    assert summary["max_deviation_m"] < 0.03


def test_feedback_brings_the_naive_reading_to_the_circle(run):
    words = ("--laps", 1, "--commands", "table", "--no-contact-memory", "--json")
    without, pose = (json.loads(run(*words, "--feedback", kind).stdout) for kind in ("none", "pose"))
    assert pose["max_deviation_m"] < 0.1 * without["max_deviation_m"]


def test_commands_from_a_table(run, tmp_path):
    write_lut(tmp_path / "lut.h5", solved_table())
    words = (
        "--lut",
        "lut.h5",
        "--slope-deg",
        12,
        "--circle-radius-m",
        4,
        "--speed-mps",
        1,
        "--laps",
        1,
        "--no-contact-memory",
        "--json",
    )
    by_table, naive = run(*words), run(*words, "--commands", "table")
    assert by_table.exit_code == naive.exit_code == 0
    deviations = [json.loads(result.stdout)["max_deviation_m"] for result in (by_table, naive)]
    assert deviations[0] < 0.5 * deviations[1]
    refused = run(*words, "--terrain", "clay")
    assert (refused.exit_code, "clay" in refused.stderr or "asphalt" in refused.stderr) == (2, True)


def test_track_forces_on_level_ground(run, tmp_path):
    (tmp_path / "forces.csv").write_text("time_s,force_left_n,force_right_n\n0,400,400\n2,400,400\n")
    result = run("forces.csv", "--vehicle", "shiller-1993")
    last = rows(result.stdout)[-1]
    assert last["forward_velocity_mps"] == pytest.approx(0.8, rel=1e-6)
    assert math.isnan(last["slip_left"])
    assert run("forces.csv", "--slope-deg", 5).exit_code == 2


def test_a_plan_starts_on_its_target_and_is_measured_against_it(run, tmp_path):
    lines = ["time_s,x_m,y_m,yaw_rad,velocity_mps,sprocket_rate_left_radps,sprocket_rate_right_radps,sideslip_rad"]
    lines += [f"{t},{0.5 * t + 1},2,0,0.5,5,5,0" for t in range(5)]
    (tmp_path / "plan.csv").write_text("\n".join(lines))
    result = run("plan.csv", "--slope-deg", 0, "--json", "-o", "out.csv")
    assert json.loads(result.stdout)["max_deviation_m"] < 0.02
    first = rows((tmp_path / "out.csv").read_text())[0]
    assert [first[key] for key in ("x_m", "y_m", "forward_velocity_mps")] == [1.0, 2.0, 0.5]


def turn_from_rest(first_speed):
    """A plan of a turn of 3 m, faster and faster from its first row on, which moves at so small a speed. [m/s]"""
    header = "time_s,x_m,y_m,yaw_rad,velocity_mps,track_speed_left_mps,track_speed_right_mps,sideslip_rad"
    lines = [header]
    for row in range(12):
        time, speed = 0.3 * row, max(0.2 * 0.3 * row, first_speed)
        yaw = 0.1 * time**2 / 3.0
        x, y = 3.0 * math.sin(yaw), 3.0 * (1.0 - math.cos(yaw))
        lines.append(f"{time},{x},{y},{yaw},{speed},{0.9 * speed},{1.1 * speed},0")
    return "\n".join(lines)


@pytest.mark.parametrize("feedback", ["none", "pose"])
def test_a_plan_that_starts_at_rest_starts_at_rest(run, feedback):
    """Its yaw rate there is none, though the yaw differs between the first two rows."""
    words = ("-", "--json", "--feedback", feedback)
    found = {
        (speed, rtol): json.loads(run(*words, "--rtol", rtol, stdin=turn_from_rest(speed)).stdout)
        for speed, rtol in ((0.0, "1e-4"), (0.0, "1e-6"), (0.0, "1e-8"), (1e-8, "1e-6"), (3e-17, "1e-6"))
    }
    exact = found[0.0, "1e-8"]["max_deviation_m"]
    assert 0.0 < exact < 0.3
    for result in found.values():
        assert result["problem"] is None
        assert result["max_deviation_m"] == pytest.approx(exact, rel=0.02)


def test_a_simulation_that_ends_early_tells_why_and_no_deviation(run, tmp_path):
    (tmp_path / "plan.csv").write_text(turn_from_rest(0.0))
    vehicle = yaml.safe_load((Path(__file__).parents[2] / "vehicles" / "utv-61cm.yaml").read_text())
    (tmp_path / "tall.yaml").write_text(yaml.safe_dump(vehicle | {"cog_height_m": 0.5}))
    result = run("plan.csv", "--slope-deg", 25, "--vehicle", "tall.yaml", "--json", "-o", "out.csv")
    assert result.exit_code == 1
    found = json.loads(result.stdout)
    assert found["max_deviation_m"] is None
    assert found["problem"] in result.stderr
    assert "largest distance" not in result.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--track-speeds-mps", "0.3,0.5"], "--duration-s"),
        (["--track-speeds-mps", "0.3", "--duration-s", "1"], "LEFT,RIGHT"),
        (["--track-speeds-mps", "nan,0", "--duration-s", "1"], "--track-speeds-mps"),
        (["--track-speeds-mps", "0,1e9", "--duration-s", "1"], "--track-speeds-mps"),
        (["--track-speeds-mps", "0,1", "--duration-s", "-1"], "--duration-s"),
        (["--track-speeds-mps", "0,1", "--duration-s", "1", "--laps", "2"], "--laps"),
        (["--track-speeds-mps", "0,1", "--duration-s", "1", "--feedback", "pose"], "--feedback"),
        (["--track-speeds-mps", "0,1", "--duration-s", "1", "--commands", "table"], "--commands"),
        (["--track-speeds-mps", "0,1", "--duration-s", "1", "--lut", "x.h5"], "--lut"),
        (["--circle-radius-m", "0.2"], "--circle-radius-m"),
        (["--circle-radius-m", "nan"], "--circle-radius-m"),
        (["--speed-mps", "0"], "--speed-mps"),
        (["--laps", "0"], "--laps"),
        (["--initial", "1,2"], "--initial"),
        (["--rtol", "1"], "--rtol"),
        (["--rtol", "nan"], "--rtol"),
        (["--slope-deg", "60"], "--slope-deg"),
        (["--interval-s", "0"], "--interval-s"),
        (["--interval-s", "1e-9"], "--interval-s"),
        (["--commands", "hope"], "--commands"),
        (["missing.csv"], "missing.csv"),
        (["."], "."),
        (["--lut", "missing.h5"], "missing.h5"),
    ],
)
def test_bad_options_are_refused(run, words, said):
    result = run(*words)
    assert result.exit_code == 2
    assert said in result.stderr
    assert "Traceback" not in result.output


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "empty"),
        ("time_s\n0\n1\n", "no commands"),
        ("time_s,track_speed_left_mps\n0,1\n1,1\n", "track_speed_right_mps"),
        ("time_s,track_speed_left_mps,track_speed_right_mps\n0,1,1\n", "one row"),
        ("time_s,track_speed_left_mps,track_speed_right_mps\n0,1,1\n0,1,1\n", "line 3"),
        ("time_s,track_speed_left_mps,track_speed_right_mps\n0,1,1\n1,nan,1\n", "line 3"),
        (
            "time_s,track_speed_left_mps,track_speed_right_mps,force_left_n,force_right_n\n0,1,1,1,1\n1,1,1,1,1\n",
            "both",
        ),
        ("track_speed_left_mps,track_speed_right_mps\n0,1\n1,1\n", "time_s"),
    ],
)
def test_bad_files_are_refused(run, tmp_path, text, said):
    (tmp_path / "bad.csv").write_text(text)
    result = run("bad.csv")
    assert result.exit_code == 2
    assert "bad.csv" in result.stderr
    assert said in result.stderr


def test_a_circle_that_cannot_be_held_has_no_answer(run):
    result = run("--speed-mps", 20, "--circle-radius-m", 2)
    assert result.exit_code == 1
    assert "no track speeds hold the path" in result.stderr
