"""Wall time of the command line: help, a default table warm, and the first run with kernels to compile.

Run from the repository: ``python benchmarks/startup.py``.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from tables import print_machine

HELP_RUNS = 20
WARM_RUNS = 5
REPOSITORY = Path(__file__).parents[1]


def seconds(arguments: list[str], settings: Mapping[str, str]) -> float:
    """Wall time of one run of `trackctl`."""
    started = perf_counter()
    subprocess.run(
        [sys.executable, "-m", "trackctl", *arguments],
        cwd=REPOSITORY,
        env={**os.environ, **settings},
        capture_output=True,
        check=True,
    )
    return perf_counter() - started


def print_times(name: str, times: list[float]) -> None:
    print(f"{name:34}{len(times):>6}{min(times):>9.3f}{statistics.median(times):>9.3f}")


def main() -> None:
    print_machine()
    print(f"{'':34}{'runs':>6}{'best s':>9}{'median':>9}")
    with TemporaryDirectory() as folder:
        settings = {"TRACKCTL_CACHE_DIR": str(Path(folder) / "cache")}
        default = ["compute-lut", "--quiet", "--force", "-o", str(Path(folder) / "lut.h5")]
        seconds(["--help"], settings)
        print_times("trackctl --help", [seconds(["--help"], settings) for _ in range(HELP_RUNS)])
        print_times("compute-lut, kernels to compile", [seconds(default, settings)])
        print_times("compute-lut, warm", [seconds(default, settings) for _ in range(WARM_RUNS)])


if __name__ == "__main__":
    main()
