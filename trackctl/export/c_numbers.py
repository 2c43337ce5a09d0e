"""Numbers as C99 writes them: in as few digits as bring them back to the last bit."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice

import numpy as np

from trackctl.export.c_choices import Precision
from trackctl.lut.axes import Array


def rounded(values: Array, precision: Precision) -> Array:
    """Numbers that a precision holds exactly."""
    return values.astype(np.float32).astype(np.float64) if precision is Precision.FLOAT else values


def literals(values: Array, precision: Precision) -> Iterator[str]:
    """Finite numbers as C has them."""
    if precision is Precision.DOUBLE:
        return map(repr, values.tolist())
    return (f"{value}f" for value in values.astype(np.float32))


def literal(value: float, precision: Precision) -> str:
    """A finite number as C has it."""
    return next(literals(np.array([value], np.float64), precision))


def rows(words: Iterable[str], length: int) -> Iterator[str]:
    """Words with commas between them, so many to a row."""
    remaining = iter(words)
    while row := list(islice(remaining, length)):
        yield ", ".join(row)
