"""Random numbers inside kernels: a stream of its own for each search, the same on every machine.

SplitMix64: Steele, Lea, Flood, Fast splittable pseudorandom number generators, 2014, doi:10.1145/2660193.2660195.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel

#: State of a stream, shape (1,).
Stream = NDArray[np.uint64]

STEP = np.uint64(0x9E3779B97F4A7C15)
FIRST_FACTOR = np.uint64(0xBF58476D1CE4E5B9)
SECOND_FACTOR = np.uint64(0x94D049BB133111EB)
FIRST_SHIFT, SECOND_SHIFT, THIRD_SHIFT = np.uint64(30), np.uint64(27), np.uint64(31)
UNUSED_BITS = np.uint64(11)
ULP = 2.0**-53


def stream_of(seed: int) -> Stream:
    """A stream for a seed of any size."""
    return np.random.SeedSequence(seed).generate_state(1, np.uint64).astype(np.uint64)


@kernel
def uniform(stream: Stream) -> float:
    """Evenly distributed over [0, 1)."""
    stream[0] += STEP
    bits = stream[0]
    bits = (bits ^ (bits >> FIRST_SHIFT)) * FIRST_FACTOR
    bits = (bits ^ (bits >> SECOND_SHIFT)) * SECOND_FACTOR
    bits = bits ^ (bits >> THIRD_SHIFT)
    return float(bits >> UNUSED_BITS) * ULP


@kernel
def between(stream: Stream, low: float, high: float) -> float:
    """Evenly distributed over [low, high)."""
    return low + (high - low) * uniform(stream)


@kernel
def normal(stream: Stream) -> float:
    """Of mean 0 and deviation 1 (Box and Muller)."""
    radius = math.sqrt(-2.0 * math.log(1.0 - uniform(stream)))
    return radius * math.cos(2.0 * math.pi * uniform(stream))
