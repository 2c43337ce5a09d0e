import csv
import io
import json
import os
import subprocess
import sys

import pytest
from solved_tables import SLOPE, VEHICLE, solved_table
from system_words import IS_FOLDER, NO_FILE, NO_SPACE
from systems import needs_full_disk
from typer.testing import CliRunner

from trackctl.cli.app import app
from trackctl.files.lut_writer import write_lut
from trackctl.files.profile_yaml import vehicle_to_yaml
from trackctl.lut.interpolation import LookupStatus

ANSWERS = [
    "sprocket_rate_left_radps",
    "sprocket_rate_right_radps",
    "track_speed_left_mps",
    "track_speed_right_mps",
    "sideslip_rad",
    "slip_left",
    "slip_right",
    "status",
]
# Left, mirrored right, straight, too fast, beyond the grip.
POINTS = (
    "id,velocity_mps,radius_m,heading_deg,note\n"
    'a,1.0,5,90,"one, two"\n'
    "b,1,-5,-90,\n"
    "c,1.50,inf,400,x\n"
    "d,9,5,0,x\n"
    "e,2,0.5,270,x\n"
)
STATUSES = ["converged", "converged", "converged", "outside_table", "infeasible_grip"]
ONE = ("--velocity-mps", 1, "--radius-m", 5, "--heading-deg", 90)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lookup")
    write_lut(folder / "lut.h5", solved_table())
    write_lut(folder / "slopes.h5", solved_table(slopes=(0.0, SLOPE)))
    (folder / "points.csv").write_text(POINTS)
    return folder


@pytest.fixture
def run(folder, monkeypatch):
    monkeypatch.chdir(folder)
    return lambda *words, stdin=None: CliRunner().invoke(app, ["lookup", *map(str, words)], input=stdin)


def rows(text):
    return list(csv.DictReader(io.StringIO(text)))


def test_points_in_and_answers_out(run):
    result = run("lut.h5", "points.csv")
    assert result.exit_code == 0
    found = rows(result.stdout)
    assert list(found[0]) == ["id", "velocity_mps", "radius_m", "heading_deg", "note", *ANSWERS]
    assert [row["status"] for row in found] == STATUSES
    for row, given in zip(found, rows(POINTS), strict=True):
        assert {key: row[key] for key in given} == given
    for row in found[3:]:
        assert [row[name] for name in ANSWERS[:-1]] == [""] * 7
    left, right, *_ = found
    assert float(left["track_speed_left_mps"]) == pytest.approx(float(right["track_speed_right_mps"]))
    assert float(left["slip_right"]) == pytest.approx(float(right["slip_left"]))
    assert float(left["sideslip_rad"]) == pytest.approx(-float(right["sideslip_rad"]))
    assert result.stderr == "points.csv: 2 of 5 rows have no answer: 1 infeasible_grip, 1 outside_table\n"


@pytest.mark.parametrize("words", [["lut.h5", "-"], ["lut.h5"]])
def test_standard_input(run, words):
    assert run(*words, stdin=POINTS).stdout == run("lut.h5", "points.csv").stdout


def test_every_method_meets_a_node(run):
    found = {method: run("lut.h5", *ONE, "--method", method) for method in ("mls", "linear", "cubic", "exact")}
    speeds = [float(rows(result.stdout)[0]["track_speed_left_mps"]) for result in found.values()]
    # The model is solved to residuals of 1e-10.
    assert speeds == pytest.approx([speeds[0]] * 4, abs=1e-8)
    assert all(result.stderr == "" for result in found.values())


def test_a_single_point(run):
    (row,) = rows(run("lut.h5", *ONE).stdout)
    assert list(row) == ["velocity_mps", "radius_m", "heading_deg", *ANSWERS]
    (same,) = rows(run("lut.h5", stdin="velocity_mps,radius_m,heading_deg\n1,5,90\n").stdout)
    assert [row[name] for name in ANSWERS] == [same[name] for name in ANSWERS]
    (straight,) = rows(run("slopes.h5", *ONE[:3], "inf", *ONE[4:], "--slope-deg", 6).stdout)
    assert (straight["radius_m"], straight["slope_deg"]) == ("inf", "6.0")
    assert straight["status"] == "converged"


