"""Compiled functions, and the folder that keeps their machine code.

Compiling takes seconds, so the machine code is kept in the user's cache folder, under a digest of the package's
sources: numba looks only at the file of the outermost function, so without the digest an edit to an inner one would go
unnoticed. Keeping it is a convenience: where that fails, each run compiles anew, after one warning.

numba is imported with the first kernel that runs compiled, since that takes longer than many a command.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import shutil
import tempfile
import threading
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from importlib.metadata import version
from pathlib import Path
from typing import Any, ClassVar, TypeVar, cast

import numpy as np

from trackctl.errors import TrackctlWarning, UsageError

Function = TypeVar("Function", bound=Callable[..., object])

# Everything but nnan and ninf: status checks rely on NaN.
OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"reassoc", "contract", "arcp", "nsz", "afn"}}
KERNEL_ROOMS = ("mechanics", "solvers", "lut", "planning", "sensitivity", "identification", "simulation")
#: Parts of the folder: numba's cache does not tell the makes of a function apart.
FOR_PYTHON, FOR_KERNELS = "for_python", "for_kernels"
#: Where numba reads and writes compiled code.
NUMBA_CACHE, NUMBA_LOADING = "numba.core.caching", "load_overload"
#: numba's own locators, which go on to serve all other packages.
NUMBA_LOCATORS = ",".join(f"{kind}CacheLocator" for kind in ("UserProvided", "InTree", "UserWide", "IPython", "Zip"))


def cache_root() -> Path:
    """Folder for compiled code and tables: ``$TRACKCTL_CACHE_DIR``, or else the user's cache folder.

    Raises
    ------
    OSError
        If the user has no home folder, and no variable names another.
    """
    chosen = os.environ.get("TRACKCTL_CACHE_DIR")
    if chosen:
        return Path(chosen)
    base = os.environ.get("XDG_CACHE_HOME")
    try:
        return (Path(base) if base else Path.home() / ".cache") / "trackctl"
    except RuntimeError as error:
        raise FileNotFoundError(2, "there is no home folder; $TRACKCTL_CACHE_DIR may name another") from error


@functools.cache
def kernel_digest() -> str:
    """Digest of the sources and of numba's version; numba itself tells Pythons and processors apart."""
    package = Path(__file__).parent
    digest = hashlib.sha256(version("numba").encode())
    for source in sorted(path for room in KERNEL_ROOMS for path in (package / room).rglob("*.py")):
        digest.update(source.read_bytes())
    digest.update(Path(__file__).read_bytes())
    return digest.hexdigest()[:16]


def kernel_folder() -> Path:
    """Folder of this version's compiled code."""
    return cache_root() / f"kernels-{kernel_digest()}"


def reason_not_kept() -> str:
    """Why nothing can be written to `kernel_folder`, where other processes find it; empty if it can."""
    try:
        kernel_folder().mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=kernel_folder()).close()
    except OSError as error:
        return error.strerror or str(error)
    return ""


class KernelLocator:
    """Tells numba where the code of the package's functions is kept, and leaves all others to numba's locators.

    numba's setting NUMBA_CACHE_LOCATOR_CLASSES names it while one of the package's functions is made.
    """

    #: Part of the folder that the function being made goes to.
    part: ClassVar[str] = ""

    def __init__(self, function: Callable[..., object]) -> None:
        self._line = function.__code__.co_firstlineno
        self._folder = kernel_folder() / self.part / function.__module__

    @classmethod
    def from_function(cls, function: Callable[..., object], _file: str) -> KernelLocator | None:
        """The locator of one of the package's functions."""
        return cls(function) if function in Compiled.functions else None

    def get_cache_path(self) -> str:
        """Folder of the function's code; one for each module."""
        return str(self._folder)

    def ensure_cache_path(self) -> None:
        """Make the folder, before something is written to it."""
        self._folder.mkdir(parents=True, exist_ok=True)

    def get_source_stamp(self) -> str:
        """What changes with the source."""
        return kernel_digest()

    def get_disambiguator(self) -> str:
        """What tells functions of one name in a module apart."""
        return str(self._line)


@contextlib.contextmanager
def own_locator(part: str) -> Iterator[None]:
    """Let numba ask `KernelLocator` first; the functions of others are none the wiser, in whichever thread."""
    config: Any = numba().config
    before = config.CACHE_LOCATOR_CLASSES
    config.CACHE_LOCATOR_CLASSES = f"{__name__}.{KernelLocator.__name__},{before or NUMBA_LOCATORS}"
    KernelLocator.part = part
    try:
        yield
    finally:
        config.CACHE_LOCATOR_CLASSES = before


