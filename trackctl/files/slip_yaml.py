"""A learned slip model as YAML: parameters, covariance, the vehicle and the data it came from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import yaml
from numpy.typing import NDArray

from trackctl.errors import InputFileError, ProfileError
from trackctl.files.strict_yaml import Entry, number, plain_text, read_entries, read_text
from trackctl.identification.identifier import LearnedSlip
from trackctl.identification.slip_model import PARAMETERS, SlipModel

Array = NDArray[np.float64]

FILETYPE, VERSION = "trackctl-slip", 1
NAMES = tuple(f"p{i + 1}" for i in range(PARAMETERS))
COMMENT = """\
# Slip model of `trackctl identify`. Track ICRs [m] of left and right track speeds V_l, V_r and the track gauge B:
#   y_l = B/2 + p1 a + p2 k + p7, y_r = -B/2 - p3 a - p4 k + p8, x = p5 a + p6 k + p9,
#   a = |V_r^2 - V_l^2| / (2 B), k = 2 |V_r - V_l| / (B (|V_r| + |V_l|)); then V_l times 1 + p10, V_r times 1 + p11.
# position_error, heading_error: standard deviation over the distance rolled and the angle turned.
"""
#: A covariance may be off symmetry and below zero by this much of its largest entry, by rounding.
ROUNDING = 1e-9
LARGEST = 1e6


@dataclass(frozen=True, slots=True, eq=False)
class SlipFile:
    """A slip model and where it comes from.

    Attributes
    ----------
    vehicle
        Name of the vehicle.
    track_gauge, sprocket_radius
        Of the vehicle, that the log was read with. [m]
    model
        Which parameters were learned.
    learned
        See `LearnedSlip`.
    log, created, history
        What it was learned from, when, and by what command line.
    updates
        Number of poses used.
    file
        Where it was read from, for messages.
    """

    vehicle: str
    track_gauge: float
    sprocket_radius: float
    model: SlipModel
    learned: LearnedSlip
    log: str
    updates: int
    created: str
    history: str
    file: str = ""


def slip_to_yaml(slip: SlipFile) -> str:
    """The text of a slip model; `read_slip` brings every number back to the last bit."""
    learned = slip.learned
    values = {
        "filetype": FILETYPE,
        "version": VERSION,
        "vehicle": slip.vehicle,
        "track_gauge_m": slip.track_gauge,
        "sprocket_radius_m": slip.sprocket_radius,
        "model": slip.model.value,
        "log": slip.log,
        "updates": slip.updates,
        "created": slip.created,
        "history": slip.history,
        "position_error": learned.position_error,
        "heading_error": learned.heading_error,
        **dict(zip(NAMES, learned.p.tolist(), strict=True)),
    }
    rows = "".join(f"  - [{', '.join(map(decimal, row))}]\n" for row in learned.covariance.tolist())
    return COMMENT + "".join(line(key, value) for key, value in values.items()) + f"covariance:\n{rows}"


def line(key: str, value: object) -> str:
    """A line of YAML."""
    if isinstance(value, float):
        return f"{key}: {decimal(value)}\n"
    return yaml.safe_dump({key: value}, allow_unicode=True, width=10_000)


def decimal(value: float) -> str:
    """A number in digits that YAML takes for one."""
    digits = repr(value)
    mantissa, mark, exponent = digits.partition("e")
    if not mark:
        return digits
    return f"{mantissa if '.' in mantissa else mantissa + '.0'}e{int(exponent):+03d}"


def read_slip(path: str) -> SlipFile:
    """A slip model's file, ``-`` for standard input.

    Raises
    ------
    InputFileError
        If the file is none; names line, key, value and what is allowed.
    """
    content, file = read_text(path)
    if not content.strip():
        raise InputFileError(file, "is empty; `trackctl identify --save` writes a slip model")
    entries = read_entries(content, file)
    refuse_keys(entries, file)
    filetype = entries["filetype"]
    if plain_text(filetype) != FILETYPE:
        raise filetype.error(f"{plain_text(filetype)!r} is not allowed; allowed: {FILETYPE}")
    version = number(entries["version"], 1.0, str(VERSION))
    if version != VERSION:
        raise entries["version"].error(f"{version:g} is not allowed; allowed: {VERSION}")
    model = plain_text(entries["model"])
    if model not in list(SlipModel):
        raise entries["model"].error(f"{model!r} is not allowed; allowed: {', '.join(SlipModel)}")
    learned = LearnedSlip(
        np.array([value(entries[name], -LARGEST, LARGEST) for name in NAMES]),
        covariance(entries["covariance"]),
        value(entries["position_error"], 0.0, LARGEST),
        value(entries["heading_error"], 0.0, LARGEST),
    )
    return SlipFile(
        plain_text(entries["vehicle"]),
        value(entries["track_gauge_m"], 0.02, 20.0),
        value(entries["sprocket_radius_m"], 0.002, 5.0),
        SlipModel(model),
        learned,
        plain_text(entries["log"]),
        int(value(entries["updates"], 0.0, 1e15)),
        plain_text(entries["created"]),
        plain_text(entries["history"]),
        file,
    )


KEYS = (
    "filetype", "version", "vehicle", "track_gauge_m", "sprocket_radius_m", "model", "log", "updates", "created",
    "history", "position_error", "heading_error", *NAMES, "covariance",
)  # fmt: skip


def refuse_keys(entries: dict[str, Entry], file: str) -> None:
    """Refuse a file with keys missing or unknown."""
    missing = [key for key in KEYS if key not in entries]
    if "filetype" in missing or len(missing) > len(KEYS) // 2:
        raise ProfileError(file, "is no slip model; `trackctl identify --save` writes one")
    if missing:
        raise ProfileError(file, f"missing keys: {', '.join(missing)}")
    for key, entry in entries.items():
        if key not in KEYS:
            raise entry.error(f"unknown key; allowed: {', '.join(KEYS)}")


def value(entry: Entry, low: float, high: float) -> float:
    """The number of an entry, within its range."""
    allowed = f"from {low:g} to {high:g}"
    found = number(entry, 1.0, allowed)
    if not low <= found <= high:
        raise entry.error(f"{entry.node.value} is not allowed; allowed: {allowed}", found)
    return found


def covariance(entry: Entry) -> Array:
    """The covariance of an entry, shape (11, 11)."""
    allowed = f"{PARAMETERS} rows of {PARAMETERS} numbers, symmetric, no variance negative"
    rows = entry.node.value if isinstance(entry.node, yaml.SequenceNode) else []
    square = len(rows) == PARAMETERS and all(
        isinstance(row, yaml.SequenceNode) and len(row.value) == PARAMETERS for row in rows
    )
    if not square:
        raise entry.error(f"is no matrix; allowed: {allowed}")
    matrix = np.array([[number(entry, 1.0, allowed, node) for node in row.value] for row in rows])
    largest = np.abs(matrix).max()
    if largest > LARGEST or np.abs(matrix - matrix.T).max() > ROUNDING * largest:
        raise entry.error(f"is not symmetric or too large; allowed: {allowed}")
    if np.linalg.eigvalsh(matrix).min() < -ROUNDING * largest:
        raise entry.error(f"is not positive; allowed: {allowed}")
    return matrix
