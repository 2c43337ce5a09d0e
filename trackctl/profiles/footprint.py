"""The outline of a vehicle on the ground."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

Vertex = tuple[float, float]
Footprint = tuple[Vertex, ...]

MAX_VERTICES = 100
MAX_COORDINATE = 50.0  # [m]


def rectangle(length: float, width: float) -> Footprint:
    """Corners of a body centred on the contact centre, counter-clockwise from the right rear. [m]"""
    x, y = 0.5 * length, 0.5 * width
    return (-x, -y), (x, -y), (x, y), (-x, y)


def counter_clockwise(footprint: Footprint) -> Footprint:
    """The same outline, in counter-clockwise order."""
    return footprint if _doubled_area(footprint) >= 0.0 else footprint[::-1]


def footprint_problem(footprint: Footprint) -> str | None:
    """What keeps a row of vertices from being a simple polygon, or None."""
    if not 3 <= len(footprint) <= MAX_VERTICES:
        return f"{len(footprint)} vertices; allowed: 3 to {MAX_VERTICES}"
    for vertex in footprint:
        # Written so that NaN fails too.
        if not all(abs(coordinate) <= MAX_COORDINATE for coordinate in vertex):
            return f"vertex {list(vertex)}; allowed: -{MAX_COORDINATE:g} to {MAX_COORDINATE:g} m"
    if _doubled_area(footprint) == 0.0 or _crosses_itself(footprint):
        return "crosses or touches itself or has no area; allowed: the corners of a simple polygon in order"
    return None


def _edges(footprint: Footprint) -> Iterator[tuple[Vertex, Vertex]]:
    return zip(footprint, footprint[1:] + footprint[:1], strict=True)


def _doubled_area(footprint: Footprint) -> float:
    return sum(a[0] * b[1] - b[0] * a[1] for a, b in _edges(footprint))


def _crosses_itself(footprint: Footprint) -> bool:
    edges = list(_edges(footprint))
    if any(start == end for start, end in edges):
        return True
    return any(_edges_clash(*pair) for pair in combinations(edges, 2))


def _edges_clash(first: tuple[Vertex, Vertex], second: tuple[Vertex, Vertex]) -> bool:
    """Whether two edges share a point other than the vertex that joins them."""
    (a, b), (c, d) = first, second
    if a == d and b != c:
        return _on_edge(first, c) or _on_edge(second, b)
    if b == c and a != d:
        return _on_edge(first, d) or _on_edge(second, a)
    if any(_on_edge(first, vertex) for vertex in second) or any(_on_edge(second, vertex) for vertex in first):
        return True
    return _side(a, b, c) * _side(a, b, d) < 0.0 and _side(c, d, a) * _side(c, d, b) < 0.0


def _side(a: Vertex, b: Vertex, point: Vertex) -> float:
    """Positive left of the line from a to b, zero on it."""
    return (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])


def _on_edge(edge: tuple[Vertex, Vertex], point: Vertex) -> bool:
    a, b = edge
    within = all(min(a[k], b[k]) <= point[k] <= max(a[k], b[k]) for k in (0, 1))
    return within and _side(a, b, point) == 0.0
