"""Random numbers inside of compiled loops, the same on every machine."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packgen.compiled import inlined


@inlined
def next_number(state: NDArray[np.uint64]):  # type: ignore[no-untyped-def]
    """Return the next random number of 64 bits (SplitMix64: Steele, Lea and Flood, OOPSLA 2014, 453)."""
    state[0] += np.uint64(0x9E3779B97F4A7C15)
    mixed = state[0]
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return mixed ^ (mixed >> np.uint64(31))
