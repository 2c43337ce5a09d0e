import copy
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from simulation.driving import ASPHALT, SMALL, drive, drive_along, slope_scene, velocity

from trackctl.lut.point import solve_points
from trackctl.simulation.collocation_step import accept
from trackctl.simulation.contact_memory import push
from trackctl.simulation.motion import End, State, integration, sample, turn_time
from trackctl.simulation.newton import try_step
from trackctl.simulation.run_state import Speeds

MU, K, L = ASPHALT.friction_coefficient, ASPHALT.shear_deformation_modulus, SMALL.contact_length
FREE = replace(ASPHALT, friction_coefficient=1e-12, motion_resistance_coefficient=0.0)
TURN = (0.45, 0.65)
LEVEL_TURN = np.array([[0.0, 0.45, 0.7, 0.0]])
BOTH = pytest.mark.parametrize("remember", [True, False], ids=["memory", "present motion"])


def distance_to_stop(energy, pull=0.0):
    """How far a vehicle on locked tracks slides: E + pull d = mu (d - K (1 - exp(-d/K))), over m g cos(theta)."""
    return brentq(lambda d: energy + pull * d - MU * (d - K * (1.0 - math.exp(-d / K))), 1e-9, 10.0)


def test_nothing_moves_on_level_ground_at_rest():
    simulation, end = drive(slope_scene(0), 0.0, 0.0, 10.0)
    assert end is End.DONE
    assert simulation.pose == pytest.approx([0.0, 0.0, 0.0], abs=1e-15)


@pytest.mark.parametrize("direction", [0.0, 0.5, 0.5 * math.pi, math.pi])
def test_energy_of_a_slide_on_locked_tracks_goes_into_the_ground(direction):
    """With contact memory every shoe slides as far as the vehicle: the friction work has a closed form."""
    speed, ground = 1.0, slope_scene(0)
    start = State(forward_velocity=speed * math.cos(direction), lateral_velocity=speed * math.sin(direction))
    simulation, _ = drive(ground, 0.0, 0.0, 2.0, start)
    slid = distance_to_stop(0.5 * speed**2 / ground.model.gravity)
    # The tolerance, and the creep at the sliding floor of 1e-5 m/s in 2 s.
    assert np.hypot(*simulation.pose[:2]) == pytest.approx(slid, rel=1e-4)
    assert np.abs(velocity(simulation)).max() <= 1e-5
    assert math.atan2(simulation.pose[1], simulation.pose[0]) == pytest.approx(direction, abs=1e-6)


def test_a_vehicle_put_down_on_a_slope_settles_and_stands():
    """It gives way until friction has taken up the energy, which is a few millimetres."""
    ground = slope_scene(12.13)
    simulation, _ = drive(ground, 0.0, 0.0, 5.0)
    given_way = distance_to_stop(0.0, math.tan(ground.slope))
    assert -simulation.pose[1] == pytest.approx(given_way, abs=5.0 * 1e-5)
    assert simulation.pose[0] == pytest.approx(0.0, abs=1e-9)


def test_momentum_without_friction_is_gravity_s():
    """A free body on the slope: a parabola at constant yaw rate, whatever the tracks do, and its energy is kept."""
    ground = slope_scene(10.0, terrain=FREE, uphill_yaw=0.3)
    start = State(0.0, 0.0, 0.2, 0.7, -0.4, 1.1)
    simulation, _ = drive(ground, 0.5, 0.3, 3.0, start)
    yaw, t = 0.2 + 1.1 * 3.0, 3.0
    down = -ground.model.gravity * math.sin(ground.slope) * np.array([math.cos(0.3), math.sin(0.3)])
    turn = np.array([[math.cos(0.2), -math.sin(0.2)], [math.sin(0.2), math.cos(0.2)]])
    first = turn @ (0.7, -0.4)
    assert simulation.pose == pytest.approx([*(first * t + 0.5 * down * t * t), yaw], abs=1e-5)
    v_x, v_y, r = velocity(simulation)
    world = np.array([v_x * math.cos(yaw) - v_y * math.sin(yaw), v_x * math.sin(yaw) + v_y * math.cos(yaw)])
    assert world == pytest.approx(first + down * t, abs=1e-5)
    assert r == pytest.approx(1.1, abs=1e-9)
    lost_height = 0.5 * (world @ world - first @ first)
    assert lost_height == pytest.approx(down @ simulation.pose[:2], rel=1e-5)


