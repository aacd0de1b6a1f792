"""How long a run will take and what memory it will need, by rule: so much a sphere, measured once.

The numbers are those of README, of one core of its machine; a machine or a scene may be off by a factor of
two or three. The first run of all takes a minute or two more, while the loops are compiled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from packgen.arrange.traits import traits_of

__all__ = ["RULE", "Cost", "cost_of"]

START = 3.0  # seconds to load, and to write the page
FINISH = 6.0e-6  # seconds a sphere for check, measures and report
PROJECTION, ADAM, DISPERSED = 18.0e-6, 1.2e-3, 40.0e-6  # seconds a sphere, equal ones
FRONT = 18.0e-6  # seconds a sphere, of equal ones: 14 measured, and about 50 for 1:2 and 1:5
JAMMED, PROOF = 0.26e-3, 4.0e-3  # seconds a sphere, without and with a proof
AIMED = 2.5  # times as long under gravity for a solid fraction asked for: 1 to 4.8, see densities.txt
CELL, CELL_SPHERE = 0.02, 0.03  # seconds a start of SHRINKING_CELL, and more for each sphere
VOIDS = 0.6e-3  # seconds a sphere of void filling
PROOF_MAX = 2_000  # spheres up to which a proof is tried by itself
BROAD, BROAD_RATIO = 2.7, 5.0  # times as long for broad sizes, from this ratio of radii on
MEMORY_START, MEMORY = 0.35e9, 360.0  # bytes, and bytes a sphere

SEARCHES = ("OPTIMAL", "SHRINKING_CELL")  # they take their time by starts, not by spheres

RULE = (
    "3 s, and for each sphere 18 us (adam 1.2 ms, DISPERSED 0.04 ms, JAMMED 0.26 ms, with a proof 4 ms, "
    "VOID_FILLING 0.6 ms), up to 2.7 times that for broad sizes, 2.5 times for a solid fraction under "
    "gravity, and 6 us to measure it; SHRINKING_CELL 0.02 s a start and 0.03 s more for each sphere, OPTIMAL "
    "its time limit; 350 MB, and 0.36 kB for each sphere"
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


def cost_of(algorithm: str, params: Any, count: float, ratio: float, *, aimed: bool = False) -> Cost:
    """Return what a run costs.

    Args:
        algorithm: Name of the algorithm.
        params: Its settings.
        count: Number of spheres.
        ratio: Largest radius over the smallest.
        aimed: Whether a solid fraction is asked for.
    """
    if algorithm in SEARCHES:
        return Cost(START + _seconds_of_search(algorithm, params, count), MEMORY_START)
    each = _seconds_a_sphere(algorithm, params, count)
    if each is not None and aimed and traits_of(params).compacts:
        each *= AIMED
    broad = 1.0 + (BROAD - 1.0) * min(math.log(max(ratio, 1.0)) / math.log(BROAD_RATIO), 1.0)
    seconds = None if each is None else START + count * (each * broad + FINISH)
    return Cost(seconds, MEMORY_START + MEMORY * count)


def _seconds_of_search(algorithm: str, params: Any, count: float) -> float:
    """Return how long all starts of a search take on one core, at most."""
    if algorithm == "OPTIMAL":
        return float(params.time_limit)
    return float(params.starts * (CELL + CELL_SPHERE * count))


def _seconds_a_sphere(algorithm: str, params: Any, count: float) -> float | None:
    if algorithm == "ADAM" or traits_of(params).instead == "ADAM":
        return ADAM
    if algorithm == "JAMMED":
        proof = params.certificate
        return PROOF if proof is True or (proof == "auto" and count <= PROOF_MAX) else JAMMED
    known = {
        "COLLECTIVE_ARRANGEMENT": PROJECTION,
        "ADVANCING_FRONT": FRONT,
        "DISPERSED": DISPERSED,
        "VOID_FILLING": VOIDS,
    }
    return known.get(algorithm)
