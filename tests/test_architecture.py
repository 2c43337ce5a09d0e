"""The rooms of the package and which of them may import which, read from the sources."""

import ast
from pathlib import Path

import pytest
from systems import NOT_ON_WINDOWS

PACKAGE = Path(__file__).parent.parent / "trackctl"
ROOT = "trackctl"

# From the top down; a room may import what stands in its row, and what is open to all.
OPEN_TO_ALL = {"errors", "machine", "compiled", "__init__"}
#: What these may import themselves; the package's own names are those of the api, loaded when they are first used.
OPEN_MAY_IMPORT = {"__init__": {"api", "errors"}, "compiled": {"errors"}}
MAY_IMPORT = {
    "units": set(),
    "geometry": set(),
    "profiles": {"geometry"},
    "mechanics": {"profiles", "geometry"},
    "solvers": set(),
    "lut": {"profiles", "mechanics", "solvers"},
    "planning": {"profiles", "geometry", "lut"},
    "simulation": {"profiles", "geometry", "mechanics", "solvers", "lut"},
    "identification": {"profiles", "geometry", "mechanics", "solvers"},
    "sensitivity": set(),
    "forces": {"profiles", "geometry", "solvers"},
}
MAY_IMPORT["plots"] = set(MAY_IMPORT) - {"units"}
MAY_IMPORT["export"] = {"lut"}
MAY_IMPORT["files"] = set(MAY_IMPORT) - {"plots", "export"}
MAY_IMPORT["workflows"] = set(MAY_IMPORT)
# What Python users import does what the commands do, and hands the results' types on.
MAY_IMPORT["api"] = set(MAY_IMPORT) - {"plots", "export"}
# Commands that only read and write profiles need no workflow.
MAY_IMPORT["cli"] = {"workflows", "files", "units"}
MAY_IMPORT["__main__"] = {"cli"}

HOMES = {
    "typer": {"cli"},
    "click": {"cli"},
    "tqdm": {"cli"},
    "yaml": {"files"},
    "h5py": {"files"},
    "csv": {"files"},
    "PIL": {"files"},
    "tifffile": {"files"},
    "matplotlib": {"plots"},
    "distributed": {"workflows"},
    **{module: set() for module in NOT_ON_WINDOWS},
}


def sources():
    return sorted(PACKAGE.rglob("*.py"))


def room_of(path):
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported_modules(path):
    """Full names of the modules that a source imports, wherever in it; relative ones start with a dot."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module == ROOT and not node.level:
            yield from (f"{ROOT}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield "." * node.level + (node.module or "")


def imported_rooms(path):
    rooms = set()
    for module in imported_modules(path):
        parts = module.split(".")
        if parts[0] == ROOT:
            is_room = len(parts) > 1 and not parts[1].startswith("__")
            rooms.add(parts[1] if is_room else "__init__")
    return rooms


@pytest.mark.parametrize("path", sources(), ids=lambda path: str(path.relative_to(PACKAGE)))
def test_arrows_point_up(path):
    room = room_of(path)
    if room in OPEN_TO_ALL:
        assert imported_rooms(path) <= {"__init__"} | OPEN_MAY_IMPORT.get(room, set())
    else:
        assert room in MAY_IMPORT, f"{room} has no row in the table of rooms"
        assert imported_rooms(path) <= MAY_IMPORT[room] | OPEN_TO_ALL | {room}


@pytest.mark.parametrize("path", sources(), ids=lambda path: str(path.relative_to(PACKAGE)))
def test_libraries_stay_in_their_rooms(path):
    libraries = {module.split(".")[0] for module in imported_modules(path)}
    strays = {library for library in libraries & HOMES.keys() if room_of(path) not in HOMES[library]}
    assert not strays


@pytest.mark.parametrize("path", sources(), ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_are_absolute(path):
    assert not [module for module in imported_modules(path) if module.startswith(".")]


def test_rooms_depend_on_each_other_one_way():
    order = list(MAY_IMPORT)
    for room, others in MAY_IMPORT.items():
        assert all(order.index(other) < order.index(room) for other in others)


def test_a_stray_import_is_seen(tmp_path):
    source = tmp_path / "stray.py"
    inside = ("import yaml", "from trackctl import __version__, files", "from trackctl.lut.axes import Axes")
    source.write_text("\n    ".join(("def f():", *inside)))
    assert imported_rooms(source) == {"__init__", "lut", "files"}
    assert "yaml" in set(imported_modules(source))
