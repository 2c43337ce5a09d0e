import csv
import io
import json
import math
import re
from itertools import pairwise

import pytest
import yaml
from typer.testing import CliRunner

from trackctl.cli.app import app
from trackctl.workflows import plan_attempts, plan_jumps

COLUMNS = [
    *("time_s", "x_m", "y_m", "yaw_rad", "velocity_mps", "curvature_1pm", "slope_rad", "heading_rad"),
    *("sprocket_rate_left_radps", "sprocket_rate_right_radps", "sideslip_rad", "slip_left", "slip_right", "segment"),
]
MAP = """\
bounds_m: [0, 0, 10, 10]
resolution: 0.1
obstacles:
  circles: [[5, 5, 1]]
start: [1.5, 1.5, 0]
goal: [8, 8, 90]
slope_deg: 12
"""
#: A tight S of 60 deg with no room for ramps of curvature: it begins at the start and ends at the goal.
NARROW = """\
bounds_m: [0.4, 0.2, {right}, 2.73]
resolution: 0.01
start: [1.0, 0.8, 0]
goal: [3.3044, 2.1304, 0]
slope_deg: 0
"""
QUICK = ("--iterations", 100)


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "map.yaml").write_text(MAP)
    return lambda *words, stdin=None: CliRunner().invoke(app, [*map(str, words)], input=stdin)


def rows(text):
    return [{key: float(cell) for key, cell in row.items()} for row in csv.DictReader(io.StringIO(text))]