@BOTH
@pytest.mark.parametrize("speed", [0.5, -0.5])
def test_level_straight_driving_slips_by_what_resistance_asks(speed, remember):
    """mu (1 - (K/(i L)) (1 - exp(-i L/K))) = f_r, j = i x along the track and i = 1 - v/V; from rest half as fast."""

    def missing(i):
        reach = i * L / K
        return MU * (1.0 - (1.0 - math.exp(-reach)) / reach) - ASPHALT.motion_resistance_coefficient

    slip = brentq(missing, 1e-6, 0.5)
    # With memory, slip swings about it after a start from rest and is hardly damped: by 3 % after 10 s.
    start = State(forward_velocity=speed * (1.0 - slip)) if remember else State()
    simulation, _ = drive(slope_scene(0, remember=remember), speed, speed, 10.0, start, steady_start=remember)
    v_x, v_y, r = velocity(simulation)
    # The sliding floor of 1e-5 m/s is a sixtieth of the sliding here.
    assert 1.0 - v_x / speed == pytest.approx(slip, rel=2e-3)
    assert [v_y, r, *simulation.pose[1:]] == pytest.approx([0.0] * 4, abs=1e-9)


@BOTH
def test_level_turning_settles_on_the_equilibrium(remember):
    """The speeds that the equilibrium gives for a turn make the vehicle drive it."""
    ground = slope_scene(0, remember=remember)
    left, right, sideslip = solve_points(ground.model, LEVEL_TURN)["unknowns"][0]
    _, speed, curvature, _ = LEVEL_TURN[0]
    simulation, _ = drive(ground, left * speed, right * speed, 20.0)
    asked = [speed * math.cos(sideslip), speed * math.sin(sideslip), speed * curvature]
    assert velocity(simulation) == pytest.approx(asked, abs=2e-6)


@BOTH
def test_mirrored_speeds_mirror_the_motion(remember):
    left, _ = drive(slope_scene(12, uphill_yaw=0.0, remember=remember), 0.2, 0.5, 6.0)
    right, _ = drive(slope_scene(12, uphill_yaw=0.0, remember=remember), 0.5, 0.2, 6.0)
    assert right.pose == pytest.approx(left.pose * [1.0, -1.0, -1.0], abs=1e-9)


def test_a_symmetric_vehicle_drives_backwards_as_forwards():
    forwards, _ = drive(slope_scene(12, uphill_yaw=0.0), 0.2, 0.5, 6.0)
    backwards, _ = drive(slope_scene(12, uphill_yaw=math.pi), -0.2, -0.5, 6.0)
    assert backwards.pose == pytest.approx(forwards.pose * [-1.0, 1.0, -1.0], abs=1e-9)


def test_the_frame_does_not_matter():
    ground, turned = slope_scene(12, uphill_yaw=1.0), slope_scene(12, uphill_yaw=3.0)
    first, _ = drive(ground, 0.3, 0.5, 6.0, State(1.0, 2.0, 0.5))
    second, _ = drive(turned, 0.3, 0.5, 6.0, State(-3.0, 4.0, 2.5))
    assert velocity(second) == pytest.approx(velocity(first), abs=1e-7)
    turn = np.array([[math.cos(2.0), -math.sin(2.0)], [math.sin(2.0), math.cos(2.0)]])
    moved = turn @ (first.pose[:2] - (1.0, 2.0))
    assert second.pose - [-3.0, 4.0, 2.5] == pytest.approx([*moved, first.pose[2] - 0.5], abs=1e-6)