class Compiled:
    """A function that numba compiles where it is first needed, and whose code is kept where that is possible.

    What turns Python's arguments into numbers takes a third of the compilation, and only a few are called from Python;
    so there are two makes, for Python and for kernels.
    """

    #: All of them, by their Python functions.
    functions: ClassVar[dict[Callable[..., object], Compiled]] = {}
    #: Called once, before the first of them is compiled or loaded: input has been read by then, and found good.
    before_first: ClassVar[Callable[[], None] | None] = None
    _kept: ClassVar[bool] = True
    _faults: ClassVar[int] = 0
    _retired: ClassVar[list[Any]] = []
    _lock: ClassVar[threading.RLock] = threading.RLock()

    def __init__(self, function: Callable[..., object]) -> None:
        functools.update_wrapper(self, function)
        self._function = function
        self._made: dict[str, Any] = {}
        Compiled.functions[function] = self

    def compiler(self, **options: object) -> Callable[..., Any]:
        """The decorator that makes it."""
        made: Callable[..., Any] = numba().njit(nogil=True, no_cfunc_wrapper=True, **OPTIONS, **options)
        return made

    def __call__(self, *arguments: object, **named: object) -> object:
        """Call it from Python."""
        if _interpreted.get():
            return self._function(*arguments, **named)
        return Compiled.despite_faults(lambda: self.make(FOR_PYTHON)(*arguments, **named))

    def make(self, part: str, **options: object) -> Any:
        """What numba makes of the function; it may meet a fault of the cache."""
        made = self._made.get(part)
        if made is None:
            with self._lock:
                announce, Compiled.before_first = Compiled.before_first, None
                if announce is not None:
                    announce()
            with self._lock, own_locator(part):
                made = self._made[part] = self.compiler(cache=Compiled._kept, **options)(self._function)
        return made

    @classmethod
    def despite_faults(cls, act: Callable[[], object]) -> object:
        """Do something that may compile; once more where code could not be read or written."""
        while True:
            try:
                return act()
            except Exception as error:
                if not functions_passed(error):
                    raise
                fault = error
            cls._overcome(fault)

    @classmethod
    def _overcome(cls, fault: Exception) -> None:
        """Forget what cannot be read; the second time, or after any other fault, keep nothing from now on."""
        with cls._lock:
            cls._faults += 1
            is_unreadable = NUMBA_LOADING in functions_passed(fault) and not isinstance(fault, OSError)
            if is_unreadable and cls._faults == 1:
                shutil.rmtree(kernel_folder(), ignore_errors=True)
            else:
                cls._keep_none(fault)
            for function in cls.functions.values():
                cls._retired += function._made.values()  # somebody may hold an address
                function._made.clear()

    @classmethod
    def kept_files(cls) -> list[Path]:
        """Index files of what this process has compiled or loaded, in `kernel_folder`."""
        folder = kernel_folder()
        made = [(part, each) for each in cls.functions.values() for part in each._made]
        patterns = (f"{part}/{each._function.__module__}/*.{each._function.__name__}-*.nbi" for part, each in made)
        return sorted({file.relative_to(folder) for pattern in patterns for file in folder.glob(pattern)})

    @classmethod
    def are_kept(cls) -> bool:
        """Whether what has been compiled so far could be kept."""
        return cls._kept

    @classmethod
    def _keep_none(cls, fault: Exception) -> None:
        if cls._kept:
            cls._kept = False
            reason = getattr(fault, "strerror", None) or str(fault) or type(fault).__name__
            text = f"compiled code cannot be kept ({reason}), so that each run compiles anew"
            warnings.warn(text, TrackctlWarning, stacklevel=2)


class Procedure(Compiled):
    """A function compiled once, for kernels that call it by its address."""

    def __init__(self, function: Callable[..., object], signature: Any) -> None:
        super().__init__(function)
        self._signature = signature

    def compiler(self, **options: object) -> Callable[..., Any]:
        """The decorator that makes it."""
        made: Callable[..., Any] = numba().cfunc(self._signature, **OPTIONS, **options)
        return made

    def load(self) -> None:
        """Compile it, or load it."""
        Compiled.despite_faults(lambda: self.make(FOR_PYTHON))

    @property
    def address(self) -> int:
        """Where its machine code is, as long as the process lives."""
        return int(cast("int", Compiled.despite_faults(lambda: self.make(FOR_PYTHON).address)))


