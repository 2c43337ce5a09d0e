"""PAWN indices and their time against SALib's, side by side in one run.

Run from the repository: ``python benchmarks/sensitivity.py`` (needs the ``bench`` extra).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import perf_counter

import numpy as np
from numpy.typing import NDArray
from SALib.analyze import pawn as salib_pawn
from SALib.test_functions import Ishigami, Sobol_G

from trackctl.sensitivity.pawn import Statistic, pawn_indices
from trackctl.sensitivity.resampling import bootstrap_distances, sample_distances
from trackctl.sensitivity.slices import SortedOutput, slice_labels

Array = NDArray[np.float64]

SLICES = 10
SEEDS = 20
VALUE_ROWS = 2000
TIMED_ROWS = (1000, 4096, 16384)
RESAMPLES = 1000
SALIB_RESAMPLES = 5
SALIB_NAMES = {Statistic.MEDIAN: "median", Statistic.MAX: "maximum"}

FUNCTIONS: dict[str, tuple[Callable[[Array], Array], Array, Array]] = {
    "Ishigami": (Ishigami.evaluate, np.full(3, -np.pi), np.full(3, np.pi)),
    "Sobol G": (Sobol_G.evaluate, np.zeros(8), np.ones(8)),
}


def sample(name: str, rows: int, seed: int) -> tuple[Array, Array]:
    """Random inputs of a test function and its output."""
    function, lower, upper = FUNCTIONS[name]
    inputs = np.random.default_rng(seed).uniform(lower, upper, (rows, lower.size))
    return inputs, np.asarray(function(inputs), dtype=np.float64)


def our_index(inputs: Array, output: Array, statistic: Statistic = Statistic.MEDIAN) -> Array:
    """Index of each input, nothing resampled."""
    labels = slice_labels(inputs, SLICES)
    return statistic.over_slices(sample_distances(labels, (SortedOutput.of(output),), SLICES)[0])


def salib_index(inputs: Array, output: Array, statistic: Statistic = Statistic.MEDIAN) -> Array:
    """SALib's index of each input; it leaves the largest row of each input out."""
    names = [f"x{i + 1}" for i in range(inputs.shape[1])]
    problem = {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}
    return np.asarray(salib_pawn.analyze(problem, inputs, output, S=SLICES)[SALIB_NAMES[statistic]])


def our_bootstrap(inputs: Array, output: Array) -> Array:
    """Index of each input in `RESAMPLES` resamples."""
    labels, outputs = slice_labels(inputs, SLICES), (SortedOutput.of(output),)
    distances = bootstrap_distances(labels, outputs, SLICES, RESAMPLES, np.random.default_rng(0))
    return Statistic.MEDIAN.over_slices(distances[:, 0])


def salib_bootstrap(inputs: Array, output: Array) -> Array:
    """SALib's index of each input in `SALIB_RESAMPLES` resamples; SALib has no bootstrap of its own."""
    generator = np.random.default_rng(0)
    draws = [generator.integers(output.size, size=output.size) for _ in range(SALIB_RESAMPLES)]
    return np.stack([salib_index(inputs[rows], output[rows]) for rows in draws])


def our_analysis(inputs: Array, output: Array) -> None:
    """Everything: both statistics, intervals and dummy thresholds."""
    names = [f"x{i + 1}" for i in range(inputs.shape[1])]
    pawn_indices(inputs, output[:, None], names, ["y"], slices=SLICES, resamples=RESAMPLES)


def seconds(call: Callable[[], object], repeats: int = 5) -> float:
    """Shortest of some runs: the least disturbed by whatever else the machine does. [s]"""
    times = []
    for _ in range(repeats):
        start = perf_counter()
        call()
        times.append(perf_counter() - start)
    return min(times)


def compare_values() -> None:
    """Mean and scatter over the seeds of both, and how they differ on one and the same sample."""
    print(f"PAWN index, {VALUE_ROWS} rows, {SLICES} slices, {SEEDS} seeds: mean +- scatter over the seeds")
    print("off: difference of the means in units of the scatter; largest: difference on one and the same sample")
    print(f"{'function':9} {'input':5} {'stat.':6} {'trackctl':>18} {'SALib':>18} {'off':>6} {'largest':>8}")
    for name in FUNCTIONS:
        samples = [sample(name, VALUE_ROWS, seed) for seed in range(SEEDS)]
        for statistic in Statistic:
            ours = np.stack([our_index(x, y, statistic) for x, y in samples])
            theirs = np.stack([salib_index(x, y, statistic) for x, y in samples])
            for column, (one, other) in enumerate(zip(ours.T, theirs.T, strict=True), start=1):
                scatter = other.std(ddof=1)
                off, largest = abs(one.mean() - other.mean()) / scatter, np.abs(one - other).max()
                print(
                    f"{name:9} x{column:<4} {statistic:6} {one.mean():8.4f} +- {one.std(ddof=1):.4f}"
                    f" {other.mean():8.4f} +- {scatter:.4f} {off:6.3f} {largest:8.1e}"
                )


def compare_times() -> None:
    """Times of the index, of a bootstrap, and of the whole analysis, whose dummies SALib goes without."""
    print(f"\nTime [ms], {SLICES} slices; SALib's {RESAMPLES} resamples: {SALIB_RESAMPLES} timed and scaled")
    print(f"{'function':9} {'rows':>6} {'what':16} {'trackctl':>10} {'SALib':>10} {'ratio':>7}")
    for name in FUNCTIONS:
        for rows in TIMED_ROWS:
            x, y = sample(name, rows, 0)
            index = seconds(partial(salib_index, x, y))
            bootstrap = seconds(partial(salib_bootstrap, x, y), 2) * RESAMPLES / SALIB_RESAMPLES
            for what, call, theirs in (
                ("index", our_index, index),
                (f"{RESAMPLES} resamples", our_bootstrap, bootstrap),
                ("whole analysis", our_analysis, bootstrap),
            ):
                ours = seconds(partial(call, x, y), 3)
                times = f"{1e3 * ours:10.2f} {1e3 * theirs:10.1f} {theirs / ours:7.0f}"
                print(f"{name:9} {rows:6} {what:16} {times}")


if __name__ == "__main__":
    compare_values()
    compare_times()
