"""Does a bed stand? Whether its contacts can carry its spheres' weights, and what friction that takes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import BoolArray, Float64Array
from packgen.bed import AnyBed, Bed
from packgen.measure.structure import structure_of
from packgen.programmes.forces import Balance, Structure, balance, least_friction

GAP = 2.0e-3  # radii: twice the gaps that the arrangement leaves between spheres that rest on each other
NOT_CARRIED_MAX = 0.02  # share of the weight; the loose spheres of a bed that stands have less
WHOLE_MAX = 2000  # spheres of a bed that is looked at as a whole
SAMPLE = 50_000  # spheres by which the heights of blocks are found
BLOCKS, BLOCK_SIZE = 4, 500  # of a larger one, so many blocks of so many spheres


@dataclass(frozen=True, slots=True)
class Standing:
    """Whether contacts can carry a bed, by forces that push and lie in the friction cones.

    Forces and torques of every sphere are to balance. Where they cannot, the forces that leave the least are
    taken: what they leave is how the bed starts to move when it is let go.

    Attributes:
        friction_least: Least coefficient of friction, the same at all spheres and walls, at which contacts
            carry all but `NOT_CARRIED_MAX` of the weight; None where even 2.0 is not enough.
        stands: Whether they carry as much at the materials' own frictions.
        not_carried: Share of the weight that they leave at the materials' own frictions: the spheres' mean
            acceleration by mass, in units of gravity.
        falling: Number of spheres that contacts leave more than half of the weight of, at the same
            frictions: mostly rattlers, which fall a little.
        gap: Largest gap that counts as a contact, as a fraction of the smaller radius.
        spheres: Number of spheres that were looked at.
        blocks: Number of blocks that they are in, spheres around them being fixed: what contacts cannot carry
            in a block they cannot carry in the bed, but a bed whose blocks stand may fall. 0: the whole bed.
    """

    friction_least: float | None
    stands: bool
    not_carried: float
    falling: int
    gap: float
    spheres: int
    blocks: int

    def as_text(self) -> str:
        """Return the least friction, and what is left at the bed's own, in words."""
        least = "none" if self.friction_least is None else f"{self.friction_least:.2g}"
        return f"{least} ({self.not_carried:.1%} of the weight not carried at its own friction)"


def standing(bed: Bed, *, gap: float = GAP, whole_max: int = WHOLE_MAX) -> Standing | None:
    """Return whether a bed stands.

    Args:
        bed: The bed.
        gap: Largest gap of a contact, as a fraction of the smaller radius.
        whole_max: Most spheres of a bed that is looked at as a whole; blocks of larger ones are.

    Returns:
        The findings; None without spheres, without gravity or a floor, of spheres joined to bodies, and where
        materials, densities or walls are not known.
    """
    if bed.count == 0 or bed.body_index is not None or not can_be_judged(bed):
        return None
    if bed.count <= whole_max:
        return stands_by(bed, gap, None)
    return stands_by(bed, gap, _blocks(bed))


def can_be_judged(bed: AnyBed) -> bool:
    """Return whether a bed lies on something, and its materials, densities and walls are known."""
    return bool(bed.materials and bed.weights_known and bed.container.walls_known and bed.rests)


def stands_by(bed: Bed, gap: float, chosen: BoolArray | None) -> Standing:
    """Return whether some spheres of a bed stand.

    Args:
        bed: The bed, or the part of it that may touch them.
        gap: Largest gap of a contact, as a fraction of the smaller radius.
        chosen: Which spheres are looked at, in blocks, shape (N,); None: the whole bed.
    """
    structure = structure_of(bed, gap, chosen)
    found = balance(structure)
    return Standing(
        friction_least=_least(structure, found),
        stands=found.share <= NOT_CARRIED_MAX,
        not_carried=found.share,
        falling=int(found.falling(structure).sum()),
        gap=gap,
        spheres=structure.count,
        blocks=0 if chosen is None else BLOCKS,
    )


def _least(structure: Structure, found: Balance) -> float | None:
    """Return the least friction, rounded as exactly as it is found."""
    least = least_friction(structure, NOT_CARRIED_MAX, found)
    return None if least is None else round(least, 3)


def _blocks(bed: Bed) -> BoolArray:
    """Return the spheres of cubes around the bed's middle, evenly over its solid volume's height, (N,)."""
    some = slice(None, None, sample_step(bed.count))
    chosen = np.zeros(bed.count, dtype=bool)
    size = min(BLOCK_SIZE, bed.count)
    for centre in block_centres(bed.position[some], bed.radius[some], bed.down):
        # The cube's half side is the distance to its last sphere, by the largest coordinate.
        apart = np.abs(bed.position - centre).max(axis=1)
        chosen[np.argpartition(apart, size - 1)[:size]] = True
    return chosen


def sample_step(count: int) -> int:
    """Return which of so many spheres, one in how many, tell where blocks are."""
    return max(1, count // SAMPLE)


def block_centres(position: Float64Array, radius: Float64Array, down: Float64Array) -> list[Float64Array]:
    """Return the centres of the blocks [m], (3,) each, evenly over the height of some spheres' volume."""
    height = -(position @ down)
    order = np.argsort(height, kind="stable")
    solid = np.cumsum(radius[order] ** 3)
    middle = np.median(position, axis=0)
    ranks = [int(np.searchsorted(solid, (place + 0.5) / BLOCKS * solid[-1])) for place in range(BLOCKS)]
    return [np.asarray(middle - (height[order[rank]] + middle @ down) * down) for rank in ranks]
