"""A random stream for compiled code that depends on nothing but its seed: not on threads, not on what ran before."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel

Stream = NDArray[np.uint64]


@kernel
def stream(seed: int, index: int) -> Stream:
    """Stream number `index` of a seed: a state of shape (1,), advanced by each draw."""
    state = np.empty(1, np.uint64)
    state[0] = np.uint64(seed) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(index)
    for _ in range(2):
        state[0] = np.uint64(next_bits(state))
    return state


@inlined
def next_bits(state: Stream) -> np.uint64:
    """Next 64 random bits (splitmix64: Steele, Lea, Flood 2014, doi 10.1145/2660193.2660195)."""
    state[0] += np.uint64(0x9E3779B97F4A7C15)
    z = state[0]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.uint64(z ^ (z >> np.uint64(31)))


@kernel
def uniform(state: Stream) -> float:
    """Next number in [0, 1)."""
    return (next_bits(state) >> np.uint64(11)) * (1.0 / 9007199254740992.0)
