"""Speed, memory and errors of `trackctl identify`, on simulated logs and on real ones.

Run from the repository: ``python benchmarks/identify.py [--data FOLDER]``, the folder with logs of a Husky and
a Warthog (``husky_chained_fresh.csv``, ``husky_chained_20hz.csv``, ``warthog_chained_fresh.csv``).
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

REPOSITORY = Path(__file__).parent.parent
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "tests")]

from slip_simulation import (  # noqa: E402  # noqa: E402
    GAUGE,
    HEADER,
    abrupt_change,
    errors_against,
    learn,
    locked_track,
    many_turns,
    mean_errors,
    reductions,
)

IDENTIFY = [sys.executable, "-m", "trackctl", "identify"]
CARRIER = ["--vehicle", "carrier-13t6"]
HUSKY_LOGS, WARTHOG_LOG = ("husky_chained_fresh.csv", "husky_chained_20hz.csv"), "warthog_chained_fresh.csv"
WARTHOG_GAUGE = 1.08
ROWS = 1_000_000
RATE, POSE_EVERY = 1000, 20
STREAM_SECONDS = 20
MODELS = ("none", "constant", "paper", "parametric", "factors")


def write_log(path: Path, rows: int) -> None:
    """A log of encoders at 1 kHz and poses at 50 Hz."""
    with path.open("w") as stream:
        stream.write(f"{HEADER}\n")
        for t, left, right, x, y, yaw in many_turns(0, rows, 1.0 / RATE, POSE_EVERY).tolist():
            pose = ",," if np.isnan(x) else f"{x:.4f},{y:.4f},{yaw:.5f}"
            stream.write(f"{t:.3f},{left:.4f},{right:.4f},{pose}\n")


def environment() -> dict[str, str]:
    return os.environ | {"PYTHONPATH": str(REPOSITORY)}


def measured(words: list[str], **streams: Any) -> tuple[float, float, int]:
    """Wall time, processor time [s] and largest memory [kB] of a command."""
    started = time.perf_counter()
    process = subprocess.Popen(words, env=environment(), **streams)
    _, _, usage = os.wait4(process.pid, 0)
    return time.perf_counter() - started, usage.ru_utime + usage.ru_stime, usage.ru_maxrss


def print_speed(folder: Path) -> None:
    for rows in (ROWS // 10, ROWS):
        log = folder / f"{rows}.csv"
        # In a process of its own: a child's memory counts from its parent's.
        subprocess.run([sys.executable, __file__, "--write", str(log), str(rows)], check=True)
        for name, options in (("--json", ["--json"]), ("CSV", [])):
            with open(os.devnull, "w") as nowhere:
                wall, used, memory = measured([*IDENTIFY, str(log), *CARRIER, *options], stdout=nowhere)
            print(f"{rows:9d} rows, {name:7}{wall:7.2f} s, {used:.2f} s of processor, {memory / 1024:7.0f} MB")


def print_stream(folder: Path) -> None:
    """Processor time of a pipe at 1 kHz, beside that of an empty one."""
    lines = (folder / f"{ROWS // 10}.csv").read_text().splitlines()[: STREAM_SECONDS * RATE + 1]
    used = []
    for seconds in (1, STREAM_SECONDS):
        reader, writer = os.pipe()
        command = [sys.executable, "-c", PUMP, str(seconds)]
        pump = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=writer, text=True)
        os.close(writer)
        assert pump.stdin is not None
        pump.stdin.write("\n".join(lines))
        pump.stdin.close()
        with open(os.devnull, "w") as nowhere:
            used.append(measured([*IDENTIFY, "-", *CARRIER], stdin=reader, stdout=nowhere)[1])
        pump.wait()
    print(f"stream at 1 kHz and 50 Hz: {100 * (used[1] - used[0]) / (STREAM_SECONDS - 1):.1f} % of a core")


#: Sends its input on at 1 kHz, 20 lines at a time.
PUMP = """
import sys, time
lines = sys.stdin.read().splitlines(keepends=True)[: 1000 * int(sys.argv[1]) + 1]
start = time.monotonic()
for k in range(0, len(lines), 20):
    time.sleep(max(0.0, start + k / 1000 - time.monotonic()))
    sys.stdout.writelines(lines[k : k + 20])
    sys.stdout.flush()
"""


def print_cases() -> None:
    """The paper's cases: errors over 2 s of the learned parameters, from true poses where the truth is known."""
    truth = abrupt_change(0, noise=0.0)
    for name, every, kind in (("4.1", 1, "window"), ("4.2 window", 10, "window"), ("4.2 velocity", 10, "velocity")):
        errors = [
            errors_against(truth, learn(abrupt_change(seed, every), kind=kind)[0], truth, since=4.0)
            for seed in range(10)
        ]
        print(f"case {name:14}{np.mean(errors, axis=0)[0].round(4)} m, rad; without slip {errors[0][1].round(3)}")
    rows = locked_track(0)
    blind = rows.copy()
    blind[:, 3:5] = np.nan
    print(f"locked track        {reductions(mean_errors(learn(rows)[0])).round(1)} % less")
    print(f"heading only        {reductions(errors_against(rows, learn(blind)[0], rows)).round(1)} % less")


def print_husky(log: Path) -> None:
    for kind in ("window", "velocity"):
        for model in MODELS:
            words = [*IDENTIFY, str(log), "--vehicle", "husky", "--model", model, "--filter", kind, "--json"]
            done = subprocess.run(words, env=environment(), capture_output=True, check=True)
            summary = json.loads(done.stdout)
            position, heading = summary["position_error_m"], summary["heading_error_rad"]
            print(
                f"{log.stem:22}{kind:10}{model:12}{position['model']:.3f} m {heading['model']:.3f} rad, "
                f"{position['reduction_percent']:.1f} % and {heading['reduction_percent']:.1f} % less"
            )


def print_warthog(log: Path) -> None:
    """Of a vehicle without a profile."""
    rows = np.loadtxt(log, delimiter=",", skiprows=1)
    for model in MODELS:
        percent = reductions(mean_errors(learn(rows, WARTHOG_GAUGE, model)[0]))
        print(f"{log.stem:22}{'window':10}{model:12}{percent.round(1)} % less")


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--data", type=Path, help="folder with the real logs")
    parser.add_argument("--write", nargs=2, metavar=("FILE", "ROWS"), help="only write a log")
    options = parser.parse_args()
    if options.write:
        write_log(Path(options.write[0]), int(options.write[1]))
        return
    data = options.data
    print(f"gauge of the simulated vehicle {GAUGE} m")
    print_cases()
    with tempfile.TemporaryDirectory() as folder:
        print_speed(Path(folder))
        print_stream(Path(folder))
    if data:
        for name in HUSKY_LOGS:
            print_husky(data / name)
        print_warthog(data / WARTHOG_LOG)


if __name__ == "__main__":
    main()
