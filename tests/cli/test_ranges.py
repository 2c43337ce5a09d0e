import pytest

from trackctl.cli.ranges import list_of, named_numbers, range_of
from trackctl.errors import UsageError

NAMES = ("velocity", "radius", "heading")


@pytest.mark.parametrize(("text", "ends"), [("1:2", (1.0, 2.0)), ("3", (3.0, 3.0)), ("0.5:0.5", (0.5, 0.5))])
def test_ranges(text, ends):
    assert range_of(text, "--radius-m") == ends


@pytest.mark.parametrize(
    ("text", "values"),
    [("12.13", [12.13]), ("0,5,10", [0, 5, 10]), ("0:10:5", [0, 5, 10]), ("0:0.3:0.1", [0, 0.1, 0.2, 0.3])],
)
def test_lists(text, values):
    assert list_of(text, "--slope-deg") == pytest.approx(values)


def test_named_numbers():
    assert named_numbers("radius=1, velocity=.5,heading=1e1", NAMES, "--steps") == {
        "velocity": 0.5,
        "radius": 1.0,
        "heading": 10.0,
    }


@pytest.mark.parametrize("text", ["", "a", "2:1", "1:2:3", "nan:2", "1:inf", ":", "1:"])
def test_wrong_ranges_are_refused(text):
    with pytest.raises(UsageError, match=r"--radius-m: .* is not allowed; allowed: MIN:MAX"):
        range_of(text, "--radius-m")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "0:10",
        "10:0:1",
        "0:10:0",
        "0:10:-1",
        "5,5",
        "10,5",
        "1,,2",
        "nan",
        "0:10:1e-9",
        "0:1e308:1e-308",
        "0:10:nan",
    ],
)
def test_wrong_lists_are_refused(text):
    with pytest.raises(UsageError, match=r"--slope-deg: .* is not allowed"):
        list_of(text, "--slope-deg")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "velocity=1",
        "velocity=1,radius=1,speed=1",
        "velocity=1,radius=1,heading=x",
        "velocity=1,velocity=1,radius=1",
    ],
)
def test_wrong_names_are_refused(text):
    with pytest.raises(UsageError, match=r"--steps: .* is not allowed; allowed: velocity=NUMBER|--steps: .*"):
        named_numbers(text, NAMES, "--steps")
