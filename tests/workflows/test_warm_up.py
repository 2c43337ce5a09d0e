"""Kernels compiled before they are needed, side by side."""

import subprocess
import sys

import pytest

from trackctl.workflows import warm_up
from trackctl.workflows.warm_up import PIECES, TASKS, Piece, estimate, missing

SMALL = {"first": 3.0, "second": 2.0, "third": 1.0}


@pytest.fixture
def small(monkeypatch, tmp_path):
    """Three pieces that compile nothing, and what is compiled in this process."""
    compiled = []
    monkeypatch.setenv("TRACKCTL_CACHE_DIR", str(tmp_path / "cache"))
    pieces = {name: Piece(lambda name=name: compiled.append(name), seconds) for name, seconds in SMALL.items()}
    monkeypatch.setattr(warm_up, "PIECES", pieces)
    monkeypatch.setattr(warm_up, "TASKS", {"all": tuple(SMALL), "some": ("third", "first")})
    return compiled


def with_cores(monkeypatch, count):
    monkeypatch.setattr(warm_up, "cores", lambda: count)


def with_workers(monkeypatch, code):
    """Let other processes run some code in place of theirs."""
    popen = subprocess.Popen

    def started(command, **pipes):
        return popen([sys.executable, "-c", code], **pipes)

    monkeypatch.setattr(warm_up.subprocess, "Popen", started)


ECHO = "import sys\nfor line in sys.stdin: print(line.strip(), flush=True)"
FAIL_AT_SECOND = """
import sys
for line in sys.stdin:
    if line == "second\\n": sys.exit(1)
    print(line.strip(), flush=True)
"""


def test_every_task_is_made_of_pieces():
    assert {name for names in TASKS.values() for name in names} == set(PIECES)


def test_on_one_core_pieces_are_compiled_here_once(small, monkeypatch):
    with_cores(monkeypatch, 1)
    assert missing(["some"]) == ["first", "third"]
    warm_up.warm_up(missing(["some"]))
    assert small == ["first", "third"]
    assert missing(["all"]) == ["second"]


def test_on_several_cores_other_processes_compile_them(small, monkeypatch):
    with_cores(monkeypatch, 2)
    with_workers(monkeypatch, ECHO)
    told = []
    warm_up.warm_up(missing(["all"]), lambda done, total: told.append((done, total)))
    assert small == []
    assert told[0] == (0, 100)
    assert told[-1] == (100, 100)
    assert told == sorted(told)
    assert len(told) == 4


def test_what_another_process_fails_at_is_compiled_here(small, monkeypatch):
    with_cores(monkeypatch, 2)
    with_workers(monkeypatch, FAIL_AT_SECOND)
    warm_up.warm_up(missing(["all"]))
    assert "second" in small


def test_processes_that_cannot_run_leave_all_to_this_one(small, monkeypatch):
    with_cores(monkeypatch, 2)
    with_workers(monkeypatch, "")
    warm_up.warm_up(missing(["all"]))
    assert small == list(SMALL)


def test_where_nothing_can_be_kept_all_is_compiled_here(small, monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("TRACKCTL_CACHE_DIR", str(tmp_path / "file" / "cache"))
    with_cores(monkeypatch, 2)
    monkeypatch.setattr(warm_up.subprocess, "Popen", None)
    assert estimate(missing(["all"])) == 6.0
    warm_up.warm_up(missing(["all"]))
    assert small == list(SMALL)
    assert missing(["all"]) == list(SMALL)


def test_the_estimate_counts_on_all_cores(small, monkeypatch):
    with_cores(monkeypatch, 2)
    assert estimate(missing(["all"])) == 3.0
    assert estimate(["third"]) == 1.0


def test_an_interrupt_ends_the_other_processes(small, monkeypatch):
    with_cores(monkeypatch, 2)
    with_workers(monkeypatch, "import time; time.sleep(600)")
    started = []
    popen = warm_up.subprocess.Popen

    def noted(command, **pipes):
        started.append(popen(command, **pipes))
        if len(started) == 2:
            raise KeyboardInterrupt
        return started[-1]

    monkeypatch.setattr(warm_up.subprocess, "Popen", noted)
    with pytest.raises(KeyboardInterrupt):
        warm_up.warm_up(missing(["all"]))
    assert started[0].wait() != 0
    started[1].kill()
    started[1].communicate()


WORKER = [sys.executable, "-m", "trackctl.workflows.warm_up"]


def test_the_other_process_names_what_it_has_compiled(monkeypatch, tmp_path):
    monkeypatch.setenv("TRACKCTL_CACHE_DIR", str(tmp_path))
    with subprocess.Popen(WORKER, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as worker:
        worker.stdin.write("sensitivity\n")
        worker.stdin.flush()
        assert worker.stdout.readline() == "sensitivity\n"
    assert missing(["indices"]) == [name for name in PIECES if name in TASKS["indices"] and name != "sensitivity"]
    next(tmp_path.rglob("*.nbi")).unlink()
    assert "sensitivity" in missing(["indices"])


def test_the_other_process_says_that_it_keeps_nothing(monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("TRACKCTL_CACHE_DIR", str(tmp_path / "file" / "cache"))
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(WORKER, text=True, **pipes) as worker:
        worker.stdin.write("sensitivity\n")
        worker.stdin.flush()
        assert worker.stdout.readline() == "not kept\n"


def test_the_other_process_ends_with_the_one_that_asks(monkeypatch, tmp_path):
    """Though it is in the middle of a piece."""
    monkeypatch.setenv("TRACKCTL_CACHE_DIR", str(tmp_path))
    run = subprocess.run(WORKER, input="growth\n", capture_output=True, text=True)
    assert (run.returncode, run.stdout) == (0, "")
    assert "growth" in missing(["plan"])


def test_files_of_the_current_folder_are_not_run(monkeypatch, tmp_path):
    """`python -m` would put the folder before all others."""
    monkeypatch.setenv("TRACKCTL_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "numpy.py").write_text("open('run', 'w')", encoding="utf-8")
    with_cores(monkeypatch, 2)
    warm_up.warm_up(["sensitivity", "point"])
    assert not (tmp_path / "run").exists()
    assert missing(["indices"]) == ["balance", "branch", "swarm"]
