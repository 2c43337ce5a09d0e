"""Values of the keys of a map's YAML file, each checked; an error names file, line, key, value and what is allowed."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterable, Iterator, Mapping

import yaml

from trackctl.errors import MapError
from trackctl.files.strict_yaml import Entry, number, plain_text
from trackctl.geometry.circle import Circle
from trackctl.planning.obstacles import Polygon
from trackctl.units import accepted_keys

Range = tuple[float, float]

#: Coordinates up to here: projected ones have seven digits before the point. [m]
FARTHEST = 1e8
PLACE = (-FARTHEST, FARTHEST)
MOST_TURNED = 10.0 * 360.0
RADII = (1e-3, 1e6)
MOST_OBSTACLES = 10_000
OBSTACLES = "circles: [[x, y, radius], ...] and polygons: [[[x, y], [x, y], [x, y], ...], ...], in m"


def ranged(entry: Entry, low: float, high: float, node: yaml.Node | None = None) -> float:
    """The number of an entry, or of a node inside it, between `low` and `high`.

    Numbers like 5e-2, which YAML takes for text, are understood as in map_server.
    """
    node = node or entry.node
    allowed = f"{low:g} to {high:g}"
    value = _plain_number(node)
    if value is None:
        value = number(entry, 1.0, allowed, node)
    if not low <= value <= high:
        raise entry.error(f"{value:g} is not allowed; allowed: {allowed}", value)
    return value


def find(entries: Mapping[str, Entry], key: str) -> Entry | None:
    """The entry of a key, in whatever unit of its quantity."""
    found = [entries[other] for other in accepted_keys(key) if other in entries]
    if len(found) > 1:
        raise found[1].error(f"stands in line {found[0].line} as {found[0].key}; allowed: one of the two")
    return found[0] if found else None


def numbers(entry: Entry, ranges: Mapping[str, Range]) -> tuple[float, ...]:
    """The numbers of a list, with one for each range, which are named for messages."""
    nodes = _items(entry, entry.node, f"[{', '.join(ranges)}]")
    if len(nodes) != len(ranges):
        raise entry.error(f"has {len(nodes)} numbers; allowed: [{', '.join(ranges)}]")
    return tuple(ranged(entry, *between, node) for node, between in zip(nodes, ranges.values(), strict=True))


def in_metres(entry: Entry, names: Iterable[str]) -> tuple[float, ...]:
    """The coordinates of a list whose key has a unit of length. [m]"""
    size = accepted_keys(entry.key)[entry.key]
    return tuple(size * value for value in numbers(entry, dict.fromkeys(names, PLACE)))


def pose(entry: Entry) -> tuple[float, float, float]:
    """``[x_m, y_m, yaw_deg]``, the yaw in rad."""
    x, y, yaw = numbers(entry, {"x_m": PLACE, "y_m": PLACE, "yaw_deg": (-MOST_TURNED, MOST_TURNED)})
    return x, y, math.radians(yaw)


def tolerance(entry: Entry) -> tuple[float, float]:
    """``[position_m, yaw_deg]``, the yaw in rad, or the position alone, the yaw exact."""
    ranges = {"position_m": (0.0, 1000.0), "yaw_deg": (0.0, 180.0)}
    if isinstance(entry.node, yaml.ScalarNode):
        return ranged(entry, *ranges["position_m"]), 0.0
    position, yaw = numbers(entry, ranges)
    return position, math.radians(yaw)


def in_unit(entry: Entry, low: float, high: float) -> float:
    """The number of an entry, in SI by the unit of its key; so is the range, but for the message."""
    size = accepted_keys(entry.key)[entry.key]
    return ranged(entry, low / size, high / size) * size


def truth(entry: Entry) -> bool:
    """0, 1, or a word that YAML takes for false or true."""
    text = entry.node.value if isinstance(entry.node, yaml.ScalarNode) else ""
    found = {"0": False, "1": True, "false": False, "true": True, "no": False, "yes": True}.get(text.lower())
    if found is None:
        raise entry.error(f"{text or 'a list or mapping'} is not allowed; allowed: 0, 1, false, true", text)
    return found


def file_name(entry: Entry) -> str:
    """The text of an entry that names a file or profile."""
    name = plain_text(entry)
    if not name.strip() or "\0" in name:
        raise entry.error("is empty; allowed: the name of a file", name)
    return name


@contextlib.contextmanager
def named_by(entry: Entry) -> Iterator[None]:
    """Say of an error in a file by which entry the file is named."""
    try:
        yield
    except MapError as error:
        raise entry.error(str(error), entry.node.value) from error


def obstacles(entry: Entry) -> tuple[tuple[Circle, ...], tuple[Polygon, ...]]:
    """The circles and polygons of a mapping with the one, the other or both keys."""
    if not isinstance(entry.node, yaml.MappingNode):
        raise entry.error(f"is no mapping; allowed: {OBSTACLES}")
    lists: dict[str, list[yaml.Node]] = {}
    for key, node in entry.node.value:
        if key.value not in ("circles", "polygons") or key.value in lists:
            raise entry.error(f"{key.value!r} is unknown or there twice; allowed: {OBSTACLES}", key.value)
        lists[key.value] = _items(Entry(entry.file, key.start_mark.line + 1, key.value, node), node, OBSTACLES)
    if sum(map(len, lists.values())) > MOST_OBSTACLES:
        raise entry.error(f"holds too many; allowed: up to {MOST_OBSTACLES}")
    circles = tuple(_circle(part) for part in _parts(entry, "circle", lists.get("circles", [])))
    return circles, tuple(_polygon(part) for part in _parts(entry, "polygon", lists.get("polygons", [])))


def _parts(entry: Entry, kind: str, nodes: list[yaml.Node]) -> Iterator[Entry]:
    """Each obstacle as an entry of its own, so that messages tell its line and number."""
    for count, node in enumerate(nodes, start=1):
        yield Entry(entry.file, node.start_mark.line + 1, f"{entry.key}, {kind} {count}", node)


def _circle(entry: Entry) -> Circle:
    return Circle(*numbers(entry, {"x_m": PLACE, "y_m": PLACE, "radius_m": RADII}))


def _polygon(entry: Entry) -> Polygon:
    allowed = "three corners [x_m, y_m] or more, around an area"
    nodes = _items(entry, entry.node, allowed)
    corners = [Entry(entry.file, node.start_mark.line + 1, entry.key, node) for node in nodes]
    points = [numbers(corner, {"x_m": PLACE, "y_m": PLACE}) for corner in corners]
    if len(points) < 3 or not _span_an_area(points):
        raise entry.error(f"has {len(points)} corners and no area; allowed: {allowed}")
    return tuple((x, y) for x, y in points)


def _span_an_area(points: list[tuple[float, ...]]) -> bool:
    """Whether the points are not all on one line."""
    x, y = points[0]
    far_x, far_y = max(points, key=lambda point: math.dist(point, points[0]))
    return any((far_x - x) * (b - y) != (a - x) * (far_y - y) for a, b in points)


def _items(entry: Entry, node: yaml.Node, allowed: str) -> list[yaml.Node]:
    if not isinstance(node, yaml.SequenceNode):
        raise entry.error(f"is no list; allowed: {allowed}")
    return list(node.value)


def _plain_number(node: yaml.Node) -> float | None:
    """A number that YAML 1.1 takes for text, such as 5e-2; None where it is none or not finite."""
    if not isinstance(node, yaml.ScalarNode) or node.style or "_" in node.value:
        return None
    try:
        value = float(node.value)
    except ValueError:
        return None
    return value if math.isfinite(value) else None
