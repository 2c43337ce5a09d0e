import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from systems import disk_of, needs_file_limit
from table_runs import RANGES, VEHICLE, StoppedError, compiled, request, stop_after

from trackctl.errors import InputFileError, NoAnswerError, OutputError, UsageError
from trackctl.files.journal import journal_path
from trackctl.files.lut_reader import read_lut
from trackctl.files.profile_yaml import load_terrain
from trackctl.lut import crew
from trackctl.lut.cells import pending_cells
from trackctl.lut.table import Status
from trackctl.workflows.compute_lut import checkpoint
from trackctl.workflows.table_steps import explicit_steps

SLIPPERY = replace(load_terrain("asphalt"), friction_coefficient=0.05)


@pytest.fixture
def whole(tmp_path):
    compiled(tmp_path / "whole.h5")
    return (tmp_path / "whole.h5").read_bytes()


def test_the_file_holds_cells_settings_and_certificate(tmp_path):
    output = tmp_path / "lut.h5"
    summary = compiled(output)
    table = read_lut(output)
    assert table.axes.shape == request().axes.shape == (1, 3, 7, 12)
    assert (table.status == Status.CONVERGED).sum() == summary.status_counts[Status.CONVERGED]
    assert table.attributes["certificate_max_error"] == summary.certificate.max_error
    assert table.attributes["swarm_check_different_root"] == 0
    assert table.attributes["step_radius"] == 1.0
    assert {"seed", "seeding", "solver", "residual_tolerance", "created", "history"} <= set(table.attributes)
    assert list(tmp_path.iterdir()) == [output]


@pytest.mark.parametrize("columns", [0, 1, 4, 6])
@pytest.mark.parametrize("jobs", [1, 2])
def test_a_stopped_run_resumes_to_the_same_bytes(tmp_path, whole, columns, jobs):
    output = tmp_path / "lut.h5"
    with pytest.raises(StoppedError):
        compiled(output, jobs=2, progress=stop_after(columns))
    assert journal_path(output).exists()
    assert not output.exists()
    compiled(output, jobs=jobs, resume=True)
    assert output.read_bytes() == whole
    assert not journal_path(output).exists()


def test_a_checkpoint_is_not_overwritten_unasked_nor_resumed_for_another_request(tmp_path, whole):
    output = tmp_path / "lut.h5"
    with pytest.raises(StoppedError):
        compiled(output, progress=stop_after(2))
    with pytest.raises(OutputError, match="--resume continues it"):
        compiled(output)
    with pytest.raises(InputFileError, match="another request"):
        compiled(output, request("grass"), resume=True)
    compiled(output, force=True)
    assert output.read_bytes() == whole


def test_a_replacing_run_resumes_too(tmp_path, whole):
    output = tmp_path / "lut.h5"
    output.write_text("old")
    with pytest.raises(StoppedError):
        compiled(output, force=True, progress=stop_after(2))
    assert output.read_text() == "old"
    compiled(output, resume=True, force=True)
    assert output.read_bytes() == whole


def test_a_table_without_a_feasible_cell_leaves_nothing(tmp_path):
    with pytest.raises(NoAnswerError, match=r"no cell of the table is feasible: .* infeasible_grip"):
        compiled(tmp_path / "lut.h5", replace(request(slope_deg=30.0), terrain=SLIPPERY))
    assert list(tmp_path.iterdir()) == []


def test_a_second_writer_is_refused(tmp_path):
    output = tmp_path / "lut.h5"
    with checkpoint(request(), output, resume=False, force=False):
        with pytest.raises(OutputError, match="in use by another run"):
            compiled(output)
        with pytest.raises(OutputError, match="in use by another run"):
            compiled(output, resume=True)


@pytest.mark.parametrize("name", ["-", "/dev/stdout", "/dev/null"])
def test_a_stream_is_refused(name):
    with pytest.raises(UsageError, match="--output"):
        compiled(Path(name))


@needs_file_limit
@pytest.mark.parametrize("limit", [2_000, 30_000])
def test_a_full_disk_keeps_the_checkpoint(tmp_path, whole, limit):
    """The smaller limit is met by the checkpoint, the larger one by the table."""
    output = tmp_path / "lut.h5"
    with disk_of(limit), pytest.raises(OutputError, match="--resume continues"):
        compiled(output)
    assert not output.exists()
    compiled(output, resume=True)
    assert output.read_bytes() == whole


def test_turns_to_both_sides_mirror_a_mirrored_vehicle(tmp_path):
    left, right = (replace(VEHICLE, cog_left=offset) for offset in (0.03, -0.03))
    for name, vehicle in (("left", left), ("right", right)):
        compiled(tmp_path / f"{name}.h5", request(vehicle=vehicle))
    one, other = read_lut(tmp_path / "left.h5"), read_lut(tmp_path / "right.h5")
    assert one.axes.shape == (1, 3, 13, 12)
    mirrored = other.values["sprocket_rate_right"][:, :, ::-1, -np.arange(12)]
    # Both are solved to 1e-9 or better.
    np.testing.assert_allclose(one.values["sprocket_rate_left"], mirrored, rtol=1e-7)


def test_cells_are_packed_in_little_memory(tmp_path, monkeypatch):
    """Beside the table's 25 bytes a cell a run holds a few columns."""

    def stand_in(asked, column):
        cells = pending_cells((asked.axes.velocity.size, asked.axes.heading.size))
        for name in ("unknowns", "traction", "residual"):
            cells[name] = 1.0
        cells["status"] = Status.CONVERGED
        return cells

    monkeypatch.setattr(crew, "solve", stand_in)
    steps = explicit_steps(RANGES, 0.01, 0.1, np.radians(1.0))
    asked = request().divided(steps.divisions)
    tracemalloc.start()
    try:
        compiled(tmp_path / "lut.h5", asked)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert asked.axes.size > 1_800_000
    assert peak < 50 * asked.axes.size
