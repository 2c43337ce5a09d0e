"""A word before the wait that only the first run has."""

from __future__ import annotations

from trackctl.cli.progress import say


def announce_compilation(quiet: bool) -> None:
    """Say on standard error that kernels are to be compiled, if they are; importing a solver begins with it."""
    from trackctl.compiled import kernels_are_compiled

    if not kernels_are_compiled():
        say("compiling kernels, once; this takes up to a minute", quiet)
