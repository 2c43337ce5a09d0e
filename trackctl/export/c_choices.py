"""What C is made of; without NumPy, so that the command line can name it quickly."""

from __future__ import annotations

from enum import StrEnum


class CMethod(StrEnum):
    """How values between nodes are found in C, as `lookup` does."""

    LINEAR = "linear"
    MLS = "mls"


class Precision(StrEnum):
    """Type of numbers in C."""

    FLOAT = "float"
    DOUBLE = "double"

    @property
    def size(self) -> int:
        """[bytes]"""
        return 4 if self is Precision.FLOAT else 8

    @property
    def epsilon(self) -> float:
        """From 1 to the next number."""
        return 2.0**-23 if self is Precision.FLOAT else 2.0**-52

    @property
    def words(self) -> dict[str, str]:
        """The type, its functions of <math.h>, and its literals for 0, 1 and 2."""
        suffix = "f" if self is Precision.FLOAT else ""
        functions = {name: name + suffix for name in ("fabs", "floor", "cos")}
        return {"real": self.value, "zero": f"0.0{suffix}", "one": f"1.0{suffix}", "two": f"2.0{suffix}", **functions}
