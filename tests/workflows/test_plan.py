import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from trackctl.errors import LutMismatchError, NoAnswerError, OutputError, TrackctlWarning, UsageError
from trackctl.files.lut_writer import write_lut
from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.geometry.circle import Circle
from trackctl.lut.sweep import Seeding
from trackctl.planning.blending import Line
from trackctl.planning.elevation import Elevation
from trackctl.planning.planning_map import PlanningMap
from trackctl.planning.search import Settings
from trackctl.planning.slope_field import plane_slope
from trackctl.workflows import plan_table
from trackctl.workflows.plan import PlanRequest, plan
from trackctl.workflows.plan_line import infeasible_place, samples_of
from trackctl.workflows.plan_verification import planned_ground
from trackctl.workflows.unrolled_ground import unrolled

VEHICLE, TERRAIN, GRAVITY = load_vehicle("utv-61cm"), load_terrain("asphalt"), 9.80665
PLANE = PlanningMap(
    file="plane",
    circles=(Circle(5.0, 5.0, 1.0),),
    bounds=(0.0, 0.0, 10.0, 10.0),
    resolution=0.1,
    slope=math.radians(12.0),
    uphill_yaw=0.5 * math.pi,
    start=(1.5, 1.5, 0.0),
    goal=(8.0, 8.0, 0.5 * math.pi),
)


def hills():
    centres = 0.1 * (np.arange(120) + 0.5)
    height = 0.4 * np.sin(2.0 * np.pi * centres / 8.0) * np.cos(2.0 * np.pi * centres[:, None] / 11.0)
    elevation = Elevation(height, 0.1, 0.1, 0.05, 0.05, "hills")
    return replace(PLANE, slope=None, uphill_yaw=None, elevation=elevation, bounds=None)


def planned(planning_map=PLANE, vehicle=VEHICLE, iterations=100, **more):
    search = Settings(iterations=iterations)
    fields = {"planning_map": planning_map, "vehicle": vehicle, "terrain": TERRAIN, "gravity": GRAVITY}
    return plan(PlanRequest(**fields, search=search, **more))


def check_limits(rows, vehicle):
    """The profile's limits, at every row and between."""
    step = np.diff(rows.time)
    assert (step > 0.0).all()
    assert np.abs(rows.velocity).max() <= vehicle.max_speed + 1e-9
    assert (np.abs(np.diff(rows.velocity)) / step).max() <= vehicle.max_acceleration
    for rate in (rows.rate_left, rows.rate_right):
        assert np.abs(rate).max() <= vehicle.max_sprocket_rate
        assert (np.abs(np.diff(rate)) / step).max() <= vehicle.max_sprocket_acceleration


@pytest.mark.parametrize("planning_map", [PLANE, hills()], ids=["plane", "hills"])
def test_the_limits_of_the_profile_are_kept_at_every_sample(planning_map):
    check_limits(planned(planning_map).rows, VEHICLE)


def test_a_weak_drive_slows_the_plan_down():
    weak = replace(VEHICLE, max_sprocket_rate=8.0, max_sprocket_acceleration=5.0)
    rows = planned(vehicle=weak).rows
    check_limits(rows, weak)
    assert rows.time[-1] > planned().rows.time[-1]


def test_the_track_force_limits_acceleration():
    """Straight on level ground both tracks push alike: 2 F = m (a + f_r g)."""
    ahead = replace(PLANE, circles=(), slope=0.0, start=(1.5, 5.0, 0.0), goal=(8.0, 5.0, 0.0))
    quick = replace(VEHICLE, max_acceleration=2.0, max_sprocket_acceleration=100.0)
    weak = replace(quick, max_track_force=80.0)
    resisted = TERRAIN.motion_resistance_coefficient * GRAVITY
    allowed = 2.0 * weak.max_track_force / weak.mass

    def acceleration(vehicle):
        rows = planned(ahead, vehicle=vehicle).rows
        return np.diff(rows.velocity) / np.diff(rows.time)

    found = acceleration(weak)
    assert acceleration(quick).max() > allowed
    assert 0.9 * allowed - resisted < found.max() <= allowed - resisted
    assert found.min() >= -allowed - resisted


