import numpy as np
import pytest

from trackctl.errors import InputFileError
from trackctl.files.path_csv import read_waypoints


@pytest.fixture
def waypoints_of(tmp_path):
    def read(text):
        path = tmp_path / "path.csv"
        path.write_bytes(text.encode())
        return read_waypoints(path)

    return read


def test_points_and_speeds(waypoints_of):
    found = waypoints_of("x_m,y_m,speed_kmph,note\r\n0,0,0,a\r\n1,0.5,7.2,b\r\n2,0,3.6,c\r\n")
    assert found.x.tolist() == [0.0, 1.0, 2.0]
    assert found.y.tolist() == [0.0, 0.5, 0.0]
    assert found.speed == pytest.approx([0.0, 2.0, 1.0])


def test_a_plan_has_its_own_name_for_speed(waypoints_of):
    assert waypoints_of("time_s,x_m,y_m,yaw_rad,velocity_mps\n0,0,0,0,1\n1,1,0,0,1\n").speed.tolist() == [1.0, 1.0]
    assert waypoints_of("x_cm,y_cm\n0,0\n100,0\n").speed is None


def test_repeated_points_are_left_out(waypoints_of):
    found = waypoints_of("x_m,y_m,speed_mps\n0,0,1\n0,0,1\n1,0,2\n1,1e-9,2\n1,1,3\n")
    assert (found.x.tolist(), found.speed.tolist()) == ([0.0, 1.0, 1.0], [1.0, 2.0, 3.0])
    assert found.repeated == 2


def test_closed_paths_are_allowed(waypoints_of):
    assert waypoints_of("x_m,y_m\n0,0\n5,0\n5,5\n0,5\n0,0\n").x.size == 5


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "line 1: is empty"),
        ("0,0\n1,1\n", "begins with numbers"),
        ("x_m,y_m\n", "has a header but no rows"),
        ("x_m,y_m\n0,0\n", "has 1 waypoints at one place; allowed: 2 or more apart"),
        ("x_m,y_m\n3,3\n3,3\n", "has 2 waypoints at one place"),
        ("x_m\n0\n1\n", "column y_m or y_mm"),
        ("x,y_m\n0,0\n1,1\n", "column 'x' has no unit of x"),
        ("x_m,y_m\n0,0\n1,nan\n", "line 3: column y_m: 'nan' is not allowed"),
        ("x_m,y_m\n0,0\n1,\n", "line 3: column y_m: '' is not allowed"),
        ("x_m,y_m\n0,0\ninf,1\n", "line 3: column x_m: 'inf' is not allowed"),
        ("x_m,y_m\n0,0\n1e300,1\n", "line 3: column x_m: '1e300' is not allowed; allowed: -1e+08 to 1e+08 m"),
        ("x_m,y_m\n0,0\n1,0\n0.5,0.1\n", "line 3: the path turns back here, by 169 deg"),
        ("x_m,y_m\n0,0\n2,0\n1,0\n3,0\n", "line 3: the path turns back here, by 180 deg"),
        ("x_m,y_m,speed_mps\n0,0,1\n1,0,-1\n", "line 3: column speed_mps: '-1' is not allowed; allowed: 0 to 100"),
        ("x_m,y_m,speed_mps\n0,0,1\n1,0,1e9\n", "line 3: column speed_mps: '1e9' is not allowed; allowed: 0 to 100"),
        ("x_m,y_m,speed_mps\n0,0,1\n1,0,0\n2,0,1\n", "line 3: column speed_mps: '0' is not allowed; allowed: above 0"),
        ("x_m,y_m,velocity_mps\n0,0,1\n1,0,\n2,0,1\n", "line 3: column velocity_mps: '' is not allowed"),
    ],
)
def test_what_is_no_path_is_refused_with_its_place(waypoints_of, text, problem):
    with pytest.raises(InputFileError) as error:
        waypoints_of(text)
    assert problem in str(error.value)


def test_the_line_is_that_of_the_file_even_after_repeats(waypoints_of):
    with pytest.raises(InputFileError, match="line 5"):
        waypoints_of("x_m,y_m\n0,0\n0,0\n\n1,0\n0,0\n")


def test_many_points_are_read_in_order(waypoints_of):
    text = "x_m,y_m\n" + "".join(f"{k * 0.1!r},{k % 7 * 1e-3!r}\n" for k in range(5000))
    assert (np.diff(waypoints_of(text).x) > 0.0).all()
