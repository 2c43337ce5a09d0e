from itertools import product

import h5py
import numpy as np
import pytest
from lut_examples import GRAVITY, TERRAIN, VEHICLE, example_table

from trackctl.errors import LutFormatError
from trackctl.files import lut_details
from trackctl.files.lut_details import count_cells_beyond, read_sensitivity
from trackctl.files.lut_writer import LutWriter, write_lut
from trackctl.sensitivity.pawn import PawnIndex, Statistic

OUTPUTS, INPUTS = ("sprocket_rate_left", "sprocket_rate_right"), ("velocity", "radius", "heading")
INDICES = tuple(
    PawnIndex(output, name, statistic, 0.1 * number, 0.09 * number, 0.11 * number, 0.02)
    for number, (output, name, statistic) in enumerate(product(OUTPUTS, INPUTS, Statistic))
)
STEPS = {"step_velocity": 0.5, "step_reason": "because"}


@pytest.fixture
def table():
    return example_table(slopes=2, curvatures=7)


@pytest.fixture
def lut(tmp_path, table):
    path = tmp_path / "lut.h5"
    with LutWriter(path, table.axes, VEHICLE, TERRAIN, GRAVITY, {}) as writer:
        for i, k in product(range(2), range(7)):
            writer.write_column(
                i, k, {name: values[i, :, k] for name, values in table.values.items()}, table.status[i, :, k]
            )
        writer.write_sensitivity(INDICES, [*INPUTS, *OUTPUTS], np.zeros((3, 5)), STEPS)
    return path


@pytest.mark.parametrize("cells_at_once", [1, 24, 50, 10**6])
@pytest.mark.parametrize("names", [("slip_left",), ("slip_left", "slip_right")])
def test_cells_beyond_a_limit(lut, table, monkeypatch, cells_at_once, names):
    monkeypatch.setattr(lut_details, "COUNTED_CELLS", cells_at_once)
    largest = np.max([np.abs(table.values[name]) for name in names], axis=0)
    expected = int((largest > 1.0).sum())
    assert 0 < expected < table.axes.size
    assert count_cells_beyond(lut, names, 1.0) == expected


def test_cells_without_an_answer_are_not_beyond(lut, table):
    assert count_cells_beyond(lut, ["slip_left"], -1.0) == int(np.isfinite(table.values["slip_left"]).sum())


def test_the_sensitivity_comes_back(lut):
    found = read_sensitivity(lut)
    assert found.indices == INDICES
    assert found.attributes == STEPS


def test_a_table_without_sensitivity(tmp_path, table):
    write_lut(tmp_path / "plain.h5", table)
    assert read_sensitivity(tmp_path / "plain.h5") is None


@pytest.mark.parametrize("name", ["output", "statistic", "index", "dummy"])
def test_a_missing_part(lut, name):
    with h5py.File(lut, "a") as file:
        del file["sensitivity"][name]
    with pytest.raises(LutFormatError, match=rf"lut\.h5: .*{name}: is missing"):
        read_sensitivity(lut)


def test_a_part_of_another_shape(lut):
    with h5py.File(lut, "a") as file:
        del file["sensitivity"]["ci_low"]
        file["sensitivity"]["ci_low"] = np.zeros((2, 3))
    with pytest.raises(LutFormatError, match=r"sensitivity/ci_low: shape \(2, 3\); the labels have \(2, 3, 2\)"):
        read_sensitivity(lut)


def test_an_unknown_statistic(lut):
    with h5py.File(lut, "a") as file:
        file["sensitivity"]["statistic"][0] = "mode"
    with pytest.raises(LutFormatError, match=r"lut\.h5: .*'mode'"):
        read_sensitivity(lut)


@pytest.mark.parametrize("read", [read_sensitivity, lambda path: count_cells_beyond(path, ["slip_left"], 1.0)])
def test_what_is_no_table(tmp_path, read):
    with pytest.raises(LutFormatError, match="cannot be read"):
        read(tmp_path / "none.h5")
