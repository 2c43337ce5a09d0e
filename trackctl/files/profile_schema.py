"""Which keys a profile file may hold, and how its entries become the fields of a profile."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from trackctl.errors import ProfileError
from trackctl.files.profile_folders import ProfileKind
from trackctl.files.strict_yaml import Entry, number, plain_text, points
from trackctl.profiles.checks import TEXTS, Quantity
from trackctl.profiles.footprint import rectangle
from trackctl.profiles.terrain import TERRAIN_QUANTITIES, TerrainProfile
from trackctl.profiles.vehicle import BODY_QUANTITIES, VEHICLE_QUANTITIES, VehicleProfile
from trackctl.units import accepted_keys, split_suffix

Profile = VehicleProfile | TerrainProfile

FOOTPRINT = "footprint"
FOOTPRINT_KEY = "footprint_m"


@dataclass(frozen=True)
class Schema:
    """What a file of one kind may hold.

    Attributes
    ----------
    profile
        The class that it becomes.
    quantities
        Its numbers, in file order.
    """

    profile: type[VehicleProfile] | type[TerrainProfile]
    quantities: tuple[Quantity, ...]

    @cached_property
    def quantity(self) -> dict[str, Quantity]:
        """The numbers by name."""
        return {quantity.name: quantity for quantity in self.quantities}

    @cached_property
    def keys(self) -> dict[str, str]:
        """The key of each name, in the unit that `trackctl` writes."""
        keys = {text: text for text in TEXTS} | {quantity.name: quantity.key for quantity in self.quantities}
        return keys | {FOOTPRINT: FOOTPRINT_KEY} if self.profile is VehicleProfile else keys

    @cached_property
    def required(self) -> set[str]:
        """Fields without a default."""
        return {f.name for f in dataclasses.fields(self.profile) if f.default is dataclasses.MISSING}


SCHEMAS = {
    ProfileKind.VEHICLE: Schema(VehicleProfile, VEHICLE_QUANTITIES + BODY_QUANTITIES),
    ProfileKind.TERRAIN: Schema(TerrainProfile, TERRAIN_QUANTITIES),
}


def kind_of(entries: Iterable[Entry], file: str) -> ProfileKind:
    """The kind of profile with most of these keys; refused if there is none."""
    names = {split_suffix(entry.key)[0] for entry in entries}
    hits = {kind: len(names & schema.quantity.keys()) for kind, schema in SCHEMAS.items()}
    kind = max(hits, key=lambda kind: hits[kind])
    if not hits[kind]:
        raise ProfileError(file, "has no key of a vehicle or terrain profile; see `trackctl profiles new`")
    return kind


def build(kind: ProfileKind, entries: dict[str, Entry], file: str) -> Profile:
    """The profile that the entries of a file describe."""
    schema = SCHEMAS[kind]
    found = kind_of(entries.values(), file)
    if found is not kind:
        raise ProfileError(file, f"is a {found} profile; a {kind} profile is needed here")
    given = _by_name(schema, entries.values())
    _refuse_missing(schema, given, file)
    fields: dict[str, Any] = {name: _value(schema, name, entry) for name, entry in given.items()}
    if kind is ProfileKind.VEHICLE and FOOTPRINT not in given:
        fields[FOOTPRINT] = rectangle(*(fields.pop(quantity.name) for quantity in BODY_QUANTITIES))
    try:
        return schema.profile(**fields)
    except ProfileError as error:
        entry = given.get(error.key or "")
        line, key = (entry.line, entry.key) if entry else (None, error.key)
        raise ProfileError(file, error.problem, line, key, error.value) from None


def _by_name(schema: Schema, entries: Iterable[Entry]) -> dict[str, Entry]:
    """The entries by the name they give a value to, whatever their unit."""
    names = {key: name for name, written in schema.keys.items() for key in accepted_keys(written)}
    given: dict[str, Entry] = {}
    for entry in entries:
        if entry.key not in names:
            raise entry.error(_unknown(schema, entry.key))
        name = names[entry.key]
        if name in given:
            raise entry.error(f"stands in line {given[name].line} as {given[name].key}; allowed: one of the two")
        given[name] = entry
    return given


def _unknown(schema: Schema, key: str) -> str:
    """What to say of a key that is none: its units if only they are wrong, or else the nearest key."""
    for name, fault in ((key, "has no unit"), (key.rpartition("_")[0], "has an unknown unit")):
        if name in schema.keys:
            return f"{fault}; allowed: {', '.join(accepted_keys(schema.keys[name]))}"
    near = difflib.get_close_matches(key, schema.keys.values(), n=1)
    guess = f"did you mean {near[0]}?" if near else f"allowed: {', '.join(schema.keys.values())}"
    return f"unknown key; {guess}"


def _refuse_missing(schema: Schema, given: dict[str, Entry], file: str) -> None:
    """Refuse a file that lacks a key, or gives an outline twice over."""
    required = set(schema.required)
    if FOOTPRINT in given:
        for quantity in BODY_QUANTITIES:
            if quantity.name in given:
                raise given[quantity.name].error(f"stands beside {given[FOOTPRINT].key}; allowed: one of the two")
    elif FOOTPRINT in required:
        required |= {quantity.name for quantity in BODY_QUANTITIES}
    missing = [key for name, key in schema.keys.items() if name in required - {FOOTPRINT} and name not in given]
    if missing:
        instead = f" (or {FOOTPRINT_KEY} for the body)" if missing[-1] == BODY_QUANTITIES[-1].key else ""
        raise ProfileError(file, f"missing keys: {', '.join(missing)}{instead}")


def _value(schema: Schema, name: str, entry: Entry) -> object:
    """The value of an entry, in SI."""
    if name in TEXTS:
        return plain_text(entry)
    unit_size = accepted_keys(entry.key)[entry.key]
    if name == FOOTPRINT:
        return points(entry, unit_size)
    allowed = schema.quantity[name].allowed(unit_size)
    value = number(entry, unit_size, allowed)
    if not schema.quantity[name].allows(value):
        raise entry.error(f"{entry.node.value} is not allowed; allowed: {allowed}", value)
    return value
