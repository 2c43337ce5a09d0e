"""Wall and CPU time of whole commands: the first time, with kernels to compile, and warm; beside another version.

Run from the repository: ``python benchmarks/startup.py [--against FOLDER]``, where FOLDER holds another checkout. The
two versions take turns. The last rows are ratios that do not depend on the machine.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import NamedTuple

from tables import print_machine

WARM_RUNS = 5
REPOSITORY = Path(__file__).parents[1]
IMPORTS = "import numba, h5py"


class Cost(NamedTuple):
    """Wall and CPU time. [s]"""

    wall: float
    cpu: float


def cost_of(command: list[str], folder: Path, **settings: str) -> Cost:
    """What a command takes, other processes that it starts included."""
    before, started = os.times(), perf_counter()
    run = subprocess.run(
        [sys.executable, *command], cwd=folder, env={**os.environ, **settings}, capture_output=True, text=True
    )
    wall, after = perf_counter() - started, os.times()
    if run.returncode not in (0, 1):
        raise SystemExit(f"{command}: {run.stderr}")
    used = after.children_user + after.children_system - before.children_user - before.children_system
    return Cost(wall, used)


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


def commands() -> Iterator[tuple[str, list[str]]]:
    """Names and words of what is timed; each writes what a later one reads."""
    yield "compute-lut", ["compute-lut", "--quiet", "--force", "-o", "lut.h5"]
    point = ["lookup", "lut.h5", "--velocity-mps", "1", "--radius-m", "5", "--heading-deg", "90"]
    yield "lookup, one point", point
    yield "lookup --method exact", [*point, "--method", "exact"]
    yield "plan", ["plan", "hall.yaml", "--quiet", "--force", "--iterations", "200", "-o", "plan.csv"]
    yield "plan --verify", ["plan", "hall.yaml", "--quiet", "--force", "--iterations", "200", "--verify", "-o", "p.csv"]
    drive = ["simulate", "--track-speeds-mps", "0.4,0.6", "--duration-s", "20", "--slope-deg", "0"]
    yield "simulate", [*drive, "--force", "-o", "log.csv"]
    yield "identify", ["identify", "log.csv", "--force", "-o", "updates.csv"]


def measure(versions: dict[str, Path], folder: Path) -> dict[tuple[str, str, str], list[Cost]]:
    """Costs by version, command and whether its kernels are compiled; first runs have a cache of their own."""
    costs: dict[tuple[str, str, str], list[Cost]] = {}

    def note(version: str, name: str, kind: str, words: list[str], cache: str) -> None:
        settings = {"PYTHONPATH": str(versions[version]), "TRACKCTL_CACHE_DIR": str(folder / version / cache)}
        cost = cost_of(["-m", "trackctl", *words], folder / version, **settings)
        costs.setdefault((version, name, kind), []).append(cost)

    for version in versions:
        (folder / version).mkdir()
        empty_hall(folder / version)
    for name, words in commands():
        for version in versions:
            note(version, name, "first", words, name.replace(" ", "-"))
        for _ in range(WARM_RUNS):
            for version in versions:
                note(version, name, "warm", words, name.replace(" ", "-"))
    for _ in range(WARM_RUNS):
        for version in versions:
            note(version, "--help", "warm", ["--help"], "help")
    return costs


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--against", type=Path, help="another checkout, to be measured in turns with this one")
    against = parser.parse_args().against
    versions = {"this": REPOSITORY} | ({} if against is None else {"other": against.resolve()})
    print_machine()
    with TemporaryDirectory() as folder:
        costs = measure(versions, Path(folder))
        imports = [cost_of(["-c", IMPORTS], Path(folder)) for _ in range(WARM_RUNS)]
    print(f"{'command':26}{'kernels':>8}{'version':>9}{'runs':>6}{'wall s':>9}{'CPU s':>9}")
    for (version, name, kind), found in sorted(costs.items(), key=lambda item: (item[0][2], item[0][1], item[0][0])):
        wall, cpu = (statistics.median(values) for values in zip(*found, strict=True))
        print(f"{name:26}{kind:>8}{version:>9}{len(found):>6}{wall:>9.2f}{cpu:>9.2f}")
    base = statistics.median(cost.wall for cost in imports)
    for version in versions:
        one = statistics.median(cost.wall for cost in costs[version, "lookup, one point", "warm"])
        print(f"{version}: one warm lookup takes {one / base:.2f} times as long as {IMPORTS!r}")


if __name__ == "__main__":
    main()