def test_a_plan_from_the_map_alone(run):
    result = run("plan", "map.yaml", *QUICK)
    assert result.exit_code == 0, result.output
    found = rows(result.stdout)
    assert list(found[0]) == COLUMNS
    for row, pose in ((found[0], (1.5, 1.5, 0.0)), (found[-1], (8.0, 8.0, 90.0))):
        assert (row["x_m"], row["y_m"]) == pytest.approx(pose[:2], abs=1e-9)
        assert math.degrees(row["yaw_rad"]) == pytest.approx(pose[2], abs=1e-3)
        assert row["velocity_mps"] == row["sprocket_rate_left_radps"] == row["sprocket_rate_right_radps"] == 0.0
    steps = [math.hypot(b["x_m"] - a["x_m"], b["y_m"] - a["y_m"]) for a, b in pairwise(found)]
    assert max(steps) <= 0.1
    for row in found:
        heading = row["yaw_rad"] - math.radians(90.0)
        assert math.remainder(row["heading_rad"] - heading, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_the_same_seed_and_iterations_give_the_same_bytes(run):
    assert run("plan", "map.yaml", *QUICK).stdout == run("plan", "map.yaml", *QUICK, "--jobs", 1).stdout


def test_summary_picture_and_verification(run, tmp_path):
    words = ("--verify", "--plot", "plan.png", "--json", "-o", "plan.csv", "--clearance-m", 0.2)
    result = run("plan", "map.yaml", *QUICK, *words)
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert found["solved"] is True
    assert 0.0 < found["first_solution_s"] <= found["planning_s"]
    assert found["duration_s"] == pytest.approx(rows((tmp_path / "plan.csv").read_text())[-1]["time_s"])
    assert found["min_clearance_m"] >= 0.2
    assert found["max_deviation_m"] < 0.012 * found["length_m"]
    assert found["no_slip_max_deviation_m"] > 5.0 * found["max_deviation_m"]
    assert found["collision"] is False
    assert (tmp_path / "plan.png").stat().st_size > 10_000
    closed = run("simulate", "plan.csv", "--feedback", "pose", "--rtol", 1e-4, "--json", "-o", "driven.csv")
    assert closed.exit_code == 0, closed.output
    assert json.loads(closed.stdout)["max_deviation_m"] < 0.002 * found["length_m"]


WALL = """\
bounds_m: [0, 0, 10, 10]
resolution: 0.05
obstacles:
  polygons: [[[8, 0], [10, 0], [10, 10], [8, 10]]]
start: [1.5, 1.5, 0]
goal: [7.6, 5, 0]
"""


def test_a_goal_in_a_wall_is_met_within_its_tolerance(run, tmp_path):
    (tmp_path / "wall.yaml").write_text(WALL)
    (tmp_path / "near.yaml").write_text(WALL + "goal_tolerance: [0.3, 5]\n")
    exact = run("plan", "wall.yaml", *QUICK)
    assert (exact.exit_code, exact.stdout) == (1, "")
    assert "goal: the footprint touches cell" in exact.stderr
    result = run("plan", "near.yaml", *QUICK, "--json", "-o", "near.csv")
    assert result.exit_code == 0, result.output
    assert "from the goal, within its tolerance" in result.stderr
    found, last = json.loads(result.stdout), rows((tmp_path / "near.csv").read_text())[-1]
    off, turned = math.dist((last["x_m"], last["y_m"]), (7.6, 5.0)), abs(last["yaw_rad"])
    assert 0.1 < off <= 0.3
    assert turned <= math.radians(5.0)
    assert (found["goal_distance_m"], found["goal_yaw_error_rad"]) == pytest.approx((off, turned), abs=1e-12)
    assert found["min_clearance_m"] > 0.0
    option = run("plan", "wall.yaml", *QUICK, "--goal-tolerance", "0.3,5")
    assert option.stdout == (tmp_path / "near.csv").read_text()


def test_without_a_tolerance_the_goal_is_exact(run):
    exact, zeros = (run("plan", "map.yaml", *QUICK, *more) for more in ((), ("--goal-tolerance", "0,0")))
    assert exact.stdout == zeros.stdout
    found = json.loads(run("plan", "map.yaml", *QUICK, "--json", "-o", "plan.csv").stdout)
    assert found["goal_distance_m"] < 1e-9
    assert found["goal_yaw_error_rad"] < 1e-5


def test_a_goal_that_faces_the_wrong_way_is_met_sooner_where_its_yaw_is_free(run, tmp_path):
    (tmp_path / "wide.yaml").write_text(MAP.replace("10, 10]", "16, 16]"))
    summaries = [
        json.loads(run("plan", "wide.yaml", "--goal", "8,8,-120", "--iterations", 500, *words).stdout)
        for words in (("--json", "-o", "a.csv"), ("--json", "-o", "b.csv", "--goal-tolerance", "0,180"))
    ]
    assert summaries[1]["cost"] < 0.9 * summaries[0]["cost"]
    assert summaries[1]["goal_yaw_error_rad"] > 1.0
    assert summaries[1]["goal_distance_m"] < 1e-8


def test_a_collision_in_the_simulation_exits_with_1_and_leaves_the_output(run, tmp_path, monkeypatch):
    from trackctl.workflows import plan_verification

    found = plan_verification.Verification(0.4, 0.0, True, "")
    monkeypatch.setattr("trackctl.workflows.plan.verify", lambda *words: found)
    result = run("plan", "map.yaml", *QUICK, "--verify", "-o", "plan.csv")
    assert result.exit_code == 1
    assert "touches an obstacle" in result.stderr
    assert len(rows((tmp_path / "plan.csv").read_text())) > 10


def test_json_and_ros(run):
    as_csv = rows(run("plan", "map.yaml", *QUICK).stdout)
    columns = json.loads(run("plan", "map.yaml", *QUICK, "--format", "json").stdout)
    assert columns["x_m"] == [row["x_m"] for row in as_csv]
    path = yaml.safe_load(run("plan", "map.yaml", *QUICK, "--format", "ros").stdout)
    assert path["header"]["frame_id"] == "map"
    last, row = path["poses"][-1], as_csv[-1]
    assert last["pose"]["position"] == pytest.approx({"x": row["x_m"], "y": row["y_m"], "z": 0.0})
    turn = last["pose"]["orientation"]
    assert 2.0 * math.atan2(turn["z"], turn["w"]) == pytest.approx(row["yaw_rad"], abs=1e-9)
    stamp = last["header"]["stamp"]
    assert stamp["sec"] + 1e-9 * stamp["nanosec"] == pytest.approx(row["time_s"], abs=1e-9)


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (("--goal", "5,5,0"), 1, "goal: the footprint touches cell"),
        (("--start", "5,6.2,0", "--clearance-m", "0.5"), 1, "circle 1"),
        (("--goal", "15,5,0"), 2, "x from 0 to 10 m"),
        (("--goal", "5,5"), 2, "X,Y,YAW_DEG"),
        (("--goal", "5,5,0", "--goal-tolerance", "0.2,10"), 1, "goal, anywhere within 0.2 m and 10 deg: the footprint"),
        (("--goal-tolerance", "0.2,1,2"), 2, "M[,DEG]: 0 to 1000 m and 0 to 180 deg"),
        (("--goal-tolerance", "-0.1,5"), 2, "--goal-tolerance: -0.1,5 is not allowed"),
        (("--goal-tolerance", "nan,5"), 2, "--goal-tolerance: nan is not allowed"),
        (("--goal-tolerance", "0.1,181"), 2, "--goal-tolerance: 0.1,181 is not allowed"),
        (("--goal-tolerance", "near,5"), 2, "--goal-tolerance: near is not allowed"),
        (("--slope-deg", "44"), 1, "slope"),
        (("--slope-deg", "60"), 2, "0 to 44.9"),
        (("--speed-mps", "0"), 2, "--speed-mps"),
        (("--clearance-m", "nan"), 2, "--clearance-m"),
        (("--time-limit-s", "1"), 2, "--iterations"),
        (("--plot", "plan.txt"), 2, "--plot"),
        (("--cost", "beauty"), 2, "beauty"),
        (("--lut", "missing.h5"), 2, "missing.h5"),
    ],
)
def test_what_is_wrong_is_said(run, words, code, says):
    result = run("plan", "map.yaml", *QUICK, *words)
    assert result.exit_code == code, result.output
    assert says in result.stderr
    assert result.stdout == ""


