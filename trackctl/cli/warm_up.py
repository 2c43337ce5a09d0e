"""The command `warm-up`."""

from __future__ import annotations

import json
import time

import typer

from trackctl.cli import options
from trackctl.cli.progress import bar, say
from trackctl.errors import OutputError


def warm_up(quiet: options.Quiet = False, as_json: options.Json = False) -> None:
    """Compile all kernels now, so that no later run has to: for images, clusters, and first impressions.

    They are kept in $TRACKCTL_CACHE_DIR, or else in the user's cache folder, for this version of trackctl and numba,
    this Python and this kind of processor.

    Example:
      trackctl warm-up
    """
    from trackctl.compiled import kernel_folder, reason_not_kept
    from trackctl.workflows.warm_up import TASKS, estimate, missing
    from trackctl.workflows.warm_up import warm_up as compile_all

    reason = reason_not_kept()
    if reason:
        raise OutputError("the folder of compiled kernels", f"{reason}; $TRACKCTL_CACHE_DIR may name another")
    started = time.perf_counter()
    names = missing(TASKS)
    if names:
        say(f"compiling kernels; this takes about {estimate(names):.0f} s", quiet)
        with bar("compiling", "%", quiet) as progress:
            compile_all(names, progress)
    if missing(TASKS):
        raise OutputError(kernel_folder(), "does not keep all that was compiled; is the disk full?")
    seconds, folder = time.perf_counter() - started, kernel_folder()
    if as_json:
        typer.echo(json.dumps({"compiled": len(names), "seconds": round(seconds, 3), "folder": str(folder)}))
    else:
        say(f"{folder}: {'compiled' if names else 'nothing to compile'} in {seconds:.1f} s", quiet)
