import math

import numpy as np
import pytest

from trackctl.errors import InputFileError
from trackctl.files.csv_table import read_csv
from trackctl.workflows.operating_points import curvature_of, read_points


@pytest.fixture
def points_of(tmp_path):
    def read(text):
        path = tmp_path / "points.csv"
        path.write_text(text)
        return read_points(read_csv(path))

    return read


def test_si_columns(points_of):
    points = points_of("velocity_mps,curvature_1pm,heading_rad,slope_rad\n1,-0.2,3,0.1\n2,0,-1,0.2\n")
    np.testing.assert_array_equal(points.velocity, [1.0, 2.0])
    np.testing.assert_array_equal(points.curvature, [-0.2, 0.0])
    np.testing.assert_array_equal(points.heading, [3.0, -1.0])
    np.testing.assert_array_equal(points.slope, [0.1, 0.2])


def test_other_units_in_any_order(points_of):
    points = points_of("heading_deg,note,radius_cm,slope_deg,velocity_kmph\n90,x,-500,12,7.2\n")
    values = [float(each[0]) for each in (points.velocity, points.curvature, points.heading, points.slope)]
    assert values == pytest.approx([2.0, -0.2, math.pi / 2.0, math.radians(12.0)], rel=1e-15)


def test_the_slope_may_be_left_out(points_of):
    assert points_of("velocity_mps,radius_m,heading_rad\n1,5,0\n").slope is None


def test_straight_ahead_is_an_infinite_radius_either_way(points_of):
    points = points_of("velocity_mps,radius_m,heading_rad\n1,inf,0\n1,-inf,0\n")
    np.testing.assert_array_equal(points.curvature, [0.0, 0.0])
    assert not np.signbit(points.curvature).any()


def test_turning_on_the_spot_has_an_infinite_curvature():
    np.testing.assert_array_equal(curvature_of(np.array([0.0, -0.0])), [np.inf, -np.inf])


ROW = "velocity_mps,radius_m,heading_rad\n1,5,0\n"


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (ROW + "0,5,0\n", "line 3: column velocity_mps: '0' is not allowed; allowed: above 0"),
        (ROW + "-1,5,0\n", "line 3: column velocity_mps: '-1' is not allowed; allowed: above 0"),
        (ROW + "inf,5,0\n", "line 3: column velocity_mps: 'inf' is not allowed"),
        (ROW + ",5,0\n", "line 3: column velocity_mps: '' is not allowed; allowed: a number"),
        (ROW + "1,nan,0\n", "line 3: column radius_m: 'nan' is not allowed; allowed: a number"),
        (ROW + "1,5,\n", "line 3: column heading_rad: '' is not allowed; allowed: a number"),
        (ROW + "1,5,north\n", "line 3: column heading_rad: 'north' is not allowed"),
        ("velocity_kmph,radius_m,heading_rad\n-3.6,5,0\n", "line 2: column velocity_kmph: '-3.6' is not"),
        ("velocity_mps,heading_rad\n1,0\n", "column radius_m or curvature_1pm is missing; there are: vel"),
        (
            "velocity_mps,radius_cm,curvature_1pm,heading_rad\n1,1,1,1\n",
            "columns radius_cm and curvature_1pm mean the same; allowed: one of them",
        ),
        ("velocity_mps,radius_deg,heading_rad\n1,1,1\n", "column 'radius_deg' has no unit of radius"),
        ("radius_m,heading_rad\n1,1\n", "column velocity_mps or .* is missing"),
        ("velocity_mps,curvature_1pm,heading_rad\n1,inf,1\n", "column curvature_1pm: 'inf' is not allowed"),
        ("velocity_mps,radius_m,heading_rad,slope_deg\n1,5,0,\n", "column slope_deg: '' is not allowed"),
    ],
)
def test_what_is_no_operating_point(points_of, text, problem):
    with pytest.raises(InputFileError, match=rf"points\.csv.*{problem}"):
        points_of(text)
