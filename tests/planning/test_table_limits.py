import numpy as np
import pytest
from solved_tables import SLOPE, TERRAIN, VEHICLE, solved_table

from trackctl.lut.point import solve_points
from trackctl.mechanics.parameters import track_model
from trackctl.planning.table_limits import driven_backwards, searched, table_limits


@pytest.fixture(scope="module")
def limits():
    return table_limits(solved_table(), VEHICLE, 2.0, 2.0)


def test_what_is_given_out_is_feasible_in_the_model(limits):
    """The body lies at direction - sideslip and turns there at the speed that is given out."""
    points = [
        (SLOPE, limits.speed[0, k, n], limits.curvature[k], limits.direction[n] - limits.sideslip[0, k, n])
        for k in range(limits.curvature.size)
        for n in range(0, 48, 4)
        if limits.speed[0, k, n] > 0.0
    ]
    cells = solve_points(track_model(VEHICLE, TERRAIN), np.array(points))
    assert (cells["status"] == 0).all()
    left, right, _ = cells["unknowns"].T
    rate = np.maximum(left, right) * np.array(points)[:, 1] / VEHICLE.sprocket_radius
    assert (rate <= VEHICLE.max_sprocket_rate).all()


def test_right_turns_mirror_left_turns(limits):
    mirrored = -np.arange(48) % 48
    assert limits.speed[0, ::-1][:, mirrored] == pytest.approx(limits.speed[0], abs=1e-9)
    assert limits.sideslip[0, ::-1][:, mirrored] == pytest.approx(-limits.sideslip[0], abs=1e-9)


def test_driving_backwards_twice_is_driving_forwards(limits):
    twice = driven_backwards(driven_backwards(limits))
    assert twice.curvature == pytest.approx(limits.curvature)
    np.testing.assert_array_equal(twice.speed, limits.speed)
    backwards = driven_backwards(limits)
    # Straight down-slope backwards is straight up-slope forwards, seen from behind.
    middle = limits.curvature.size // 2
    assert backwards.work[0, middle, 24] == limits.work[0, middle, 0]


def test_a_search_has_less_curvature_than_its_blends(limits):
    assert searched(limits).curvature[-1] == pytest.approx(0.92 * 2.0)
    assert searched(limits).speed.shape == (1, limits.curvature.size - 2, 48)
