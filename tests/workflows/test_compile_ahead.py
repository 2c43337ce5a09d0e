"""The process that compiles ahead of a first run."""

import os
import subprocess

from trackctl.workflows import compile_ahead
from trackctl.workflows.compile_ahead import compiling_ahead


def test_the_other_process_does_all_that_it_is_for(monkeypatch):
    monkeypatch.setattr(compile_ahead, "kernels_are_compiled", lambda: False)
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    with compiling_ahead() as wait:
        assert wait() == 0


def test_the_other_process_ends_with_the_block(monkeypatch):
    started = []

    class Noted(subprocess.Popen):
        def __init__(self, *arguments, **options):
            super().__init__(*arguments, **options)
            started.append(self)

    monkeypatch.setattr(compile_ahead, "kernels_are_compiled", lambda: False)
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    monkeypatch.setattr(subprocess, "Popen", Noted)
    with compiling_ahead():
        pass
    assert started[0].returncode is not None


def test_there_is_no_other_process_where_it_would_not_help(monkeypatch):
    monkeypatch.setattr(compile_ahead, "kernels_are_compiled", lambda: True)
    with compiling_ahead() as wait:
        assert wait() is None
    monkeypatch.setattr(compile_ahead, "kernels_are_compiled", lambda: False)
    monkeypatch.setattr(os, "cpu_count", lambda: 1)
    with compiling_ahead() as wait:
        assert wait() is None