def test_one_of_several_slopes(run):
    refused = run("slopes.h5", *ONE)
    assert refused.exit_code == 2
    assert "slopes.h5: has 2 slopes (0, 12 deg)" in refused.stderr
    points = "velocity_mps,curvature_1pm,heading_rad,slope_deg\n1,0.2,1,0\n1,0.2,1,12\n1,0.2,1,13\n"
    found = rows(run("slopes.h5", stdin=points).stdout)
    assert [row["status"] for row in found] == ["converged", "converged", "outside_table"]
    assert found[0]["sideslip_rad"] != found[1]["sideslip_rad"]


def test_answers_in_the_input_are_replaced(run, folder):
    first = run("lut.h5", "points.csv", "--quiet").stdout
    again = run("lut.h5", stdin=first.replace("sideslip_rad", "sideslip_deg"))
    assert again.stdout == first
    assert "<stdin>: replacing sprocket_rate_left_radps, " in again.stderr
    assert "sideslip_deg" in again.stderr


def test_output_file_and_force(run, folder):
    assert run("lut.h5", "points.csv", "-o", "out.csv").stdout == ""
    assert (folder / "out.csv").read_text() == run("lut.h5", "points.csv").stdout
    refused = run("lut.h5", "points.csv", "-o", "out.csv")
    assert refused.exit_code == 2
    assert "out.csv: exists already; --force replaces it" in refused.stderr
    assert run("lut.h5", "points.csv", "-o", "out.csv", "--force").exit_code == 0


def test_summary(run, folder):
    result = run("lut.h5", "points.csv", "--method", "linear", "--json", "-o", "summed.csv")
    found = json.loads(result.stdout)
    assert (found["rows"], found["method"]) == (5, "linear")
    assert list(found["status"]) == [status.label for status in LookupStatus]
    assert found["status"] == {word: STATUSES.count(word) for word in found["status"]}
    assert len(rows((folder / "summed.csv").read_text())) == 5


def test_quiet(run):
    assert run("lut.h5", "points.csv", "--quiet").stderr == ""


def test_no_answer_at_all_exits_1_with_the_rows(run):
    result = run("lut.h5", "--velocity-mps", 9, "--radius-m", 5, "--heading-deg", 0)
    assert result.exit_code == 1
    assert rows(result.stdout)[0]["status"] == "outside_table"
    assert result.stderr == (
        "Error: the point: no row has an answer: 1 outside_table; "
        "`trackctl info lut.h5` shows the ranges of the table\n"
    )
    near = run("lut.h5", "--velocity-mps", 1.98, "--radius-m", 0.95, "--heading-deg", 270, "--quiet")
    assert near.exit_code == 1
    assert "--method exact" in near.stderr
    assert run("lut.h5", "points.csv", stdin=None).exit_code == 0


def test_the_profiles_asked_for(run, folder):
    assert run("lut.h5", *ONE, "--vehicle", "utv-61cm", "--terrain", "asphalt").exit_code == 0
    assert run("lut.h5", *ONE, "--gravity-mps2", 9.80665).exit_code == 0
    for other in (("--vehicle", "m113"), ("--terrain", "snow"), ("--gravity-mps2", 1.62)):
        refused = run("lut.h5", *ONE, *other)
        assert refused.exit_code == 2
        assert "Error: lut.h5: was made for utv-61cm on asphalt with " in refused.stderr