class Inlined(Compiled):
    """A function that numba writes into each kernel that calls it: it looks for these two attributes."""

    targetoptions: ClassVar[dict[str, object]] = {"inline": "always"}

    @property
    def py_func(self) -> Callable[..., object]:
        """The Python function."""
        return self._function


@functools.cache
def numba() -> Any:
    """numba, which is told that to a kernel a function is what numba makes of it.

    Raises
    ------
    UsageError
        If its user has switched compiling off.
    """
    import numba as package
    from numba.extending import typeof_impl

    config: Any = package.config
    if config.DISABLE_JIT:
        raise UsageError("NUMBA_DISABLE_JIT", config.DISABLE_JIT, "0, since kernels run compiled only")
    for kind in (Compiled, Inlined, Procedure):
        typeof_impl.register(kind, lambda value, context: typeof_impl(_for_kernels(value), context))
    return package


def _for_kernels(function: Compiled) -> Any:
    return function.make(FOR_KERNELS, no_cpython_wrapper=True)


_interpreted: ContextVar[bool] = ContextVar("interpreted", default=False)


@contextlib.contextmanager
def interpreted() -> Iterator[None]:
    """Run kernels as Python in the block: for a few numbers, since loading compiled code takes half a second.

    Results differ from compiled ones by rounding.
    """
    token = _interpreted.set(True)
    try:
        with np.errstate(all="ignore"):
            yield
    finally:
        _interpreted.reset(token)


def functions_passed(error: Exception) -> set[str]:
    """Names of the functions of numba's cache that an error has passed through; none if it is not of the cache."""
    frames = (frame for frame, _ in traceback.walk_tb(error.__traceback__))
    return {frame.f_code.co_name for frame in frames if frame.f_globals.get("__name__") == NUMBA_CACHE}


def kernel(function: Function) -> Function:
    """Compile a function with the package's settings: kept, without the GIL, vectorisable loops."""
    return cast("Function", Compiled(function))


def inlined(function: Function) -> Function:
    """Compile a function into each kernel that calls it: a few lines cost more as a function of their own."""
    return cast("Function", Inlined(function))


def compile_for(function: Callable[..., object], *arguments: object) -> None:
    """Compile a kernel for arguments like these, or load it, without a call."""
    compiled = cast("Compiled", function)
    kinds = tuple(numba().typeof(argument) for argument in arguments)
    Compiled.despite_faults(lambda: compiled.make(FOR_PYTHON).compile(kinds))


def procedure(signature: Any) -> Callable[[Callable[..., object]], Procedure]:
    """Compile a function once for all kernels, which call it by `call_by_address` of the same signature.

    numba compiles a kernel anew into each kernel that calls it; a large one that many call would take most of the
    first run. Arguments and result are numbers and pointers.
    """
    return lambda function: Procedure(function, signature)


def call_by_address(signature: Any) -> Callable[..., Any]:
    """How kernels call a `procedure`: a function of its address, then of its arguments."""
    numba()
    from llvmlite import ir
    from numba import types
    from numba.extending import intrinsic

    @intrinsic
    def call(_typing: Any, address: Any, *arguments: Any) -> Any:
        handed = types.StarArgTuple.from_types(signature.args)

        def generate(context: Any, builder: Any, _: Any, values: Any) -> Any:
            kinds = [context.get_value_type(kind) for kind in (signature.return_type, *signature.args)]
            function = builder.inttoptr(values[0], ir.FunctionType(kinds[0], kinds[1:]).as_pointer())
            return builder.call(function, [builder.extract_value(values[1], i) for i in range(len(signature.args))])

        return signature.return_type(types.int64, handed), generate

    return cast("Callable[..., Any]", call)


def lending() -> Callable[[Any], Any]:
    """How a kernel hands an array on without counting references to it, for as long as its owner lives.

    Where small kernels hand each other tuples of arrays, counting takes most of the time.
    """
    numba()
    from numba.core import cgutils
    from numba.extending import intrinsic

    @intrinsic
    def lent(_typing: Any, array: Any) -> Any:
        def generate(context: Any, builder: Any, _: Any, values: Any) -> Any:
            fields = cgutils.create_struct_proxy(array)(context, builder, value=values[0])
            fields.meminfo = cgutils.get_null_value(fields.meminfo.type)
            return fields._getvalue()

        return array(array), generate

    return cast("Callable[[Any], Any]", lent)
