"""Figures as files: the same figure gives the same bytes."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

from matplotlib.figure import Figure

#: What each kind of file would tell of the time and the program that wrote it.
TIMELESS: dict[str, dict[str, None]] = {
    ".png": {"Software": None},
    ".svg": {"Date": None, "Creator": None},
    ".pdf": {"CreationDate": None, "Producer": None, "Creator": None},
}


def save(figure: Figure, path: Path) -> None:
    """Write a figure in the format of the path's suffix, one of `TIMELESS`, within the style that it was drawn in.

    It is drawn in memory first: on a full disk matplotlib leaves files open.
    """
    suffix = path.suffix.lower()
    drawn = BytesIO()
    figure.savefig(drawn, format=suffix[1:], metadata=TIMELESS[suffix])
    path.write_bytes(drawn.getvalue())
