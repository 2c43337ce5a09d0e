"""Flat YAML files read strictly: with line numbers, and without anchors, aliases, tags or repeated keys."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from decimal import Context, Decimal, localcontext
from pathlib import Path
from typing import Any

import yaml

from trackctl.errors import ProfileError
from trackctl.files.read_errors import read_errors

STDIN = "-"
STDIN_LABEL = "<stdin>"
PROFILE_HINT = "; `trackctl profiles new` writes a template"
MAX_BYTES = 1_000_000
MAX_DEPTH = 8
TOO_DEEP = f"nested more than {MAX_DEPTH} deep"

_NUMBER_TAGS = ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")
_TEXT_TAG = "tag:yaml.org,2002:str"


@dataclass(frozen=True, slots=True)
class Entry:
    """A key at the top level of a file, with its value and where it stands."""

    file: str
    line: int
    key: str
    node: yaml.Node

    def error(self, problem: str, value: object = None) -> ProfileError:
        """An error about this entry, to be raised."""
        return ProfileError(self.file, f"{self.key}: {problem}", self.line, self.key, value)


def read_text(source: str) -> tuple[str, str]:
    """Text of a small UTF-8 file, or of standard input for ``-``, and its name for messages.

    Raises
    ------
    ProfileError
        If the file is missing, a folder, not permitted, larger than `MAX_BYTES` or not UTF-8.
    """
    file = STDIN_LABEL if source == STDIN else source
    with read_errors(file, ProfileError):
        if source == STDIN:
            content = sys.stdin.buffer.read(MAX_BYTES + 1)
        else:
            with Path(source).open("rb") as stream:
                content = stream.read(MAX_BYTES + 1)
    if len(content) > MAX_BYTES:
        raise ProfileError(file, f"larger than {MAX_BYTES} bytes; allowed: a short YAML file")
    try:
        return content.decode("utf-8-sig"), file
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise ProfileError(file, "is not UTF-8 text; allowed: a YAML file", line) from error


def read_entries(text: str, file: str, hint: str = PROFILE_HINT) -> dict[str, Entry]:
    """The keys and values of a flat YAML mapping, in file order; the hint says where a good one can be had.

    Raises
    ------
    ProfileError
        If the text is no YAML, empty, not one mapping with text keys, or uses what `_check_plain` refuses.
    """
    try:
        _check_plain(text, file)
        root = yaml.compose(text, Loader=yaml.CSafeLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        problem = f"is not valid YAML: {error.problem or error.context}"
        raise ProfileError(file, TOO_DEEP if _is_deep_at(text, mark) else problem, _line(mark)) from error
    except yaml.YAMLError as error:
        raise ProfileError(file, f"is not valid YAML: {str(error).splitlines()[0]}") from error
    if root is None:
        raise ProfileError(file, f"is empty{hint}")
    if not isinstance(root, yaml.MappingNode):
        raise ProfileError(file, f"is no list of `key: value` lines{hint}", 1)
    entries: dict[str, Entry] = {}
    for key_node, node in root.value:
        entry = Entry(file, key_node.start_mark.line + 1, _key(key_node, file), node)
        if entry.key in entries:
            raise entry.error(f"stands here and in line {entries[entry.key].line}; allowed: once")
        entries[entry.key] = entry
    return entries


def number(entry: Entry, unit_size: float, allowed: str, node: yaml.Node | None = None) -> float:
    """The number of an entry, or of a node inside it, times `unit_size`.

    The product is taken in decimals, so that 1.7 kPa are 1700 Pa to the last bit.
    """
    node = node or entry.node
    if node.tag not in _NUMBER_TAGS:
        raise entry.error(f"{_not_a_number(node)}; allowed: {allowed}")
    with localcontext(Context(traps=[])):  # what is no decimal, or too large for one, becomes NaN
        value = float(Decimal(node.value) * Decimal(repr(unit_size)))
    if not math.isfinite(value):
        raise entry.error(f"{node.value} is no finite decimal number; allowed: {allowed}", value)
    return value


def plain_text(entry: Entry) -> str:
    """The text of an entry."""
    if entry.node.tag != _TEXT_TAG:
        raise entry.error(f"{_shown(entry.node)} is no text; allowed: text, in quotes where in doubt")
    return str(entry.node.value)


def points(entry: Entry, unit_size: float) -> tuple[tuple[float, float], ...]:
    """The points of an entry ``[[x, y], ...]``, each coordinate times `unit_size`."""
    allowed = "[[x, y], [x, y], ...]"
    rows = entry.node.value if isinstance(entry.node, yaml.SequenceNode) else [entry.node]
    if not all(isinstance(row, yaml.SequenceNode) and len(row.value) == 2 for row in rows):
        raise entry.error(f"is no list of points; allowed: {allowed}")
    coordinates = [[number(entry, unit_size, allowed, node) for node in row.value] for row in rows]
    return tuple((x, y) for x, y in coordinates)


def _check_plain(text: str, file: str) -> None:
    """Refuse what a flat file needs none of and could be an attack: references, tags, depth."""
    depth = documents = 0
    for event in yaml.parse(text, Loader=yaml.CSafeLoader):
        documents += isinstance(event, yaml.DocumentStartEvent)
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        problem = _event_problem(event, depth, documents)
        if problem:
            raise ProfileError(file, problem, _line(event.start_mark))


def _is_deep_at(text: str, mark: Any) -> bool:
    """Whether a parser that gave up at a mark may have met a limit of its own: it reads a line ahead of its events."""
    line = text[: mark.index if mark else 0].rpartition("\n")[2]
    return sum(map(line.count, "[{")) - sum(map(line.count, "]}")) > MAX_DEPTH


def _event_problem(event: yaml.Event, depth: int, documents: int) -> str | None:
    if documents > 1:
        return "a second YAML document starts here; allowed: one"
    if depth > MAX_DEPTH:
        return TOO_DEEP
    for name, what in (("anchor", "anchors and aliases"), ("tag", "tags")):
        if getattr(event, name, None) is not None:
            return f"YAML {what} ({getattr(event, name)}) are not allowed"
    return None


def _line(mark: Any) -> int | None:
    """Line number from 1 of a YAML mark."""
    return mark.line + 1 if mark else None


def _key(node: yaml.Node, file: str) -> str:
    if node.tag != _TEXT_TAG:
        raise ProfileError(file, f"{_shown(node)} is no key; allowed: a word", _line(node.start_mark))
    return str(node.value)


def _shown(node: yaml.Node) -> str:
    """The value as in the file, shortened; lists and mappings by their kind."""
    if not isinstance(node, yaml.ScalarNode):
        return "a list" if isinstance(node, yaml.SequenceNode) else "a mapping"
    text = node.value if len(node.value) <= 40 else f"{node.value[:37]}..."
    return repr(text) if text else "an empty value"


def _not_a_number(node: Any) -> str:
    """Why a node is no number for YAML, with the remedy where it is one for people."""
    try:
        is_finite = math.isfinite(float(node.value))
    except (TypeError, ValueError):
        is_finite = False
    if not is_finite:
        return f"{_shown(node)} is no number"
    if node.style in ("'", '"'):
        return f"{_shown(node)} is text because of its quotes"
    return f"YAML reads {node.value} as text; write it with a point and a signed exponent, like 1.0e+3"
