"""Compiling on two cores: another process compiles what a first `compute-lut` needs last, this one what it needs first.

Both keep what they have compiled in the same folder and look there before they compile.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from trackctl.compiled import kernels_are_compiled
from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.lut.axes import Axes

#: Profiles that come along; any would do.
VEHICLE, TERRAIN = "utv-61cm", "asphalt"


@contextmanager
def compiling_ahead() -> Iterator[Callable[[], object]]:
    """Let another process compile, while the block runs, what `main` uses; gives a function that waits for it.

    Should it fail, its kernels are compiled where they are used. There is none if an earlier run has compiled all, or
    if there is but one core.
    """
    if kernels_are_compiled() or (os.cpu_count() or 1) < 2:
        yield lambda: None
        return
    command = [sys.executable, "-m", __name__]
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as other:
        try:
            yield other.wait
        finally:
            other.kill()


def small_axes() -> Axes:
    """Grid of a few cells."""
    return Axes(np.array([0.1]), np.array([0.1, 0.2]), np.array([0.0, 0.5]), np.array([0.0, 0.1]), False)


def use_interpolation() -> None:
    """A look-up in a table of zeros."""
    from trackctl.lut.interpolation import interpolant_of, look_up

    axes = small_axes()
    table = interpolant_of(
        axes, np.zeros((*axes.shape, 3)), np.zeros(axes.shape, np.uint8), load_vehicle(VEHICLE), math.inf
    )
    look_up(table, axes.slope, axes.velocity[:1], axes.curvature[:1], axes.heading[:1])


def use_sensitivity() -> None:
    """PAWN indices of noise."""
    from trackctl.sensitivity.pawn import pawn_indices

    noise = np.random.default_rng(0).random((200, 2))
    pawn_indices(noise[:, :1], noise[:, 1:], ("input",), ("output",), slices=2, resamples=2)


def use_column() -> None:
    """A column of a table; the swarm first, which the other process compiles last."""
    from trackctl.lut.swarm_search import linked_search
    from trackctl.lut.sweep import Seeding, Sweep, solve
    from trackctl.mechanics.parameters import STANDARD_GRAVITY, track_model

    linked_search.link()
    model = track_model(load_vehicle(VEHICLE), load_terrain(TERRAIN), STANDARD_GRAVITY)
    solve(Sweep(model, small_axes(), Seeding.CONTINUATION, 0), 0)


def main() -> None:
    """Use what is needed last, so that it gets compiled."""
    use_interpolation()
    use_sensitivity()
    use_column()


if __name__ == "__main__":
    main()
