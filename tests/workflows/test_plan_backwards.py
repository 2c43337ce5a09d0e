"""Plans of vehicles whose mass centre is off the centre of their contact, driven backwards."""

import math
from dataclasses import replace

import numpy as np
import pytest

from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.geometry.circle import Circle
from trackctl.planning.blending import blended_route
from trackctl.planning.collision import obstacles_of
from trackctl.planning.footprint import footprint_of
from trackctl.planning.planning_map import PlanningMap, collision_grid, slope_field
from trackctl.planning.pose import advanced
from trackctl.planning.route import Route
from trackctl.planning.search import Settings
from trackctl.simulation.following import Feedback
from trackctl.workflows.plan import PlanRequest, plan, steering
from trackctl.workflows.plan_drive import drive_route
from trackctl.workflows.plan_leads import in_gears
from trackctl.workflows.plan_model import drive_model, turned_round
from trackctl.workflows.plan_rows import rows_of
from trackctl.workflows.plan_verification import verify

TERRAIN, GRAVITY = load_terrain("asphalt"), 9.80665
OFF = replace(load_vehicle("utv-61cm"), cog_forward=0.06, cog_left=0.03)
#: A garage that opens to the left.
GARAGE = PlanningMap(
    file="garage",
    circles=tuple(Circle(*centre, 0.5) for centre in ((7.0, 2.7), (8.0, 2.7), (7.0, 5.3), (8.0, 5.3), (9.5, 4.0))),
    bounds=(0.0, 0.0, 10.0, 8.0),
    resolution=0.05,
    slope=math.radians(12.0),
    uphill_yaw=0.5 * math.pi,
    start=(8.2, 4.0, 0.0),
    goal=(1.5, 1.5, math.pi),
)


#: The same with straight walls, and the goal near a wall of the map.
WALLED = replace(
    GARAGE,
    circles=(),
    polygons=(
        ((6.5, 2.0), (9.5, 2.0), (9.5, 3.2), (6.5, 3.2)),
        ((6.5, 4.8), (9.5, 4.8), (9.5, 6.0), (6.5, 6.0)),
        ((9.0, 3.0), (9.5, 3.0), (9.5, 5.0), (9.0, 5.0)),
    ),
    slope=0.0,
)


def request(planning_map, vehicle, **more):
    return PlanRequest(
        planning_map=planning_map, vehicle=vehicle, terrain=TERRAIN, gravity=GRAVITY, reverse=True, **more
    )


def obstacles_on(planning_map, field, vehicle):
    outline = np.array(vehicle.footprint) - (vehicle.cog_forward, vehicle.cog_left)
    return obstacles_of(collision_grid(planning_map, field), footprint_of(outline))


def ended(route, way):
    """Some way straight on from a route's end."""
    pose = route.start
    for piece in zip(route.curvature, route.length, strict=True):
        pose = advanced(*pose, *piece)
    return advanced(*pose, 0.0, way)


def driven(vehicle, start, curvature, length):
    """Rows of a vehicle that drives pieces on the empty plane."""
    empty = replace(GARAGE, circles=())
    field = slope_field(empty, vehicle.footprint)
    limits = steering(request(empty, vehicle), field, lambda done, total: None)
    model = drive_model(
        vehicle, TERRAIN, GRAVITY, field, obstacles_on(empty, field, vehicle), limits, vehicle.max_speed
    )
    route = Route(start, np.array(curvature), np.array(length), np.zeros(len(length)))
    return rows_of(model, drive_route(model, route, start, ended(route, 0.0), 1.0))


