"""What a profile quantity may be, stated once for checking, reading, writing and help."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from trackctl.errors import ProfileError

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

TEXTS = {"name": "a short text in one line", "description": "printable text", "source": "printable text"}


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number in a profile and the range it must lie in.

    Attributes
    ----------
    name
        Name of the field, without a unit.
    unit
        Unit suffix of the key in files, empty for a pure number.
    low, high
        Ends of the range, in SI units; generous, to catch slips of the pen or of the unit.
    meaning
        Half a line of help.
    low_excluded
        Whether `low` itself is out of range.
    """

    name: str
    unit: str
    low: float
    high: float
    meaning: str
    low_excluded: bool = False

    @property
    def key(self) -> str:
        """The key in files: the name with its unit."""
        return f"{self.name}_{self.unit}" if self.unit else self.name

    def allows(self, value: object) -> bool:
        """Whether a value, in SI units, is a number in range; NaN is not."""
        if isinstance(value, bool) or not isinstance(value, int | float):
            return False
        return bool(self.low <= value <= self.high) and not (self.low_excluded and value == self.low)

    def allowed(self, unit_size: float = 1.0) -> str:
        """The range as a phrase, in a unit of `unit_size` SI units."""
        low, high = (f"{end / unit_size:.12g}" for end in (self.low, self.high))
        return f"above {low}, up to {high}" if self.low_excluded else f"{low} to {high}"


def check_fields(profile: DataclassInstance, label: str, quantities: Sequence[Quantity]) -> None:
    """Check the texts and numbers of a profile, turning the numbers into floats.

    Raises
    ------
    ProfileError
        If a text is not printable, or a number is not in its range. None passes where it is the default.
    """
    for key, allowed in TEXTS.items():
        text = getattr(profile, key)
        if not (_is_title(text) if key == "name" else _is_printable(text)):
            raise _refusal(label, key, text, allowed)
    defaults = {field.name: field.default for field in dataclasses.fields(profile)}
    for quantity in quantities:
        value = getattr(profile, quantity.name)
        if value is None and defaults[quantity.name] is None:
            continue
        if not quantity.allows(value):
            raise _refusal(label, quantity.name, value, f"{quantity.allowed()}, in SI units")
        object.__setattr__(profile, quantity.name, float(value))


def _is_title(text: object) -> bool:
    return isinstance(text, str) and text.isprintable() and bool(text.strip())


def _is_printable(text: object) -> bool:
    return isinstance(text, str) and all(char.isprintable() or char in "\n\t" for char in text)


def _refusal(label: str, key: str, value: object, allowed: str) -> ProfileError:
    return ProfileError(label, f"{key}: {value!r} is not allowed; allowed: {allowed}", None, key, value)
