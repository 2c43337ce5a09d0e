"""One decorator for every compiled kernel, and where compiled code is kept.

The machine code is cached in the user's cache folder under a digest of the package's kernel sources: numba looks only
at the file of the outermost function, so without the digest an edit to an inner one would go unnoticed.
"""

from __future__ import annotations

import functools
import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numba

Kernel = TypeVar("Kernel", bound=Callable[..., object])

# Everything but nnan and ninf: status checks rely on NaN.
FASTMATH = {"reassoc", "contract", "arcp", "nsz", "afn"}
KERNEL_ROOMS = ("mechanics", "solvers", "lut", "sensitivity")


def cache_root() -> Path:
    """Folder for compiled code: ``$TRACKCTL_CACHE_DIR``, or else the user's cache folder."""
    chosen = os.environ.get("TRACKCTL_CACHE_DIR")
    if chosen:
        return Path(chosen)
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "trackctl"


@functools.cache
def kernel_folder() -> Path:
    """Folder of this version's compiled code, named after its sources, numba and Python."""
    package = Path(__file__).parent
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(path for room in KERNEL_ROOMS for path in (package / room).rglob("*.py")):
        digest.update(source.read_bytes())
    digest.update(Path(__file__).read_bytes())
    return cache_root() / f"kernels-{digest.hexdigest()[:16]}"


def kernels_are_compiled() -> bool:
    """Whether an earlier run has left compiled code for this version."""
    return kernel_folder().is_dir() and any(kernel_folder().rglob("*.nbc"))


def kernel(function: Kernel) -> Kernel:
    """Compile a function with the package's settings: cached, without the GIL, vectorisable loops."""
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(kernel_folder())
    try:
        return numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=FASTMATH)(function)  # type: ignore[no-any-return]
    finally:
        numba.config.CACHE_DIR = before
