"""Vehicle and terrain profiles as YAML: flat, every key with its unit."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import cast

import yaml

from trackctl.errors import ProfileError
from trackctl.files.profile_folders import ProfileKind, is_name, profile_files, search_folders
from trackctl.files.profile_schema import FOOTPRINT_KEY, SCHEMAS, Profile, Schema, build, kind_of
from trackctl.files.strict_yaml import STDIN, read_entries, read_text
from trackctl.profiles.checks import TEXTS, Quantity
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import BODY_QUANTITIES, VehicleProfile
from trackctl.units import factor_to_si


@dataclass(frozen=True, slots=True)
class ListedProfile:
    """A profile that can be called by its name."""

    name: str
    path: Path
    description: str


def load_vehicle(name_or_path: str) -> VehicleProfile:
    """The vehicle of a profile's name or file, ``-`` for standard input.

    Raises
    ------
    ProfileError
        If there is no such profile, or it holds what is not allowed; names file, line, key, value and range.
    """
    return parse_vehicle(*read_profile(name_or_path, ProfileKind.VEHICLE))


def load_terrain(name_or_path: str) -> TerrainProfile:
    """The terrain of a profile's name or file; see `load_vehicle`."""
    return parse_terrain(*read_profile(name_or_path, ProfileKind.TERRAIN))


def read_profile(name_or_path: str, *kinds: ProfileKind) -> tuple[str, str]:
    """Text and file of a profile of one of these kinds, not yet checked."""
    if name_or_path == STDIN or not is_name(name_or_path):
        return read_text(name_or_path)
    files = {name: path for kind in reversed(kinds) for name, path in profile_files(kind).items()}
    if name_or_path in files:
        return read_text(str(files[name_or_path]))
    folders = dict.fromkeys(str(folder) for kind in kinds for folder in search_folders(kind))
    raise ProfileError(
        name_or_path,
        f"no {' or '.join(kinds)} profile has this name; there are: {', '.join(files) or 'none'} "
        f"(in {', '.join(folders)}); a file is given with its folder or ending .yaml",
    )


def parse_vehicle(text: str, file: str) -> VehicleProfile:
    """The vehicle that a YAML text describes; `file` is for messages."""
    return cast(VehicleProfile, build(ProfileKind.VEHICLE, read_entries(text, file), file))


def parse_terrain(text: str, file: str) -> TerrainProfile:
    """The terrain that a YAML text describes; `file` is for messages."""
    return cast(TerrainProfile, build(ProfileKind.TERRAIN, read_entries(text, file), file))


def parse_profile(text: str, file: str) -> Profile:
    """The vehicle or terrain that a YAML text describes, whichever its keys are of."""
    entries = read_entries(text, file)
    return build(kind_of(entries.values(), file), entries, file)


def kind_of_profile(profile: Profile) -> ProfileKind:
    """Whether a profile is a vehicle or a terrain."""
    return ProfileKind.VEHICLE if isinstance(profile, VehicleProfile) else ProfileKind.TERRAIN


def list_profiles(kind: ProfileKind) -> list[ListedProfile]:
    """All profiles of a kind that have a name; one that cannot be used says so in its description."""
    listed = []
    for name, path in profile_files(kind).items():
        try:
            profile = parse_profile(*read_text(str(path)))
        except ProfileError as error:
            listed.append(ListedProfile(name, path, f"cannot be used: {error.problem}"))
        else:
            if kind_of_profile(profile) is kind:
                listed.append(ListedProfile(name, path, profile.description))
    return listed


def vehicle_to_yaml(profile: VehicleProfile) -> str:
    """The canonical text of a vehicle: `parse_vehicle` makes an equal one of it, bit for bit."""
    corners = ", ".join(f"[{_decimal(x)}, {_decimal(y)}]" for x, y in profile.footprint)
    lines = _canonical_lines(profile, SCHEMAS[ProfileKind.VEHICLE])
    return "".join(lines) + f"{FOOTPRINT_KEY}: [{corners}]\n"


def terrain_to_yaml(profile: TerrainProfile) -> str:
    """The canonical text of a terrain: `parse_terrain` makes an equal one of it, bit for bit."""
    return "".join(_canonical_lines(profile, SCHEMAS[ProfileKind.TERRAIN]))


def profile_template(example: Profile) -> str:
    """A commented file to fill in: every key with its meaning and range, and the values of an example."""
    kind = kind_of_profile(example)
    values = dataclasses.asdict(example)
    lines = [
        f"# A {kind} profile: `trackctl profiles check FILE` checks it, `--{kind} FILE` uses it.",
        "# A unit may be another one of the same quantity, such as _mm for _m.",
        f"name: my-{kind}",
        f"description: One line on the {kind}",
        "source: Where the values come from, and which are estimates",
    ]
    if isinstance(example, VehicleProfile):
        for quantity, coordinates in zip(BODY_QUANTITIES, zip(*example.footprint, strict=True), strict=True):
            values[quantity.name] = max(coordinates) - min(coordinates)
    lines += [_template_line(SCHEMAS[kind], quantity, values[quantity.name]) for quantity in SCHEMAS[kind].quantities]
    if kind is ProfileKind.VEHICLE:
        lines.append(
            _commented(f"# {FOOTPRINT_KEY}: [[x, y], ...]", "corners, in place of the body's length and width")
        )
    return "\n".join(lines) + "\n"


def _template_line(schema: Schema, quantity: Quantity, value: float | None) -> str:
    unit_size = factor_to_si(quantity.key)
    line = f"# {quantity.key}:" if value is None else f"{quantity.key}: {_decimal(value, unit_size)}"
    optional = "" if quantity.name in schema.required or quantity in BODY_QUANTITIES else "optional; "
    return _commented(line, f"{optional}{quantity.meaning}; {quantity.allowed(unit_size)}")


def _commented(line: str, comment: str) -> str:
    return f"{line:<40} # {comment}"


def _canonical_lines(profile: Profile, schema: Schema) -> Iterator[str]:
    for key in TEXTS:
        yield yaml.safe_dump({key: getattr(profile, key)}, allow_unicode=True)
    for quantity in schema.quantities:
        value = getattr(profile, quantity.name, None)
        if value is not None:
            yield f"{quantity.key}: {_decimal(value, factor_to_si(quantity.key))}\n"


def _decimal(value: float, unit_size: float = 1.0) -> str:
    """All digits of a value in a unit, as many as bring it back to the last bit."""
    return f"{Decimal(repr(value)) / Decimal(repr(unit_size)):f}"