def turn_round(slope):
    """Half a turn that begins across the slope and goes on below."""
    return replace(
        PLANE,
        circles=(Circle(0.0, 25.0, 0.5),),
        bounds=(-30.0, -30.0, 30.0, 30.0),
        slope=math.radians(slope),
        start=(0.0, 3.0, math.pi),
        goal=(0.0, 0.0, 0.0),
    )


def most_slip(rows):
    return np.abs((rows.slip_left, rows.slip_right)).max()


def test_slip_keeps_to_what_steady_turns_ask_for_as_long_as_there_is_such_a_way():
    found = planned(turn_round(17.0))
    assert most_slip(found.rows) <= 0.25
    assert found.notes == ()


def test_where_there_is_none_a_note_tells_the_slip():
    found = planned(turn_round(20.0))
    assert 0.3 < most_slip(found.rows) < 0.5
    assert f"slip by up to {most_slip(found.rows):.2f}" in " ".join(found.notes)


def test_curvature_keeps_to_the_least_radius_and_has_no_jumps():
    wide = replace(VEHICLE, min_turn_radius=2.0)
    rows = planned(vehicle=wide).rows
    assert np.abs(rows.curvature).max() <= 0.5 + 1e-9
    way = np.hypot(np.diff(rows.x), np.diff(rows.y))
    assert (np.abs(np.diff(rows.curvature)) / way).max() <= 2.0 * 0.5 / VEHICLE.contact_length * 1.01


def test_backwards_out_of_a_dead_end():
    """The goal lies behind the start: only backwards is there a short way."""
    behind = replace(PLANE, circles=(), start=(6.0, 5.0, 0.0), goal=(2.0, 5.0, 0.0))
    rows = planned(behind, reverse=True).rows
    assert rows.velocity.min() < -0.5
    assert rows.length < 6.5
    check_limits(rows, VEHICLE)
    assert (rows.x[-1], rows.y[-1], rows.yaw[-1]) == pytest.approx((2.0, 5.0, 0.0), abs=2e-6)


@pytest.mark.parametrize(("slope", "way"), [(0.0, 0.14), (0.0, 0.002), (0.0, -0.14), (12.0, 0.14), (12.0, -0.14)])
def test_short_moves_need_no_blends(slope, way):
    """Straight, or as good as that: on a slope the body points a little away from where it goes."""
    yaw = math.radians(80.0)
    start = (3.0, 3.0, yaw)
    goal = (start[0] + way * math.cos(yaw), start[1] + way * math.sin(yaw), yaw)
    near = replace(PLANE, circles=(), slope=math.radians(slope), start=start, goal=goal)
    rows = planned(near, iterations=20, reverse=way < 0.0).rows
    check_limits(rows, VEHICLE)
    assert rows.length == pytest.approx(abs(way), rel=0.01)
    assert (np.sign(way) * rows.velocity >= 0.0).all()
    for k, pose in ((0, start), (-1, goal)):
        assert (rows.x[k], rows.y[k], rows.yaw[k]) == pytest.approx(pose, abs=1e-9)


@pytest.mark.parametrize(("ahead", "says"), [(0.0, "one pose: there"), (1e-4, "one pose, to 0.001 m and rad: there")])
def test_a_goal_where_the_start_is_leaves_nothing_to_drive(ahead, says):
    x, y, yaw = PLANE.start
    with pytest.raises(NoAnswerError, match=says):
        planned(replace(PLANE, goal=(x + ahead, y, yaw + 2.0 * math.pi)))


def test_where_there_is_no_speed_is_said_by_the_nearer_end():
    lines = [Line(False, (0.0, 0.0, math.pi), np.array([0.0, 2.0]), np.zeros(2)) for _ in range(2)]
    model = SimpleNamespace(vehicle=VEHICLE, field=plane_slope(math.radians(30.0), 0.5 * math.pi))
    last = samples_of(model, lines[0])[0].size - 1
    assert infeasible_place(model, lines, lines[0], 0).startswith("at the start, (0.00, 0.00) m")
    assert infeasible_place(model, lines, lines[1], last).startswith("at the goal, (-2.00, 0.00) m")
    middle = infeasible_place(model, lines, lines[0], last)
    assert middle.startswith("2.00 m from the start and 2.00 m before the goal")
    assert "straight driving on a slope of 30 deg, 90 deg from up-slope" in middle


