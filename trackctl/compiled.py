"""One decorator for every compiled kernel, and where compiled code is kept.

The machine code is cached in the user's cache folder under a digest of the package's kernel sources: numba looks only
at the file of the outermost function, so without the digest an edit to an inner one would go unnoticed.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
from collections.abc import Callable, Iterator
from inspect import ismodule
from pathlib import Path
from typing import Any, TypeVar, cast

import llvmlite.binding
import numba
from numba.core.compiler_lock import global_compiler_lock

Kernel = TypeVar("Kernel", bound=Callable[..., object])

# Everything but nnan and ninf: status checks rely on NaN.
FASTMATH = {"reassoc", "contract", "arcp", "nsz", "afn"}
#: Part of the cache for what only kernels call: numba tells the two shapes of a function apart by nothing else.
FOR_KERNELS = "for_kernels"
KERNEL_ROOMS = ("mechanics", "solvers", "lut", "planning", "sensitivity", "identification", "simulation")


def cache_root() -> Path:
    """Folder for compiled code: ``$TRACKCTL_CACHE_DIR``, or else the user's cache folder."""
    chosen = os.environ.get("TRACKCTL_CACHE_DIR")
    if chosen:
        return Path(chosen)
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "trackctl"


@functools.cache
def kernel_folder() -> Path:
    """Folder of this version's compiled code, named after its sources and numba.

    numba itself tells Python versions and processors apart.
    """
    package = Path(__file__).parent
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(path for room in KERNEL_ROOMS for path in (package / room).rglob("*.py")):
        digest.update(source.read_bytes())
    digest.update(Path(__file__).read_bytes())
    return cache_root() / f"kernels-{digest.hexdigest()[:16]}"


def kernels_are_compiled(kernel: str = "") -> bool:
    """Whether an earlier run has left compiled code for this version: any, or that of a kernel, as ``module.name``.

    What only kernels call does not count.
    """
    return any(FOR_KERNELS not in file.parts for file in kernel_folder().rglob(f"{kernel}*.nbc"))


def kernels_can_be_kept() -> bool:
    """Whether what is compiled can be written to `kernel_folder`, where other processes find it."""
    try:
        kernel_folder().mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(kernel_folder(), os.W_OK)


@contextlib.contextmanager
def cached_in_kernel_folder(part: str = "") -> Iterator[None]:
    """Let numba cache what is compiled in the block in a part of `kernel_folder`.

    The setting is one for all threads, so that only one may be compiling.
    """
    config: Any = numba.config
    with global_compiler_lock:
        before = config.CACHE_DIR
        config.CACHE_DIR = str(kernel_folder() / part)
        try:
            yield
        finally:
            config.CACHE_DIR = before


class Compiled:
    """A compiled function in two shapes: for other kernels, and for Python, each compiled where it is first called.

    What turns Python's arguments into numbers would otherwise be compiled with every kernel, in vain for most.
    """

    def __init__(self, function: Callable[..., object], **options: object) -> None:
        functools.update_wrapper(self, function)
        self._function = function
        # Not all of it is in numba's type hints.
        self._settings: Any = {"cache": True, "nogil": True, "error_model": "numpy", "fastmath": FASTMATH}
        self._settings |= {"no_cfunc_wrapper": True} | options
        self._made_for_python: Any = None
        self._made_for_kernels: Any = None

    def __call__(self, *arguments: object, **named: object) -> object:
        """Call it from Python."""
        return self._for_python(*arguments, **named)

    # Both are made when asked for: few kernels are called from Python, and none from kernels that come from the cache.
    @property
    def _for_python(self) -> Any:
        if self._made_for_python is None:
            link_callees(self._function)
            with cached_in_kernel_folder():
                self._made_for_python = numba.njit(**self._settings)(self._function)
        return self._made_for_python

    @property
    def _for_kernels(self) -> Any:
        if self._made_for_kernels is None:
            bare: Any = self._settings | {"no_cpython_wrapper": True}
            with cached_in_kernel_folder(FOR_KERNELS):
                self._made_for_kernels = numba.njit(**bare)(self._function)
        return self._made_for_kernels

    @property
    def _numba_type_(self) -> Any:
        """What numba takes for the object where a kernel calls it."""
        return self._for_kernels._numba_type_


def kernel(function: Kernel) -> Kernel:
    """Compile a function with the package's settings: cached, without the GIL, vectorisable loops."""
    return cast("Kernel", Compiled(function))


def inlined(function: Kernel) -> Kernel:
    """Compile a function as `kernel` does, into its callers, which leave out what they do not use."""
    return cast("Kernel", Compiled(function, forceinline=True))


def borrowing_kernel(function: Kernel) -> Kernel:
    """Compile a function that allocates nothing, nor calls any that does: as `kernel`, without reference counts.

    Where small kernels hand each other tuples of arrays, counting references takes most of the time.
    """
    return cast("Kernel", Compiled(function, _nrt=False))


class Linked:
    """A function compiled once for all its callers, which call it by address."""

    def __init__(self, function: Callable[..., None], signature: Any) -> None:
        self._function, self._signature = function, signature
        self._compiled: Any = None

    def link(self) -> None:
        """Compile or load it, and make its address known; what calls it must not be loaded before."""
        with cached_in_kernel_folder():
            if self._compiled is None:
                link_callees(self._function)
                make = numba.cfunc(self._signature, cache=True, error_model="numpy", fastmath=FASTMATH)
                self._compiled = make(self._function)
                llvmlite.binding.add_symbol(self._name, self._compiled.address)

    @property
    def _name(self) -> str:
        return f"{self._function.__module__}.{self._function.__qualname__}"

    @property
    def _numba_type_(self) -> Any:
        """What numba takes for the object where a kernel calls it."""
        self.link()
        return numba.types.ExternalFunction(self._name, self._signature)


def link_callees(function: Callable[..., object]) -> None:
    """Link all `Linked` functions that a function calls, itself or through other kernels."""
    seen: set[Callable[..., object]] = set()
    left = [function]
    while left:
        caller = left.pop()
        names = caller.__code__.co_names
        known = [caller.__globals__[name] for name in names if name in caller.__globals__]
        inside = [vars(module)[name] for module in known if ismodule(module) for name in names if name in vars(module)]
        for callee in (*known, *inside):
            if isinstance(callee, Linked):
                callee.link()
            elif isinstance(callee, Compiled) and callee._function not in seen:
                seen.add(callee._function)
                left.append(callee._function)


def linked(signature: Any) -> Callable[[Callable[..., None]], Any]:
    """Compile a function once, for kernels that call it by address.

    numba compiles a kernel anew into each of its callers; a large one that many kernels call would take most of the
    first run's time. Arguments are numbers and pointers.
    """

    def link(function: Callable[..., None]) -> Any:
        return Linked(function, signature)

    return link
