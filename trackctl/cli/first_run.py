"""The wait that only the first run has: said beforehand, with a bar."""

from __future__ import annotations

from trackctl.cli.progress import bar, say


def compile_first(quiet: bool, *tasks: str) -> None:
    """Compile what tasks of `trackctl.workflows.warm_up` need and no earlier run has, once the first kernel is called.

    Not at once: a command that ends with its input should not compile for it.
    """
    from trackctl.compiled import Compiled

    Compiled.before_first = lambda: compile_now(quiet, *tasks)


def compile_now(quiet: bool, *tasks: str) -> None:
    """Compile what tasks need and no earlier run has compiled."""
    from trackctl.workflows.warm_up import estimate, missing, warm_up

    names = missing(tasks)
    if names:
        say(f"compiling kernels, once; this takes about {estimate(names):.0f} s", quiet)
        with bar("compiling", "%", quiet) as progress:
            warm_up(names, progress)
