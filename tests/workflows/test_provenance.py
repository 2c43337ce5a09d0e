import pytest

from trackctl import __version__
from trackctl.errors import UsageError
from trackctl.workflows.provenance import provenance


def test_the_command_line_can_be_run_again(monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    made = provenance(["compute-lut", "-o", "a b.h5"])
    assert made.created == "1970-01-01T00:00:00+00:00"
    assert made.history == f"{made.created} trackctl {__version__}: trackctl compute-lut -o 'a b.h5'"


def test_the_clock_is_read_without_an_epoch(monkeypatch):
    monkeypatch.delenv("SOURCE_DATE_EPOCH", raising=False)
    assert provenance([]).created > "2024"


@pytest.mark.parametrize("epoch", ["yesterday", "1.5", "9" * 30])
def test_a_wrong_epoch_is_refused(monkeypatch, epoch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)
    with pytest.raises(UsageError, match="SOURCE_DATE_EPOCH"):
        provenance([])