def test_kinks_that_move_along_a_track_do_not_shorten_steps():
    """The right track slips by little: shoes come back over their points of entry."""
    start = State(1.0, 2.0, 0.5)
    simulation, end = drive(slope_scene(12, uphill_yaw=1.0), 0.3, 0.5, 6.0, start)
    steps = simulation.steps[: simulation.count]
    assert end is End.DONE
    # The last step goes to the end.
    assert steps["length"][steps["time"] > 1.0][:-1].min() > 0.01


@BOTH
def test_turning_passes_through_zero_yaw_rate(remember):
    ground = slope_scene(0, remember=remember)
    simulation, end = drive_along(ground, [0.0, 4.0, 8.0], [0.3, 0.5, 0.3], [0.5, 0.3, 0.5])
    assert end is End.DONE
    motion = sample(simulation, 1.0, np.linspace(0.0, 8.0, 801))
    assert np.count_nonzero(np.diff(np.sign(motion.yaw_rate[20:]))) == 2
    assert np.abs(motion.yaw_rate).max() < 0.4


@BOTH
def test_tracks_reverse_and_stop(remember):
    ground = slope_scene(12.13, remember=remember)
    simulation, end = drive_along(
        ground, [0.0, 2.0, 6.0, 7.0, 9.0], [0.5, 0.5, -0.5, 0.0, 0.0], [0.3, 0.3, -0.3, 0.0, 0.0]
    )
    assert end is End.DONE
    # What is left is creep below the sliding floor.
    assert np.abs(velocity(simulation)).max() < 1e-4


def test_contact_remembers_where_shoes_have_entered():
    """Each shoe's point of entry against the motion itself, after the tracks have gone both ways."""
    ground = slope_scene(12.13)
    time, left = [0.0, 2.0, 4.0, 4.5], [0.5, 0.5, -0.5, -0.5]
    simulation, _ = drive_along(ground, time, left, [0.3, 0.3, -0.3, -0.3])
    dense = np.linspace(0.0, 4.5, 45001)
    motion = sample(simulation, 1.0, dense)
    travel = np.concatenate(
        ([0.0], np.cumsum(0.5 * np.diff(dense) * (motion.track_speed_left[1:] + motion.track_speed_left[:-1])))
    )
    memory, entries = simulation.memory[0], simulation.entries[0]
    assert memory["travel"] == pytest.approx(travel[-1], abs=1e-7)
    arm = 0.5 * SMALL.track_gauge
    pieces = [entries[(memory["first"] + i) % entries.size] for i in range(memory["count"])]
    assert [piece["lower"] for piece in pieces[1:]] == pytest.approx([piece["upper"] for piece in pieces[:-1]])
    theta, checked = 0.4, 0
    for piece in pieces:
        label = piece["label"] + piece["rate"] * theta + piece["change"] * theta**2
        # Put down, without length at the reversal, or left on the ground only in part.
        is_put_down = piece["rough_below"] and piece["rough_above"]
        if is_put_down or piece["upper"] - piece["lower"] < 1e-9 or not piece["lower"] <= label <= piece["upper"]:
            continue
        end = math.copysign(0.5 * L, piece["rate"] + piece["change"])
        entered = np.flatnonzero(np.diff(np.sign(travel + end - label)))[-1]
        yaw = motion.yaw[entered]
        place = motion.x[entered] + end * math.cos(yaw) - arm * math.sin(yaw)
        # The motion is known to 1e-4 s.
        assert np.polyval(piece["x"][::-1], theta) == pytest.approx(place, abs=1e-4)
        checked += 1
    assert checked > 5


@pytest.mark.parametrize("plateau", [3e-16, 1e-13, 1e-11, 1e-8, 1e-5])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_pieces_of_next_to_no_length_change_nothing(plateau, tolerance):
    time, speed = [0.0, 0.5, 0.5 + plateau, 1.0], np.array([0.0, 0.5, 0.5, 0.0])
    simulation, end = drive_along(slope_scene(12.13), time, speed, 1.1 * speed, tolerance=tolerance)
    triangle, _ = drive_along(slope_scene(12.13), [0.0, 0.5, 1.0], speed[[0, 1, 3]], 1.1 * speed[[0, 1, 3]])
    assert end is End.DONE
    np.testing.assert_allclose(simulation.pose, triangle.pose, atol=10.0 * tolerance + plateau + 1e-6)


