import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numba import carray, types

from trackctl import compiled
from trackctl.compiled import call_by_address, compile_for, inlined, kernel, procedure

DOUBLES = types.CPointer(types.float64)


@kernel
def doubled(value: float) -> float:
    return 2.0 * value


@inlined
def raised(value: float) -> float:
    return value + 1.0


@kernel
def both(value: float) -> float:
    return raised(doubled(value))


def test_what_kernels_call_can_be_called_from_python_too():
    assert both(3.0) == 7.0
    assert doubled(3.0) == 6.0
    assert raised(3.0) == 4.0
    assert doubled(value=both(3.0)) == 14.0


def test_a_kernel_keeps_its_name_and_text():
    assert both.__name__ == "both"
    assert both.__module__ == __name__


DOUBLE = types.int64(types.float64, DOUBLES)
call_double = call_by_address(DOUBLE)


@procedure(DOUBLE)
def double_there(value, result):
    carray(result, 1)[0] = doubled(value)
    return 7


@kernel
def doubled_by_address(address: int, value: float) -> tuple[int, float]:
    result = np.empty(1)
    told = call_double(address, value, result.ctypes)
    return told, result[0]


def test_kernels_call_procedures_by_address():
    assert doubled_by_address(double_there.address, 3.0) == (7, 6.0)


def test_a_kernel_is_compiled_without_a_call():
    @kernel
    def halved(value: float) -> float:
        return 0.5 * value

    compile_for(halved, 1.0)
    made = compiled.Compiled.functions[halved.__wrapped__].make(compiled.FOR_PYTHON)
    assert made.signatures == [(types.float64,)]
    assert halved(3.0) == 1.5
    assert made.signatures == [(types.float64,)]


CODE = """
import warnings
warnings.simplefilter("always")
import sys
sys.path.insert(0, {folder!r})
import test_compiled as t
print(t.both(4.0), t.doubled_by_address(t.double_there.address, 4.0))
"""


def fresh(cache, **settings):
    """What a new process with a cache folder of its own prints, and says."""
    run = subprocess.run(
        [sys.executable, "-c", CODE.format(folder=str(Path(__file__).parent))],
        capture_output=True,
        text=True,
        env={**os.environ, "TRACKCTL_CACHE_DIR": str(cache), **settings},
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout == "9.0 (7, 8.0)\n"
    return run.stderr


def kept(cache, kind="nbc"):
    return sorted(cache.rglob(f"*.{kind}"))


def test_what_is_kept_is_loaded_and_not_written_again(tmp_path):
    assert fresh(tmp_path) == ""
    files = {file: file.stat().st_mtime_ns for file in kept(tmp_path)}
    assert len(files) == 4  # `both` and `doubled_by_address` for Python, `doubled` for kernels, `double_there`
    assert fresh(tmp_path) == ""
    assert {file: file.stat().st_mtime_ns for file in kept(tmp_path)} == files


@pytest.mark.parametrize(("kind", "size"), [("nbi", 0), ("nbc", 0), ("nbc", 100), ("nbi", 20)])
def test_files_that_cannot_be_read_are_compiled_again(tmp_path, kind, size):
    fresh(tmp_path)
    before = kept(tmp_path)
    for file in kept(tmp_path, kind):
        file.write_bytes(file.read_bytes()[:size])
    assert fresh(tmp_path) == ""
    assert kept(tmp_path) == before
    assert fresh(tmp_path) == ""


def test_files_of_noise_are_compiled_again(tmp_path):
    fresh(tmp_path)
    for file in (*kept(tmp_path, "nbi"), *kept(tmp_path)):
        file.write_bytes(np.random.default_rng(0).bytes(500))
    assert fresh(tmp_path) == ""


def test_without_a_folder_to_write_to_it_works_after_one_warning(tmp_path):
    (tmp_path / "file").touch()
    before = {file: file.stat().st_mtime_ns for file in Path(compiled.__file__).parent.rglob("*.nb?")}
    told = fresh(tmp_path / "file" / "cache")
    assert told.count("TrackctlWarning") == 1
    assert "compiled code cannot be kept" in told
    assert {file: file.stat().st_mtime_ns for file in Path(compiled.__file__).parent.rglob("*.nb?")} == before


def test_without_a_home_folder_it_works_after_one_warning(tmp_path):
    (tmp_path / "file").touch()
    told = fresh("", HOME=str(tmp_path / "file" / "home"), XDG_CACHE_HOME="")
    assert told.count("compiled code cannot be kept") == 1


FULL = """
import errno
import numba.core.caching as caching

def full(self, name, data):
    raise OSError(errno.ENOSPC, "No space left on device")

caching.IndexDataCacheFile._save_data = full
"""


def test_a_full_folder_is_no_error_of_the_work(tmp_path):
    (tmp_path / "sitecustomize.py").write_text(FULL, encoding="utf-8")
    told = fresh(tmp_path / "cache", PYTHONPATH=str(tmp_path))
    assert told.count("TrackctlWarning") == 1
    assert "No space left on device" in told


def test_the_functions_of_others_are_kept_where_numba_keeps_them(tmp_path, monkeypatch):
    (tmp_path / "others.py").write_text(
        "import numba\n\n@numba.njit(cache=True)\ndef tripled(value):\n    return 3.0 * value\n", encoding="utf-8"
    )
    code = CODE + "import others\nothers.tripled(1.0)\n"
    run = subprocess.run(
        [sys.executable, "-c", code.format(folder=str(Path(__file__).parent))],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env={**os.environ, "TRACKCTL_CACHE_DIR": str(tmp_path / "cache"), "NUMBA_CACHE_DIR": ""},
    )
    assert run.returncode == 0, run.stderr
    assert list((tmp_path / "__pycache__").glob("others.tripled*.nbc"))


def test_other_errors_are_not_taken_for_faults_of_the_cache():
    @kernel
    def wrong(value: float) -> float:
        return value.no_such_thing

    with pytest.raises(Exception, match="no_such_thing"):
        wrong(1.0)


def test_a_setting_of_numba_that_is_wrong_loses_nothing(tmp_path):
    fresh(tmp_path)
    before = kept(tmp_path)
    told = fresh(tmp_path, NUMBA_CACHE_LOCATOR_CLASSES="no.such.Locator")
    assert told.count("TrackctlWarning") == 1
    assert "no.such.Locator" in told
    assert kept(tmp_path) == before


def test_without_compiling_there_is_one_message():
    code = "from trackctl.cli.app import main; main()"
    run = subprocess.run(
        [sys.executable, "-c", code, "sweep", "--slope-deg", "5", "--velocity-mps", "1", "--radius-m", "5"],
        capture_output=True,
        text=True,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
    )
    assert run.returncode == 2
    assert run.stderr.splitlines()[-1].startswith("Error: NUMBA_DISABLE_JIT: 1 is not allowed")
    assert "Traceback" not in run.stderr
