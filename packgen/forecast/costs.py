"""How long a run will take and what memory it will need, by rule: so much a sphere, measured once.

The numbers are those of README, of one core of its machine; a machine or a scene may be off by a factor of
two or three. The first run of all takes a minute or two more, while the loops are compiled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

__all__ = ["RULE", "Cost", "cost_of"]

START = 3.0  # seconds to load, and to write the page
FINISH = 6.0e-6  # seconds a sphere for check, measures and report
PROJECTION, ADAM, DISPERSED = 18.0e-6, 1.2e-3, 40.0e-6  # seconds a sphere, equal ones
FRONT = 10.0e-6  # seconds a sphere, of equal ones
JAMMED, PROOF = 0.26e-3, 4.0e-3  # seconds a sphere, without and with a proof
PROOF_MAX = 2_000  # spheres up to which a proof is tried by itself
BROAD, BROAD_RATIO = 2.7, 5.0  # times as long for broad sizes, from this ratio of radii on
MEMORY_START, MEMORY = 0.35e9, 360.0  # bytes, and bytes a sphere

RULE = (
    "3 s, and for each sphere 18 us (adam 1.2 ms, DISPERSED 0.04 ms, ADVANCING_FRONT 10 us, JAMMED 0.26 ms, "
    "with a proof 4 ms), up to 2.7 times that for broad sizes, and 6 us to measure it; 350 MB, and 0.36 kB "
    "for each sphere"
)


@dataclass(frozen=True, slots=True)
class Cost:
    """What a run costs.

    Attributes:
        seconds: Wall time on one core of the benchmarks' machine [s]; None of a plug-in's algorithm.
        memory: Largest memory [bytes].
    """

    seconds: float | None
    memory: float


def cost_of(algorithm: str, params: Any, count: float, ratio: float) -> Cost:
    """Return what a run costs.

    Args:
        algorithm: Name of the algorithm.
        params: Its settings.
        count: Number of spheres.
        ratio: Largest radius over the smallest.
    """
    each = _seconds_a_sphere(algorithm, params, count)
    broad = 1.0 + (BROAD - 1.0) * min(math.log(max(ratio, 1.0)) / math.log(BROAD_RATIO), 1.0)
    seconds = None if each is None else START + count * (each * broad + FINISH)
    return Cost(seconds, MEMORY_START + MEMORY * count)


def _seconds_a_sphere(algorithm: str, params: Any, count: float) -> float | None:
    if algorithm == "ADAM" or getattr(params, "instead", None) == "ADAM":
        return ADAM
    if algorithm == "JAMMED":
        proof = params.certificate
        return PROOF if proof is True or (proof == "auto" and count <= PROOF_MAX) else JAMMED
    known = {"COLLECTIVE_ARRANGEMENT": PROJECTION, "DISPERSED": DISPERSED, "ADVANCING_FRONT": FRONT}
    return known.get(algorithm)
