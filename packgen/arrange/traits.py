"""What an algorithm says of itself: attributes of its ``Params``, all of them optional."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from packgen.geometry import Container

__all__ = ["UNSAID", "Traits", "traits_of"]

UNSAID = "not said"


@dataclass(frozen=True, slots=True)
class Traits:
    """What an algorithm does with a scene; what its ``Params`` do not say is as it stands here.

    Attributes:
        zone_keys: Keys of a zone that it keeps: ``solid_fraction``, ``porosity``, ``void_ratio``, ``gap``.
        weightless: Whether its beds have no gravity.
        compacts: Whether it makes beds under gravity as dense as asked.
        holds: How it can hold a bed that is there before, its usual way first: ``surface``, ``fixed``.
        takes_clumps: Whether its particles may be clumps.
        free_cell: Whether it takes ``container: {cell: free}`` and nothing else.
        free_sizes: Where it places spheres of free sizes: in ``zones`` whose sets have them, or in the voids
            that its setting ``fill`` is about; None: nowhere.
        fits_container: Whether the container takes the size that the spheres need.
        any_amount: Whether amounts are an offer, from which it chooses.
        coverage: Solid fraction of the container at which it stops; None: it has none.
        may_change: What it changes of what a scene says: ``nothing``, ``radii``, ``container`` or ``count``.
        instead: Name of the algorithm that its settings choose in its place; None: itself.
        unsupported: Returns what it cannot do in a container: paths of the scene, and what to say there.
    """

    zone_keys: frozenset[str] = frozenset()
    weightless: bool = False
    compacts: bool = False
    holds: tuple[str, ...] = ()
    takes_clumps: bool = False
    free_cell: bool = False
    free_sizes: str | None = None
    fits_container: bool = False
    any_amount: bool = False
    coverage: float | None = None
    may_change: str = UNSAID
    instead: str | None = None
    unsupported: Callable[[Container], list[tuple[str, str]]] | None = None


def traits_of(params: Any) -> Traits:
    """Return what settings, or their class, say of their algorithm.

    Args:
        params: ``Params`` of an algorithm: an instance, or the class, of which what hangs on settings is left
            out; anything else says nothing.
    """
    names = {each.name for each in fields(Traits)}
    said = {name: getattr(params, name) for name in names if hasattr(params, name)}
    if isinstance(params, type):
        said = {name: value for name, value in said.items() if not _hangs_on_settings(value)}
    return Traits(**said)


def _hangs_on_settings(value: Any) -> bool:
    return isinstance(value, property) or callable(value)
