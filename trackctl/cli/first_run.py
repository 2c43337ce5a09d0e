"""A word before the wait that only the first run has."""

from __future__ import annotations

from trackctl.cli.progress import say


def announce_compilation(quiet: bool, kernel: str = "") -> None:
    """Say on standard error that kernels are to be compiled, if they are, or if a certain one is.

    Importing a solver begins with it.
    """
    from trackctl.compiled import kernels_are_compiled

    if not kernels_are_compiled(kernel):
        say("compiling kernels, once; this takes up to a minute", quiet)
