"""How a function becomes a command: its docstring is the help, with a runnable example at the end."""

from __future__ import annotations

import inspect
from collections.abc import Callable

import typer

EXAMPLE = "\n\nExample:\n"
# Click leaves the line breaks of a paragraph alone that starts with this.
AS_IT_IS = "\b\n"


def help_texts(docstring: str) -> dict[str, str]:
    """The help and epilog of a command, from a docstring that ends in ``Example:`` and indented lines."""
    text, _, example = inspect.cleandoc(docstring).partition(EXAMPLE)
    return {"help": text, "epilog": f"{AS_IT_IS}Example:\n{example}"}


def add_command(app: typer.Typer, function: Callable[..., None]) -> None:
    """Add a command named after a function, ``compute_lut`` becoming ``compute-lut``."""
    name = function.__name__.strip("_").replace("_", "-")
    app.command(name, **help_texts(function.__doc__ or ""))(function)  # type: ignore[arg-type]
