import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackctl.planning.occupancy import FREE, OCCUPIED, UNKNOWN, GridFrame, Occupancy

numbers = st.floats(-100.0, 100.0)
frames = st.builds(
    GridFrame, st.integers(1, 50), st.integers(1, 50), st.floats(0.01, 10.0), numbers, numbers, st.floats(-4.0, 4.0)
)


@given(frames, numbers, numbers)
def test_to_the_grid_and_back(frame, x, y):
    np.testing.assert_allclose(frame.to_world(*frame.to_grid(x, y)), (x, y), atol=1e-10)


def test_a_turned_grid_by_its_closed_form():
    frame = GridFrame(10, 20, 0.1, 2.0, 3.0, math.radians(90.0))
    # A quarter turn: columns run along y, rows along -x.
    np.testing.assert_allclose(frame.to_world(5.0, 0.0), (2.0, 3.5))
    np.testing.assert_allclose(frame.to_world(0.0, 5.0), (1.5, 3.0))
    assert frame.cell(1.95, 3.05) == (0, 0)
    assert frame.cell(1.05, 4.95) == (9, 19)
    assert frame.cell(2.05, 3.05) is None
    assert frame.cell(0.95, 3.05) is None
    assert frame.cell(1.95, 5.05) is None


@given(frames, st.data())
def test_a_cells_centre_is_in_the_cell(frame, data):
    row = data.draw(st.integers(0, frame.n_rows - 1))
    column = data.draw(st.integers(0, frame.n_columns - 1))
    assert frame.cell(*frame.to_world(column + 0.5, row + 0.5)) == (row, column)


@pytest.mark.parametrize(("allow_unknown", "blocked"), [(False, [0, 1, 1, 1, 1]), (True, [0, 0, 0, 0, 1])])
def test_what_is_not_free_is_blocked_unless_unknown_ground_is_allowed(allow_unknown, blocked):
    cells = np.array([[FREE, UNKNOWN, 1, 99, OCCUPIED]], np.int8)
    occupancy = Occupancy(cells, GridFrame(1, 5, 1.0, 0.0, 0.0), "a")
    np.testing.assert_array_equal(occupancy.blocked(allow_unknown=allow_unknown)[0], blocked)
