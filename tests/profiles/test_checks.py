import math

import pytest

from trackctl.profiles.checks import Quantity

CLOSED = Quantity("length", "m", 0.0, 2.0, "of it")
OPEN = Quantity("friction", "", 0.0, 3.0, "of it", low_excluded=True)


def test_key_carries_the_unit():
    assert CLOSED.key == "length_m"
    assert OPEN.key == "friction"


@pytest.mark.parametrize("value", [0, 0.0, 1, 2.0])
def test_ends_of_a_range_are_in_it(value):
    assert CLOSED.allows(value)


@pytest.mark.parametrize("value", [-1e-300, 2.0000001, math.nan, math.inf, -math.inf, 10**400, True, "1", None, [1.0]])
def test_what_is_no_number_in_the_range_is_refused(value):
    assert not CLOSED.allows(value)


def test_an_open_end_is_out_of_range():
    assert not OPEN.allows(0.0)
    assert OPEN.allows(1e-9)


def test_the_range_is_told_in_the_unit_asked_for():
    assert CLOSED.allowed() == "0 to 2"
    assert CLOSED.allowed(1e-3) == "0 to 2000"
    assert OPEN.allowed() == "above 0, up to 3"
