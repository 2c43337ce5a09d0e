import json
from pathlib import Path

import numpy as np
import pytest
from system_words import NO_SPACE
from systems import FULL_DISK, needs_full_disk

from trackctl.cli.csv_output import CsvOutput
from trackctl.errors import OutputError, UsageError

COLUMNS = {"x_m": np.array([1.0, np.nan]), "note": ["a", "日本"]}
TEXT = "x_m,note\n1.0,a\n,日本\n"
SUMMARY = {"rows": 2}


@pytest.mark.parametrize("output", [None, Path("-")])
def test_standard_output(output, capfdbinary):
    CsvOutput(output, False, False).write(COLUMNS, SUMMARY)
    assert capfdbinary.readouterr().out == TEXT.encode()


def test_a_file(tmp_path, capsys):
    path = tmp_path / "out.csv"
    CsvOutput(path, False, False).write(COLUMNS, SUMMARY)
    assert path.read_bytes() == TEXT.encode()
    assert capsys.readouterr().out == ""


def test_a_summary_takes_standard_output(tmp_path, capsys):
    CsvOutput(None, False, True).write(COLUMNS, SUMMARY)
    assert json.loads(capsys.readouterr().out) == SUMMARY
    CsvOutput(tmp_path / "out.csv", False, True).write(COLUMNS, SUMMARY)
    assert json.loads(capsys.readouterr().out) == SUMMARY
    assert (tmp_path / "out.csv").read_text(encoding="utf-8") == TEXT


def test_a_table_and_a_summary_do_not_share_standard_output():
    with pytest.raises(UsageError, match="--output: - is not allowed; allowed: a file"):
        CsvOutput(Path("-"), False, True).check()


def test_an_existing_file_is_replaced_only_by_force(tmp_path):
    path = tmp_path / "out.csv"
    path.write_text("old")
    with pytest.raises(OutputError, match="--force"):
        CsvOutput(path, False, False).check()
    CsvOutput(path, True, False).check()
    CsvOutput(path, True, False).write(COLUMNS, SUMMARY)
    assert path.read_text(encoding="utf-8") == TEXT


@pytest.mark.parametrize("path", ["missing/out.csv", "."])
def test_places_that_cannot_be_written(tmp_path, path):
    with pytest.raises(OutputError):
        CsvOutput(tmp_path / path, False, False).check()


@needs_full_disk
def test_a_full_disk():
    with pytest.raises(OutputError, match=f"/dev/full: cannot be written: {NO_SPACE}"):
        CsvOutput(FULL_DISK, False, False).write(COLUMNS, SUMMARY)
