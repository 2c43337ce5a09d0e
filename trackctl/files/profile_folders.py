"""Where profiles lie: the folders of the user and those shipped with the package."""

from __future__ import annotations

import os
from enum import StrEnum
from pathlib import Path

SEARCH_PATH_VARIABLE = "TRACKCTL_PROFILE_PATH"
_ENDINGS = (".yaml", ".yml")
_PACKAGE = Path(__file__).parent.parent


class ProfileKind(StrEnum):
    """What a profile describes."""

    VEHICLE = "vehicle"
    TERRAIN = "terrain"

    @property
    def folder(self) -> str:
        """Name of the folder that holds profiles of this kind."""
        return f"{self.value}s"


def search_folders(kind: ProfileKind) -> list[Path]:
    """Folders that may hold profiles of a kind, the first one to have a name wins.

    Each folder of ``$TRACKCTL_PROFILE_PATH``, after its ``vehicles`` or ``terrains``, then the shipped ones.
    """
    users = [Path(folder) for folder in os.environ.get(SEARCH_PATH_VARIABLE, "").split(os.pathsep) if folder]
    shipped = _PACKAGE / "shipped" / kind.folder
    if not shipped.is_dir():  # a source checkout or an editable install
        shipped = _PACKAGE.parent / kind.folder
    return [place for folder in users for place in (folder / kind.folder, folder)] + [shipped]


def profile_files(kind: ProfileKind) -> dict[str, Path]:
    """The file behind each profile name, in order of name."""
    files: dict[str, Path] = {}
    for folder in search_folders(kind):
        for path in sorted(folder.glob("*")):
            if path.suffix in _ENDINGS and path.is_file():
                files.setdefault(path.stem, path)
    return dict(sorted(files.items()))


def is_name(name_or_path: str) -> bool:
    """Whether this is the name of a profile rather than the path of a file."""
    separators = [separator for separator in ("/", os.sep, os.altsep) if separator]
    return not name_or_path.endswith(_ENDINGS) and not any(separator in name_or_path for separator in separators)