def test_hills_unrolled_lead_back_to_the_map():
    rows = planned(hills()).rows
    flat = unrolled(planned_ground(rows))
    assert not flat.ground.is_plane
    x, y, yaw = flat.to_map(rows.time, flat.x, flat.y, flat.yaw)
    assert x == pytest.approx(rows.x, abs=1e-12)
    assert y == pytest.approx(rows.y, abs=1e-12)
    assert np.cos(yaw - rows.yaw) == pytest.approx(1.0, abs=1e-9)
    # On the ground the way is longer than on the map.
    assert rows.length > np.hypot(np.diff(rows.x), np.diff(rows.y)).sum()


@pytest.mark.parametrize("relief", [0.0, 200.0], ids=["flat", "mountains"])
def test_cells_may_be_far_larger_than_the_vehicle(relief):
    """Grids of the size of a survey's: nodes 74.5 and 92.5 m apart."""
    along, up = 74.5 * np.arange(60.0), 92.5 * np.arange(60.0)
    height = relief * np.sin(along / 600.0) * np.cos(up / 800.0)[:, None]
    wide = replace(PLANE, circles=(), slope=None, uphill_yaw=None, bounds=None, resolution=None)
    wide = replace(wide, elevation=Elevation(height, 74.5, 92.5, 37.25, 46.25, "survey"))
    start, goal = (1500.0, 1520.0, 0.0), (1540.0, 1550.0, 0.5 * math.pi)
    rows = planned(replace(wide, start=start, goal=goal)).rows
    check_limits(rows, VEHICLE)
    ends = [(rows.x[k], rows.y[k], rows.yaw[k]) for k in (0, -1)]
    assert ends[0] == pytest.approx(start, abs=1e-6)
    assert ends[1] == pytest.approx(goal, abs=1e-6)
    assert 50.0 < rows.length < 60.0
    assert (rows.slope.max() > math.radians(3.0)) == (relief > 0.0)


def test_a_table_of_another_vehicle_is_refused(tmp_path):
    from solved_tables import solved_table

    write_lut(tmp_path / "lut.h5", solved_table())
    with pytest.raises(LutMismatchError):
        planned(vehicle=replace(VEHICLE, mass=200.0), lut=tmp_path / "lut.h5")
    with pytest.raises(UsageError, match="holds"):
        planned(replace(PLANE, slope=math.radians(5.0)), lut=tmp_path / "lut.h5")
    assert planned(lut=tmp_path / "lut.h5").rows.length > 9.0


def test_a_slope_too_steep_is_named():
    with pytest.raises(NoAnswerError, match="44 deg"):
        planned(replace(PLANE, slope=math.radians(44.0)))


def test_a_start_in_an_obstacle_is_named():
    with pytest.raises(NoAnswerError, match=r"start: the footprint touches cell .* circle 1"):
        planned(replace(PLANE, start=(5.0, 5.0, 0.0)))


@pytest.mark.parametrize("slope", [0.0, 12.0])
def test_the_heading_is_counted_from_up_slope_on_level_ground_too(slope):
    rows = planned(replace(PLANE, slope=math.radians(slope), uphill_yaw=0.7, circles=())).rows
    assert np.cos(rows.yaw - rows.heading) == pytest.approx(math.cos(0.7), abs=1e-9)
    assert np.sin(rows.yaw - rows.heading) == pytest.approx(math.sin(0.7), abs=1e-9)


#: A corridor too narrow to turn round in: the vehicle looks at its end.
CORRIDOR = replace(
    PLANE, slope=0.0, circles=(), bounds=(0.0, 0.0, 6.0, 2.0), start=(4.5, 1.0, 0.0), goal=(2.5, 1.0, 0.5 * math.pi)
)