@pytest.mark.parametrize("vehicle", [OFF, load_vehicle("utv-61cm")], ids=["off the centre", "centred"])
def test_driven_backwards_a_vehicle_is_the_one_turned_round_driven_forwards(vehicle):
    x, y, yaw = 8.0, 5.0, 0.3
    backwards = driven(vehicle, (x, y, yaw), [0.4, 0.0, -0.3], [-2.0, -1.5, -2.0])
    forwards = driven(turned_round(vehicle), (x, y, yaw + math.pi), [-0.4, 0.0, 0.3], [2.0, 1.5, 2.0])
    assert backwards.velocity.min() < -0.5
    for name in ("time", "x", "y", "slope", "sideslip"):
        assert getattr(backwards, name) == pytest.approx(getattr(forwards, name), abs=1e-6), name
    for name in ("velocity", "curvature"):
        assert getattr(backwards, name) == pytest.approx(-getattr(forwards, name), abs=1e-6), name
    for name in ("rate", "slip"):
        for side, other in (("left", "right"), ("right", "left")):
            expected = -getattr(forwards, f"{name}_{other}")
            assert getattr(backwards, f"{name}_{side}") == pytest.approx(expected, abs=1e-5), name
    for name in ("yaw", "heading"):
        assert np.cos(getattr(backwards, name) - getattr(forwards, name)) == pytest.approx(-1.0, abs=1e-9), name


def test_turned_round_twice_a_vehicle_is_itself():
    assert turned_round(turned_round(OFF)) == OFF
    assert turned_round(OFF).cog_forward == -OFF.cog_forward


@pytest.mark.parametrize("seed", [1, 3])
def test_ends_are_led_in_backwards_too(seed):
    """Searched between the poses themselves no route is left room for blends at its ends."""
    found = plan(request(WALLED, load_vehicle("utv-61cm"), search=Settings(iterations=2000, seed=seed)))
    assert found.notes == ()
    assert (found.rows.velocity < 0.0).any()
    assert (found.rows.x[-1], found.rows.y[-1]) == pytest.approx((1.5, 1.5), abs=1e-6)


def test_gears_of_a_way_that_cannot_be_blended_do_not_rule_out_others():
    """The cheapest way turns by the wall of the map, in the gears of a lead, too."""
    level = replace(GARAGE, slope=0.0)
    found = plan(request(level, load_vehicle("utv-61cm"), search=Settings(iterations=2000, seed=5)))
    assert found.notes == ()


def test_a_route_that_turns_round_at_once_stops_at_its_lead():
    backwards = Route((0.0, 0.0, 0.0), np.array([0.2, 0.0]), np.array([-2.0, -1.0]), np.zeros(2))
    assert in_gears(backwards, (0, -1)).length.tolist() == [-2.0, -1.0]
    stops = in_gears(backwards, (1, 1))
    assert np.sign(stops.length).tolist() == [1.0, -1.0, -1.0, 1.0]
    assert np.abs(stops.length).sum() == pytest.approx(3.0, abs=1e-5)
    # Blended, the stretch of a stop goes as far as a blend.
    lines = blended_route(stops, (-0.4, 0.0, 0.0), ended(backwards, 0.4), 0.8, 1.0).lines
    assert [line.backwards for line in lines] == [False, True, False]
    assert lines[0].length == pytest.approx(0.8, abs=2e-3)


@pytest.mark.parametrize("slope", [0.0, 12.0])
def test_out_of_a_garage_with_a_gear_change_the_vehicle_drives_its_plan(slope):
    """The simulation knows nothing of turned vehicles: a wrong sign of the mass centre would lead it astray."""
    planning_map = replace(GARAGE, slope=math.radians(slope))
    found = plan(request(planning_map, OFF, search=Settings(iterations=600), clearance=0.05, verify=True))
    rows, open_loop = found.rows, found.verification
    assert rows.segment[-1] >= 1
    assert (rows.velocity < 0.0).any()
    assert (rows.velocity > 0.0).any()
    assert not open_loop.collision
    assert open_loop.max_deviation < 0.012 * rows.length
    assert found.no_slip.max_deviation > 5.0 * open_loop.max_deviation
    obstacles = obstacles_on(planning_map, slope_field(planning_map, OFF.footprint), OFF)
    closed = verify(rows, OFF, TERRAIN, GRAVITY, obstacles, Feedback.POSE)
    assert closed.max_deviation < 0.002 * rows.length