def test_a_closed_wall_leaves_no_path(run, tmp_path):
    text = MAP.replace("circles: [[5, 5, 1]]", "polygons: [[[0, 4], [10, 4], [10, 5], [0, 5]]]")
    (tmp_path / "wall.yaml").write_text(text)
    result = run("plan", "wall.yaml", *QUICK, "--json")
    assert result.exit_code == 1
    found = json.loads(result.stdout)
    assert found["solved"] is False
    assert list(found) == list(json.loads(run("plan", "map.yaml", *QUICK, "--json", "-o", "plan.csv").stdout))
    assert {found[key] for key in found if key not in ("solved", "reason")} == {None}
    assert "goal not reach" in found["reason"]


def test_a_map_without_start_says_how_to_give_one(run, tmp_path):
    (tmp_path / "bare.yaml").write_text(MAP.replace("start: [1.5, 1.5, 0]\n", ""))
    result = run("plan", "bare.yaml", *QUICK)
    assert result.exit_code == 2
    assert "--start" in result.stderr


def test_on_a_slope_more_room_is_looked_for_unless_told(run, monkeypatch):
    """Open loop a vehicle leaves its plan by up to a share of the way that grows with the slope."""
    asked = []

    def look(problem, *rest):
        asked.append(problem.clearance)
        return begin(problem, *rest)

    def most_room(*words):
        asked.clear()
        assert run("plan", "map.yaml", *QUICK, *words).exit_code == 0
        return asked[0]

    begin = plan_attempts.Search
    monkeypatch.setattr(plan_attempts, "Search", look)
    share = 0.05 * math.tan(math.radians(12.0)) * math.hypot(6.5, 6.5)
    cut = most_room("--clearance-m", 0.1) - 0.1
    assert 0.0 < cut < 0.1
    assert most_room() == pytest.approx(share + cut, rel=0.1)
    assert most_room("--slope-deg", 0) < 0.1


def test_where_no_blend_fits_the_jumps_are_followed_by_the_commands_of_the_twin(run, tmp_path):
    (tmp_path / "narrow.yaml").write_text(NARROW.format(right=4.0))
    result = run("plan", "narrow.yaml", *QUICK, "--verify", "--json", "-o", "plan.csv")
    assert result.exit_code == 0, result.output
    said = re.search(
        r"jumps 2 times\..* leaves the plan by up to ([\d.]+) m and misses the goal by ([\d.]+) m", result.stderr
    )
    away, missed = map(float, said.groups())
    # Jumps from left to straight and from there to right, of 1 / R each: blend^2 / (24 R).
    assert away == pytest.approx(2.0 / 1.33 * 0.8**2 / 24.0, rel=0.05)
    assert missed == pytest.approx(away, rel=0.05)
    found, plan = json.loads(result.stdout), rows((tmp_path / "plan.csv").read_text())
    assert 0.8 * away < found["max_deviation_m"] < away + 0.012 * found["length_m"]
    assert [plan[-1][key] for key in ("x_m", "y_m", "yaw_rad")] == pytest.approx([3.3044, 2.1304, 0.0], abs=1e-6)
    curvature = [row["curvature_1pm"] for row in plan]
    assert max(abs(b - a) for a, b in pairwise(curvature)) == pytest.approx(max(curvature), rel=0.01)
    assert max(curvature) > 0.7


def test_the_twin_must_not_touch_either(run, tmp_path):
    """The route ends 5 cm before a wall, which its twin comes nearer to by 3.5 cm: the checks keep two cells."""
    (tmp_path / "narrow.yaml").write_text(NARROW.format(right=3.86))
    result = run("plan", "narrow.yaml", *QUICK)
    assert result.exit_code == 1
    assert "leave no room for blends of 1.6 m; nor without blends: it touches an obstacle" in result.stderr


def test_a_twin_that_misses_the_goal_by_much_is_refused(run, tmp_path, monkeypatch):
    monkeypatch.setattr(plan_jumps, "MOST_MISSED", 0.03)
    (tmp_path / "narrow.yaml").write_text(NARROW.format(right=4.0))
    result = run("plan", "narrow.yaml", *QUICK, "-o", "plan.csv")
    assert result.exit_code == 1
    assert re.search(r"miss the goal by 0\.04\d* m, more than 0\.03 of a blend of 0\.80 m", result.stderr)
    assert not (tmp_path / "plan.csv").exists()
