"""The command line: all commands, and how errors become exit codes.

Heavy modules (numpy, numba, scipy, h5py, yaml) are imported inside the command functions, so that help and
completion stay quick.
"""

from __future__ import annotations

import errno
import io
import os
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Annotated, Any, cast

import typer
from typer.core import TyperGroup

from trackctl import __version__
from trackctl.cli import profiles
from trackctl.cli.calibrate import calibrate
from trackctl.cli.compute_lut import compute_lut
from trackctl.cli.export import export
from trackctl.cli.forces import forces
from trackctl.cli.identify import identify
from trackctl.cli.info import info
from trackctl.cli.lookup import lookup
from trackctl.cli.plan import plan
from trackctl.cli.plot import plot
from trackctl.cli.predict import predict
from trackctl.cli.registration import add_command, help_texts
from trackctl.cli.sensitivity import sensitivity
from trackctl.cli.simulate import simulate
from trackctl.cli.sweep import sweep
from trackctl.cli.warm_up import warm_up
from trackctl.errors import NoAnswerError, TrackctlError, TrackctlWarning

NO_ANSWER = 1
BAD_INPUT = 2
INTERRUPTED = 130

#: One function per command, in the order of the help.
COMMANDS: tuple[Callable[..., None], ...] = (
    compute_lut,
    lookup,
    info,
    sensitivity,
    sweep,
    plan,
    simulate,
    forces,
    identify,
    predict,
    calibrate,
    plot,
    export,
    warm_up,
)
#: Groups of commands, by name.
GROUPS = {"profiles": profiles.app}

HELP = """Slope-steering tables, plans and forces for unmanned tracked vehicles.

Data goes to standard output or -o FILE, words go to standard error.
Exit codes: 0 done, 1 no answer, 2 bad input or usage, 130 after Ctrl-C.

Example:
  trackctl compute-lut -o lut.h5
"""


@contextmanager
def exit_codes() -> Iterator[None]:
    """Turn the errors that a user can mend into a message and an exit code."""
    try:
        try:
            yield
        finally:
            sys.stdout.flush()
    except NoAnswerError as error:
        raise _exit(NO_ANSWER, error) from None
    except TrackctlError as error:
        raise _exit(BAD_INPUT, error) from None
    except KeyboardInterrupt:
        raise _exit(INTERRUPTED) from None
    except OSError as error:
        if _is_closed_pipe(error):
            _drop_standard_output()
            raise _exit(0) from None
        if error.filename is None:
            _drop_standard_output()
        raise _exit(BAD_INPUT, f"{error.filename or 'input or output'}: {error.strerror or error}") from None


@contextmanager
def warnings_as_notes() -> Iterator[None]:
    """Show the package's own warnings as a line each on standard error, and others as Python does."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", TrackctlWarning)
        shown_by_python = warnings.showwarning

        def show(message: Warning | str, category: type[Warning], *rest: Any, **more: Any) -> None:
            if issubclass(category, TrackctlWarning):
                typer.echo(f"Note: {message}", err=True)
            else:
                shown_by_python(message, category, *rest, **more)

        warnings.showwarning = show
        yield


class Commands(TyperGroup):
    """The commands, within `exit_codes`."""

    def make_context(self, *args: Any, **settings: Any) -> Any:
        """Read the options before the command; ``--help`` and ``--version`` end here."""
        with exit_codes():
            return super().make_context(*args, **settings)

    def invoke(self, ctx: Any) -> Any:
        """Read the rest of the command line and run the command."""
        with exit_codes(), warnings_as_notes():
            return super().invoke(ctx)


def _exit(code: int, message: object = "") -> typer.Exit:
    if message:
        typer.echo(f"Error: {message}", err=True)
    return typer.Exit(code)


def _is_closed_pipe(error: OSError) -> bool:
    """Whether nobody reads standard output any more; Windows calls a write to it invalid."""
    is_invalid = sys.platform == "win32" and error.errno == errno.EINVAL and error.filename is None
    return isinstance(error, BrokenPipeError) or is_invalid


def _drop_standard_output() -> None:
    """Leave nothing for Python to write, and fail at, when it ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"trackctl {__version__}")
        raise typer.Exit


app = typer.Typer(
    name="trackctl",
    cls=Commands,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    **help_texts(HELP),  # type: ignore[arg-type]
)


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, callback=_print_version, help="Print the version.")
    ] = False,
) -> None:
    pass


for function in COMMANDS:
    add_command(app, function)
for name, group in GROUPS.items():
    app.add_typer(group, name=name)


def _prepare_streams() -> None:
    """Make standard output one of UTF-8, as files are, whatever the system's encoding; and replace closed streams."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:  # closed by the shell, or on Windows without a console
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115
    # Names of files may hold what is no Unicode.
    cast(io.TextIOWrapper, sys.stdout).reconfigure(encoding="utf-8", errors="backslashreplace")


def main() -> None:
    """Run the command line."""
    _prepare_streams()
    app(prog_name="trackctl")
