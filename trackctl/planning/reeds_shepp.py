"""Ways between poses for a vehicle that drives forwards and backwards, the shortest among them.

The words are those of Reeds and Shepp, Optimal paths for a car that goes both forwards and backwards, 1990,
doi:10.2140/pjm.1990.145.367, solved here for the headings between their pieces: every arc of sense s (1 left, -1 right)
lies on a circle with the centre c = p - s n(h), n(h) = (sin h, -cos h) the right-hand normal of the heading h, and the
vector from the first centre to the last depends on one heading and one length or angle. Lengths are signed, backwards
negative; all signs that reach the end are words here, so one form stands for several of the paper's.
"""

from __future__ import annotations

import math

import numpy as np

from trackctl.compiled import kernel
from trackctl.planning.pieces import Way
from trackctl.planning.pose import wrapped

QUARTER = 0.5 * math.pi
#: Circles this close to touching do. [radii]
ROUNDING = 1e-12
#: Numbers of the first word of each form: CSC, CCC, CCCC, CCSC, CSCC, CCSCC; and of all.
CCC, CCCC, CCSC, CSCC, CCSCC, WORD_COUNT = 8, 12, 24, 40, 56, 64


@kernel
def _set(way: Way, i: int, sense: float, length: float) -> None:
    way.curvature[i], way.length[i], way.pivot[i] = sense, length, 0.0


@kernel
def _sign(word: int, bit: int) -> float:
    return 1.0 if (word >> bit) & 1 else -1.0


@kernel
def _between_centres(x: float, y: float, turn: float, first: float, last: float) -> tuple[float, float]:
    """Length and direction of the vector from the first circle's centre to the last one's."""
    across_x, across_y = x - last * math.sin(turn), y + last * math.cos(turn) - first
    return math.hypot(across_x, across_y), math.atan2(across_y, across_x)


@kernel
def _csc(x: float, y: float, turn: float, word: int, way: Way) -> int:
    """Arc, straight, arc: D = s e(h) + (last - first) n(h)."""
    first, last, forth = _sign(word, 0), _sign(word, 1), _sign(word, 2)
    distance, direction = _between_centres(x, y, turn, first, last)
    offset = first - last
    if distance < abs(offset) - ROUNDING:
        return 0
    straight = forth * math.sqrt(max(distance * distance - offset * offset, 0.0))
    heading = direction + math.atan2(offset, straight)
    _set(way, 0, first, wrapped(first * heading))
    _set(way, 1, 0.0, straight)
    _set(way, 2, last, wrapped(last * (turn - heading)))
    return 3


@kernel
def _ccc(x: float, y: float, turn: float, word: int, way: Way) -> int:
    """Three arcs: D = 4 sin(m / 2) e(h), h the heading halfway along the middle one of angle m."""
    first, forth = _sign(word, 0), _sign(word, 1)
    distance, direction = _between_centres(x, y, turn, first, first)
    if distance > 4.0 + ROUNDING:
        return 0
    middle = forth * 2.0 * math.asin(min(0.25 * distance, 1.0))
    heading = direction if forth > 0.0 else direction + math.pi
    _set(way, 0, first, wrapped(first * heading + 0.5 * middle))
    _set(way, 1, -first, middle)
    _set(way, 2, first, wrapped(first * (turn - heading) + 0.5 * middle))
    return 3


@kernel
def _cccc(x: float, y: float, turn: float, word: int, way: Way) -> int:
    """Four arcs, the inner two of equal size u.

    Driven opposite ways, D = 2 first (2 cos u - 1) n(h2), h2 the heading between them; driven the same way,
    D = 2 first (2 n(h1) - n(h1 - first u)), h1 the heading before them.
    """
    first, forth = _sign(word, 0), _sign(word, 1)
    distance, direction = _between_centres(x, y, turn, first, -first)
    if word < 8:
        factor = 0.5 * distance * _sign(word, 2)
        cosine = 0.5 * (1.0 + factor)
        if abs(cosine) > 1.0 + ROUNDING:
            return 0
        inner = forth * math.acos(max(-1.0, min(cosine, 1.0)))
        middle = direction + QUARTER + (0.0 if factor * first > 0.0 else math.pi)
        begin, end, second = middle + first * inner, middle - first * inner, -inner
    else:
        cosine = 0.25 * (5.0 - 0.25 * distance * distance)
        if abs(cosine) > 1.0 + ROUNDING:
            return 0
        inner = forth * math.acos(max(-1.0, min(cosine, 1.0)))
        turned = math.atan2(math.sin(first * inner), 2.0 - cosine)
        begin = direction + QUARTER - turned + (0.0 if first > 0.0 else math.pi)
        end, second = begin, inner
    _set(way, 0, first, wrapped(first * begin))
    _set(way, 1, -first, inner)
    _set(way, 2, first, second)
    _set(way, 3, -first, wrapped(first * (end - turn)))
    return 4


