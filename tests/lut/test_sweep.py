from dataclasses import replace

import numpy as np
import pytest

from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.lut.axes import FULL_CIRCLE, Axes
from trackctl.lut.cells import pending_cells
from trackctl.lut.crew import AHEAD, solve_columns, threads
from trackctl.lut.sweep import Seeding, Sweep, column_values, solve
from trackctl.lut.table import VARIABLES, Status
from trackctl.mechanics.parameters import track_model

VEHICLE = load_vehicle("utv-61cm")
MODEL = track_model(VEHICLE, load_terrain("asphalt"))
AXES = Axes(
    slope=np.radians([4.0, 12.0]),
    velocity=np.array([0.5, 1.0, 2.0]),
    curvature=np.array([0.0, 0.2, 0.8]),
    heading=np.arange(8) * FULL_CIRCLE / 8,
    heading_is_periodic=True,
)
SWEEP = Sweep(MODEL, AXES, Seeding.CONTINUATION, 0)


def test_columns_come_once_each_with_their_own_cells():
    with threads(2) as crew:
        found = dict(solve_columns(SWEEP, range(SWEEP.column_count), crew))
    assert set(found) == set(range(6))
    for column, cells in found.items():
        assert cells.tobytes() == solve(SWEEP, column).tobytes()
    assert SWEEP.place(4) == (1, 1)


def test_swarms_in_every_cell_find_the_same_roots():
    by_swarm = replace(SWEEP, seeding=Seeding.PSO)
    for column in range(SWEEP.column_count):
        cells, again = solve(SWEEP, column), solve(by_swarm, column)
        solved = cells["status"] == Status.CONVERGED
        assert (solved == (again["status"] == Status.CONVERGED)).all()
        # Both meet a residual tolerance that puts them 1e-9 apart at most.
        assert np.abs(cells["unknowns"] - again["unknowns"])[solved].max() < 1e-8


def test_few_columns_are_under_way_at_a_time(monkeypatch):
    monkeypatch.setattr("trackctl.lut.crew.solve", lambda sweep, column: pending_cells((1, 1)))
    asked = []

    def columns():
        for column in range(100):
            asked.append(column)
            yield column

    with threads(1) as crew:
        found = solve_columns(SWEEP, columns(), crew)
        next(found)
        assert len(asked) <= AHEAD
        assert len(list(found)) == 99


def test_values_of_a_column_are_those_of_its_cells():
    column = 5
    cells = solve(SWEEP, column)
    cells["status"][0, 0] = Status.INFEASIBLE_GRIP
    values = column_values(SWEEP, column, cells, VEHICLE.sprocket_radius, 2.0)
    assert set(values) == set(VARIABLES)
    for name, array in values.items():
        assert np.isnan(array[0, 0]) == (name != "residual")
    at = (1, 2)
    speed = values["sprocket_rate_left"][at] * VEHICLE.sprocket_radius
    assert speed == pytest.approx(cells["unknowns"][at][0] * 1.0)
    body = np.cos(values["sideslip"][at]) - 0.8 * 0.5 * VEHICLE.track_gauge
    assert values["slip_left"][at] == pytest.approx((speed - body) / max(speed, body))
    assert values["traction_right"][at] == 2.0 * cells["traction"][at][1]
