"""Choices of `export`; on their own, so that the command line can name them quickly."""

from __future__ import annotations

from enum import StrEnum

from trackctl.export.c_choices import CMethod, Precision

__all__ = ["CMethod", "ExportFormat", "Precision"]


class ExportFormat(StrEnum):
    """What a table becomes: C99 header and source, a MATLAB file, a NumPy archive."""

    C = "c"
    MAT = "mat"
    NPZ = "npz"

    @property
    def suffixes(self) -> tuple[str, ...]:
        """Of its files."""
        return (".h", ".c") if self is ExportFormat.C else (f".{self.value}",)
