import json
from dataclasses import replace

import numpy as np
import pytest
from solved_tables import CURVATURE, SLOPE, VEHICLE, VELOCITY, solved_table

from trackctl.errors import LutFormatError
from trackctl.files.lut_writer import write_lut
from trackctl.lut.axes import Axes
from trackctl.workflows.describe_lut import (
    AxisDescription,
    RightTurns,
    describe_lut,
    described_axis,
    document,
    plain,
    profile_numbers,
)

ATTRIBUTES = {
    "created": "2024-01-01T00:00:00+00:00",
    "history": "trackctl compute-lut",
    "seed": 3,
    "certificate_max_error": 0.01,
    "certificate_near_straight_max_error": np.nan,
    "swarm_check_cells": 5,
    "step_reason": "explicit steps",
    "quadrature_nodes": np.array([8, 12]),
}


@pytest.fixture(scope="module")
def table():
    return solved_table(**ATTRIBUTES)


@pytest.fixture
def described(tmp_path):
    def describe(table):
        path = tmp_path / "lut.h5"
        write_lut(path, table)
        return describe_lut(path)

    return describe


def test_axes(described, table):
    axes = described(table).axes
    assert axes["slope_rad"] == AxisDescription(1, SLOPE, SLOPE, None)
    assert axes["velocity_mps"] == AxisDescription(4, 0.5, 2.0, 0.5)
    assert axes["radius_m"] == AxisDescription(5, 0.5, 20.0, None)
    assert axes["curvature_1pm"] == AxisDescription(6, 0.0, 2.0, None)
    assert axes["heading_rad"].count == 12
    assert axes["heading_rad"].step == pytest.approx(np.pi / 6, rel=1e-12)


def test_even_and_uneven_steps():
    assert described_axis(np.array([1.0, 2.0, 3.0])).step == 1.0
    assert described_axis(np.array([1.0, 2.0, 3.1])).step is None
    # Radii are stored as curvatures, whose rounding must not count.
    radii = np.linspace(0.366, 36.6, 15)
    assert described_axis(1.0 / (1.0 / radii)).step == pytest.approx(radii[1] - radii[0], rel=1e-12)
    assert described_axis(np.empty(0)) == AxisDescription(0, None, None, None)


def test_right_turns(described, table):
    assert described(table).right_turns is RightTurns.MIRRORED
    off_centre = replace(table, vehicle=replace(VEHICLE, cog_left=0.05))
    assert described(off_centre).right_turns is RightTurns.MISSING
    axes = Axes(table.axes.slope, VELOCITY, CURVATURE - 0.2, table.axes.heading, True)
    assert described(replace(table, axes=axes)).right_turns is RightTurns.STORED


def test_cells_beyond_the_limits(described, table):
    rates = np.maximum(np.abs(table.values["sprocket_rate_left"]), np.abs(table.values["sprocket_rate_right"]))
    forces = np.maximum(np.abs(table.values["traction_left"]), np.abs(table.values["traction_right"]))
    vehicle = replace(VEHICLE, max_sprocket_rate=15.0, max_track_force=300.0)
    found = described(replace(table, vehicle=vehicle))
    assert (found.beyond_rate, found.beyond_force) == ((rates > 15.0).sum(), (forces > 300.0).sum())
    assert 0 < found.beyond_rate < rates.size
    assert 0 < found.beyond_force < rates.size
    assert described(table).beyond_force is None


def test_attributes_by_section(described, table):
    sections = described(table).sections
    assert sections["certificate"] == {"max_error": 0.01}
    assert list(sections["certificate_near_straight"]) == ["max_error"]
    assert sections["swarm_check"] == {"cells": 5}
    assert sections["steps"] == {"reason": "explicit steps"}
    assert list(sections["settings"]) == ["seed", "quadrature_nodes"]


def test_profile_numbers_have_the_keys_and_units_of_files(table):
    numbers = profile_numbers(replace(table.terrain, cohesion=2000.0))
    assert numbers["cohesion_kpa"] == 2.0
    assert "lateral_friction_coefficient" not in numbers
    assert profile_numbers(VEHICLE)["mass_kg"] == VEHICLE.mass


def test_the_document_is_strict_json(described, table):
    found = document(described(table))
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert found["cells"] == sum(found["status"].values()) == table.axes.size
    assert found["created"] == ATTRIBUTES["created"]
    assert found["certificate_near_straight"] == {"max_error": None}
    assert found["settings"]["quadrature_nodes"] == [8, 12]
    assert found["right_turns"] == "mirrored"
    assert found["sensitivity"] is None


def test_plain_values():
    assert plain({"a": (1, np.array([1.0, np.inf])), "b": [np.nan, "x"]}) == {
        "a": [1, [1.0, None]],
        "b": [None, "x"],
    }


def test_what_is_no_table(tmp_path):
    (tmp_path / "empty.h5").touch()
    with pytest.raises(LutFormatError, match=r"empty\.h5: is empty"):
        describe_lut(tmp_path / "empty.h5")