def test_where_there_is_no_other_way_the_vehicle_turns_on_the_spot():
    rows = (found := planned(CORRIDOR, verify=True, most_speed=0.4)).rows
    check_limits(rows, VEHICLE)
    assert (rows.x[-1], rows.y[-1], rows.yaw[-1]) == pytest.approx((2.5, 1.0, 0.5 * math.pi), abs=2e-6)
    way, turned = np.hypot(np.diff(rows.x), np.diff(rows.y)), np.abs(np.diff(np.unwrap(rows.yaw)))
    assert way.max() <= 0.1
    spot = way < 1e-9
    assert turned[spot].sum() == pytest.approx(1.5 * math.pi, abs=0.05)  # half round, and a quarter at the goal
    assert turned[~spot].max() < 0.02
    assert (rows.velocity[:-1][spot][1:-1] == 0.0).all()
    assert set(rows.segment) == {0, 1, 2}
    # Starts and stops shift a plan along itself by some K: the ground is a spring.
    assert found.verification.max_deviation < 0.04
    assert not found.verification.collision
    assert found.no_slip.max_deviation > 5.0 * found.verification.max_deviation


@pytest.mark.parametrize(
    ("change", "more"),
    [
        ({}, {"pivot": False}),
        ({"slope": math.radians(5.0)}, {}),
        ({}, {"vehicle": replace(VEHICLE, min_turn_radius=1.2)}),
        ({}, {"vehicle": replace(VEHICLE, cog_forward=0.02)}),
        ({}, {"vehicle": replace(VEHICLE, max_track_force=200.0)}),
    ],
    ids=["forbidden", "slope", "least radius", "mass centre", "weak drive"],
)
def test_who_cannot_or_must_not_turn_on_the_spot_does_not(change, more):
    with pytest.raises(NoAnswerError, match="goal not reach"):
        planned(replace(CORRIDOR, **change), **more)


def test_who_asks_for_turns_that_cannot_be_is_told_so():
    assert "no turns on the spot" in " ".join(planned(pivot=True).notes)
    assert planned().notes == ()


def test_a_turn_on_the_spot_is_made_where_it_is_cheaper_if_asked_for():
    wide = replace(CORRIDOR, bounds=(0.0, 0.0, 12.0, 9.0), start=(6.0, 4.5, 0.0), goal=(4.8, 4.5, math.pi))
    around, turned = (planned(wide, pivot=pivot, most_speed=1.0).rows for pivot in (None, True))
    assert set(around.segment) == {0}
    assert set(turned.segment) == {0, 1}
    assert turned.time[-1] < around.time[-1]


def test_what_a_table_compiles_is_not_compiled_in_its_threads(monkeypatch, tmp_path):
    """An interrupt waits for the threads to end."""
    told = []
    crew = plan_table.threads
    monkeypatch.setenv("TRACKCTL_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(plan_table, "load_kernels", told.append)
    monkeypatch.setattr(plan_table, "threads", lambda jobs: told.append("threads") or crew(jobs))
    nodes = np.array([0.1])
    plan_table.cached_table(VEHICLE, TERRAIN, GRAVITY, nodes, 0.3, lambda done, total: None)
    assert told == [Seeding.CONTINUATION, "threads"]
    plan_table.cached_table(VEHICLE, TERRAIN, GRAVITY, nodes, 0.3, lambda done, total: None)
    assert len(told) == 2


def test_a_table_that_cannot_be_kept_is_solved_all_the_same(monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("TRACKCTL_CACHE_DIR", str(tmp_path / "file" / "cache"))
    nodes = np.array([0.1])
    with pytest.warns(TrackctlWarning, match="the table cannot be kept"):
        table = plan_table.cached_table(VEHICLE, TERRAIN, GRAVITY, nodes, 0.3, lambda done, total: None)
    assert np.any(table.status == 0)


def test_a_full_disk_of_the_cache_is_no_error_of_the_plan(monkeypatch, tmp_path):
    def full(path, table):
        raise OutputError(path, "cannot be written: the disk is full")

    monkeypatch.setenv("TRACKCTL_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(plan_table, "write_lut", full)
    nodes = np.array([0.1])
    with pytest.warns(TrackctlWarning, match="the disk is full"):
        plan_table.cached_table(VEHICLE, TERRAIN, GRAVITY, nodes, 0.3, lambda done, total: None)
    assert not list(tmp_path.rglob("*.h5"))