def test_the_limits_of_the_vehicle_given_apply(run, folder):
    text = vehicle_to_yaml(VEHICLE).replace("max_sprocket_rate_radps: 30", "max_sprocket_rate_radps: 9")
    (folder / "slow.yaml").write_text(text)
    result = run("lut.h5", *ONE, "--vehicle", "slow.yaml")
    assert result.exit_code == 1
    assert rows(result.stdout)[0]["status"] == "actuator_limit"


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["points.csv", *ONE], "CSV: points.csv is not allowed; allowed: no file beside the options"),
        (ONE[:4], "--heading-deg: is missing; allowed: a number"),
        (["--slope-deg", 12], "--velocity-mps: is missing"),
        (["--velocity-mps", 0, *ONE[2:]], "--velocity-mps: 0.0 is not allowed; allowed: above 0"),
        (["--velocity-mps", "nan", *ONE[2:]], "--velocity-mps: nan is not allowed; allowed: above 0"),
        (["--velocity-mps", "inf", *ONE[2:]], "--velocity-mps: inf is not allowed"),
        ([*ONE[:3], "nan", *ONE[4:]], "--radius-m: nan is not allowed; allowed: a number"),
        ([*ONE[:5], "inf"], "--heading-deg: inf is not allowed; allowed: a finite number"),
        ([*ONE, "--method", "spline"], "--method"),
        ([*ONE, "--jobs", 0], "--jobs"),
        ([*ONE, "--json", "-o", "-"], "--output: - is not allowed; allowed: a file"),
        ([*ONE, "-o", "nowhere/out.csv"], "nowhere/out.csv: there is no folder"),
        ([*ONE, "-o", "."], "is a folder"),
        ([*ONE, "--vehicle", "tank"], "tank: no vehicle profile has this name"),
        (["nothing.csv"], "nothing.csv: cannot be read"),
        (["."], f".: cannot be read: {IS_FOLDER}"),
        (["lut.h5"], "lut.h5: is binary"),
    ],
)
def test_wrong_usage_exits_2(run, words, problem):
    result = run("lut.h5", *words)
    assert (result.exit_code, result.stdout) == (2, "")
    assert problem in result.stderr


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "<stdin>, line 1: is empty"),
        ("velocity_mps,radius_m,heading_rad\n", "<stdin>: has a header but no rows"),
        ("velocity_mps,radius_m,heading_rad\n1,5\n", "<stdin>, line 2: has 2 cells; the header has 3"),
        ("velocity_mps,radius_m,heading_rad\n1,nan,0\n", "<stdin>, line 2: column radius_m: 'nan' is not"),
        ("velocity_mps,radius_m,heading_rad\n0,1,0\n", "<stdin>, line 2: column velocity_mps: '0' is not"),
        ("velocity,radius_m,heading_rad\n1,1,0\n", "<stdin>: column 'velocity' has no unit of velocity"),
        ("velocity_mps,heading_rad\n1,1\n", "<stdin>: column radius_m or curvature_1pm is missing"),
    ],
)
def test_what_is_no_list_of_points_exits_2(run, text, problem):
    result = run("lut.h5", stdin=text)
    assert (result.exit_code, result.stdout) == (2, "")
    assert problem in result.stderr


@pytest.mark.parametrize(
    ("lut", "problem"),
    [
        ("none.h5", f"none.h5: cannot be read: {NO_FILE}"),
        (".", ".: is a folder"),
        ("empty.h5", "empty.h5: is empty"),
        ("points.csv", "points.csv: is no HDF5 file"),
    ],
)
def test_what_is_no_table_exits_2(run, folder, lut, problem):
    (folder / "empty.h5").touch()
    result = run(lut, *ONE)
    assert (result.exit_code, result.stdout) == (2, "")
    assert problem in result.stderr


@needs_full_disk
def test_a_full_disk_exits_2(run):
    result = run("lut.h5", *ONE, "-o", "/dev/full")
    assert result.exit_code == 2
    assert f"/dev/full: cannot be written: {NO_SPACE}" in result.stderr


def test_a_closed_pipe_ends_quietly(folder):
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "trackctl", "lookup", str(folder / "lut.h5"), *map(str, ONE)]
    done = subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writing)
    assert (done.returncode, done.stderr) == (0, "")


def test_without_points_on_a_terminal_the_command_says_what_it_needs(run, monkeypatch):
    monkeypatch.setattr("trackctl.cli.lookup.is_terminal", lambda: True)
    result = run("lut.h5")
    assert result.exit_code == 2
    assert "CSV: is missing; allowed: a file, - for standard input, or --velocity-mps" in result.stderr