def test_loads_come_from_the_accelerations():
    """N_left = W/2 + (h/B) m (g_y - a_y), N_left + N_right = W, on level ground in a steady turn."""
    ground = slope_scene(0)
    simulation, _ = drive(ground, 0.4, 1.0, 12.0, tolerance=1e-8)
    motion = sample(simulation, SMALL.mass, np.array([11.0, 12.0]))
    weight = SMALL.mass * ground.model.gravity
    assert motion.load_left + motion.load_right == pytest.approx([weight] * 2)
    a_y = motion.yaw_rate * motion.forward_velocity
    transfer = SMALL.cog_height / SMALL.track_gauge * SMALL.mass * a_y
    assert motion.load_left == pytest.approx(0.5 * weight - transfer, rel=1e-6)


def test_a_tall_vehicle_lifts_its_track():
    tall = replace(SMALL, cog_height=0.6)
    _, end = drive(slope_scene(30, tall, uphill_yaw=0.5 * math.pi), 0.5, 0.5, 5.0)
    assert end is End.LIFTED


def test_turn_time_is_when_the_yaw_is_there():
    simulation, end = drive(slope_scene(12.13), 0.2567, 0.5, 60.0, most_turn=2.0 * math.pi)
    assert end is End.TURNED
    time = turn_time(simulation, 2.0 * math.pi)
    assert sample(simulation, 1.0, np.array([time])).yaw[0] == pytest.approx(2.0 * math.pi, abs=1e-9)
    assert math.isnan(turn_time(simulation, 7.0))


@BOTH
def test_error_falls_with_the_tolerance(remember):
    ground = slope_scene(12.13, remember=remember)
    ends = [drive(ground, 0.25, 0.5, 10.0, tolerance=tolerance)[0].pose for tolerance in (1e-4, 1e-6, 1e-9)]
    coarse, fine = (np.abs(end - ends[-1]).max() for end in ends[:2])
    assert fine < 1e-5
    assert fine < 0.1 * coarse


def fixed_steps(begun, count):
    """Two seconds more of a motion, in steps of one length; the velocities and the pose at the end."""
    simulation, h = copy.deepcopy(begun), 2.0 / count
    run, memory, entries = simulation.run[0], simulation.memory, simulation.entries
    speeds = Speeds(*np.repeat(TURN, 2))
    for step in simulation.steps[:count]:
        if simulation.scene.remember:
            for track in range(2):
                push(memory[track], entries[track], 1.0)
        assert math.isfinite(try_step(simulation.scene, run, h, speeds, memory, entries, 1e-11))
        accept(simulation.scene, run, h, speeds, memory, entries, step)
    return np.append(run["velocity"], run["pose"])


@BOTH
def test_convergence_order(remember):
    """A stiff problem shows a little more than the stage order, which is three."""
    settled, _ = drive(slope_scene(12.13, remember=remember), *TURN, 5.0, tolerance=1e-7)
    exact = fixed_steps(settled, 160)
    coarse, fine = (np.abs(fixed_steps(settled, count) - exact).max() for count in (4, 20))
    assert fine < 1e-9
    assert math.log(coarse / fine) / math.log(5.0) >= 3.2


def test_convergence_order_without_stiffness():
    """Five, that of Radau IIA of three stages, for a free body on the slope: the motion is smooth and not stiff."""
    ground = slope_scene(30.0, terrain=FREE, uphill_yaw=0.3)
    begun = integration(ground, State(0.0, 0.0, 0.2, 0.7, -0.4, 2.0), 0.0, TURN)
    exact = fixed_steps(begun, 64)
    coarse, fine = (np.abs(fixed_steps(begun, count) - exact).max() for count in (4, 16))
    assert math.log(coarse / fine) / math.log(4.0) == pytest.approx(5.0, abs=0.2)
