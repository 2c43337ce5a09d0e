"""When and by what command a file was made."""

from __future__ import annotations

import os
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

from trackctl import __version__
from trackctl.errors import UsageError


@dataclass(frozen=True, slots=True)
class Provenance:
    """Time in ISO 8601 and command line, for a file's attributes."""

    created: str
    history: str


def provenance(words: Sequence[str]) -> Provenance:
    """Now, or ``SOURCE_DATE_EPOCH``, and the command line of these words after ``trackctl``.

    Raises
    ------
    UsageError
        If ``SOURCE_DATE_EPOCH`` is no time.
    """
    return made_by(shlex.join(["trackctl", *words]))


def made_by(call: str) -> Provenance:
    """The same for a call of another kind."""
    created = moment().isoformat(timespec="seconds")
    return Provenance(created, f"{created} trackctl {__version__}: {call}")


def moment() -> datetime:
    """Now, or ``SOURCE_DATE_EPOCH``."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    if not epoch:
        return datetime.now(UTC)
    try:
        return datetime.fromtimestamp(int(epoch), UTC)
    except (ValueError, OverflowError, OSError):
        raise UsageError("SOURCE_DATE_EPOCH", epoch, "whole seconds since 1970") from None
