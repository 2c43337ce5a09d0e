"""Wall time of the command line: help, a default table and a plan, the first time with kernels to compile and warm.

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


def empty_hall(folder: Path) -> Path:
    """A map of 20 m by 20 m without obstacles on a slope."""
    (folder / "hall.pgm").write_bytes(b"P5 400 400 255\n" + 160_000 * b"\xfe")
    file = folder / "hall.yaml"
    file.write_text(
        "image: hall.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
        "start: [1.5, 1.5, 45]\ngoal: [18.5, 18.5, 45]\nslope_deg: 12\n",
        encoding="utf-8",
    )
    return file


def print_plans(folder: Path) -> None:
    """A first plan in a cache of its own, and those after it."""
    settings = {"TRACKCTL_CACHE_DIR": str(folder / "plans")}
    plan = ["plan", str(empty_hall(folder)), "--quiet", "--force", "-o", str(folder / "plan.csv")]
    print_times("plan, kernels to compile", [seconds(plan, settings)])
    print_times("plan, warm", [seconds(plan, settings) for _ in range(WARM_RUNS)])
    verified = {"TRACKCTL_CACHE_DIR": str(folder / "verified")}
    print_times("plan --verify, kernels to compile", [seconds([*plan, "--verify"], verified)])
    print_times("plan --verify, warm", [seconds([*plan, "--verify"], verified) for _ in range(WARM_RUNS)])


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
        print_plans(Path(folder))


if __name__ == "__main__":
    main()
