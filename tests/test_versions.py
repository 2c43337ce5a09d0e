"""What pyproject.toml allows, against the versions that are tested."""

import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.version import Version

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]


def requirements(extras):
    """All requirements of the package and of some extras, but for those on itself."""
    each = [*PROJECT["dependencies"], *(word for extra in extras for word in EXTRAS[extra])]
    return [wanted for wanted in map(Requirement, each) if wanted.name != PROJECT["name"]]


def pins(name):
    """Version of each library in a file of constraints."""
    lines = (ROOT / name).read_text(encoding="utf-8").splitlines()
    pinned = [Requirement(line) for line in lines if not line.startswith("#")]
    return {pin.name: Version(next(iter(pin.specifier)).version) for pin in pinned}


def bounds(wanted, operator):
    return [Version(bound.version) for bound in wanted.specifier if bound.operator == operator]


@pytest.mark.parametrize("wanted", requirements(EXTRAS), ids=str)
def test_the_lock_is_allowed(wanted):
    assert pins("constraints.txt")[wanted.name.lower()] in wanted.specifier


@pytest.mark.parametrize("wanted", requirements(("cluster", "geo", "plot", "test")), ids=str)
def test_the_declared_minimum_is_the_tested_one(wanted):
    assert bounds(wanted, ">=") == [pins("constraints-minimum.txt")[wanted.name.lower()]]


def test_numba_goes_no_farther_than_tested():
    (numba,) = (wanted for wanted in requirements(()) if wanted.name == "numba")
    (end,), newest = bounds(numba, "<"), pins("constraints.txt")["numba"]
    assert (end.major, end.minor) == (newest.major, newest.minor + 1)