@kernel
def _ccsc(x: float, y: float, turn: float, word: int, way: Way) -> int:
    """Arc, quarter circle, straight, arc: D = (s + 2 sin m) e(h) - (first + last) n(h), h along the straight."""
    first, last, quarter, forth = _sign(word, 0), _sign(word, 1), QUARTER * _sign(word, 2), _sign(word, 3)
    distance, direction = _between_centres(x, y, turn, first, last)
    offset = first + last
    if distance < abs(offset) - ROUNDING:
        return 0
    along = forth * math.sqrt(max(distance * distance - offset * offset, 0.0))
    heading = direction - math.atan2(offset, along)
    _set(way, 0, first, wrapped(first * heading + quarter))
    _set(way, 1, -first, quarter)
    _set(way, 2, 0.0, along - math.copysign(2.0, quarter))
    _set(way, 3, last, wrapped(last * (turn - heading)))
    return 4


@kernel
def _ccscc(x: float, y: float, turn: float, word: int, way: Way) -> int:
    """Arc, quarter circle, straight, quarter circle, arc: D = (s + 4 sin m) e(h) - 2 first n(h)."""
    first, quarter, forth = _sign(word, 0), QUARTER * _sign(word, 1), _sign(word, 2)
    distance, direction = _between_centres(x, y, turn, first, -first)
    if distance < 2.0 - ROUNDING:
        return 0
    along = forth * math.sqrt(max(distance * distance - 4.0, 0.0))
    heading = direction - math.atan2(2.0 * first, along)
    _set(way, 0, first, wrapped(first * heading + quarter))
    _set(way, 1, -first, quarter)
    _set(way, 2, 0.0, along - math.copysign(4.0, quarter))
    _set(way, 3, first, quarter)
    _set(way, 4, -first, wrapped(first * (heading - turn) + quarter))
    return 5


@kernel
def _cscc(x: float, y: float, turn: float, word: int, way: Way) -> int:
    """The form CCSC driven back from the end to the start, and that reversed."""
    cos_turn, sin_turn = math.cos(turn), math.sin(turn)
    count = _ccsc(-cos_turn * x - sin_turn * y, sin_turn * x - cos_turn * y, -turn, word, way)
    for i in range(count // 2):
        j = count - 1 - i
        way.curvature[i], way.curvature[j] = way.curvature[j], way.curvature[i]
        way.length[i], way.length[j] = way.length[j], way.length[i]
    for i in range(count):
        way.length[i] = -way.length[i]
    return count


@kernel
def write_word(x: float, y: float, turn: float, word: int, way: Way) -> int:
    """Write a word's pieces, curvatures and lengths for a turning radius of 1.

    Parameters
    ----------
    x, y
        Of the end in the start's frame, in turning radii.
    turn
        Change of the tangent. [rad]
    word
        From 0 to `WORD_COUNT` - 1.
    way
        Is given the pieces.

    Returns
    -------
    int
        Their number, 0 where the word does not lead there.
    """
    if word < CCC:
        return _csc(x, y, turn, word, way)
    if word < CCCC:
        return _ccc(x, y, turn, word - CCC, way)
    if word < CCSC:
        return _cccc(x, y, turn, word - CCCC, way)
    if word < CSCC:
        return _ccsc(x, y, turn, word - CCSC, way)
    if word < CCSCC:
        return _cscc(x, y, turn, word - CSCC, way)
    return _ccscc(x, y, turn, word - CCSCC, way)


@kernel
def length_and_cusps(way: Way, count: int) -> tuple[float, int]:
    """Length of some pieces, in their unit, and how often the direction changes between them."""
    length, cusps, before = 0.0, 0, 0.0
    for i in range(count):
        length += abs(way.length[i])
        if way.length[i] * before < 0.0:
            cusps += 1
        if way.length[i] != 0.0:
            before = way.length[i]
    return length, cusps


@kernel
def reeds_shepp_length(x: float, y: float, turn: float, way: Way) -> float:
    """Length of the shortest word to a pose seen from the start, in turning radii; `way` is work space."""
    shortest = np.inf
    for word in range(WORD_COUNT):
        count = write_word(x, y, turn, word, way)
        if count > 0:
            shortest = min(shortest, length_and_cusps(way, count)[0])
    return float(shortest)
