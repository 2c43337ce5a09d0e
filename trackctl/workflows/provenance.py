"""When and by what command a file was made."""

from __future__ import annotations

import os
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from trackctl import __version__
from trackctl.errors import UsageError


@dataclass(frozen=True, slots=True)
class Provenance:
    """Time in ISO 8601 and command line, for a file's attributes."""

    created: str
    history: str


def provenance(command: Sequence[str]) -> Provenance:
    """Now, or ``SOURCE_DATE_EPOCH``, and the command line without the program's folder."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    if epoch is None:
        moment = datetime.now(UTC)
    elif epoch.isdecimal():
        moment = datetime.fromtimestamp(int(epoch), UTC)
    else:
        raise UsageError("SOURCE_DATE_EPOCH", epoch, "whole seconds since 1970")
    created = moment.isoformat(timespec="seconds")
    words = shlex.join([Path(command[0]).name, *command[1:]])
    return Provenance(created, f"{created} trackctl {__version__}: {words}")
