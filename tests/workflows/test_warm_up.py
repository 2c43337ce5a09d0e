"""The process that compiles ahead of a first run."""

import os
import subprocess

import pytest

from trackctl import compiled
from trackctl.compiled import kernels_are_compiled
from trackctl.workflows import compile_ahead
from trackctl.workflows.compile_ahead import TASKS, compiling_ahead, make_ready


def with_cores(monkeypatch, count, is_compiled=False):
    monkeypatch.setattr(compile_ahead, "kernels_are_compiled", lambda kernel: is_compiled)
    monkeypatch.setattr(os, "cpu_count", lambda: count)


@pytest.mark.parametrize("task", TASKS)
def test_another_process_does_all_that_it_is_for(monkeypatch, task):
    with_cores(monkeypatch, 2)
    with compiling_ahead(task) as wait:
        assert wait(task) == 0
    assert kernels_are_compiled(TASKS[task][1])


def test_what_has_been_compiled_is_not_used_again(monkeypatch):
    used = []
    monkeypatch.setitem(TASKS, "search", (lambda: used.append("search"), "simplification.simplify"))
    for is_compiled in (True, False):
        with_cores(monkeypatch, 2, is_compiled)
        make_ready("search")
    assert used == ["search"]


def test_the_other_processes_end_with_the_block(monkeypatch):
    started = []

    class Noted(subprocess.Popen):
        def __init__(self, *arguments, **options):
            super().__init__(*arguments, **options)
            started.append(self)

    with_cores(monkeypatch, 2)
    monkeypatch.setattr(subprocess, "Popen", Noted)
    with compiling_ahead("search", "simulation"):
        pass
    assert len(started) == 2
    assert all(each.returncode is not None for each in started)


def test_there_is_no_other_process_where_it_would_not_help(monkeypatch):
    with_cores(monkeypatch, 2, is_compiled=True)
    with compiling_ahead("search") as wait:
        assert wait("search") is None
    with_cores(monkeypatch, 1)
    with compiling_ahead("search") as wait:
        assert wait("search") is None


def test_there_is_no_other_process_where_nothing_can_be_kept(monkeypatch, tmp_path):
    with_cores(monkeypatch, 2)
    (tmp_path / "file").touch()
    monkeypatch.setattr(compiled, "kernel_folder", lambda: tmp_path / "file" / "kernels")
    monkeypatch.setattr(compile_ahead, "other_process", None)
    with compiling_ahead("search") as wait:
        assert wait("search") is None
