"""A stone: a closed mesh from a file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from packgen.clumps.body import Body, body_of
from packgen.container.meshfile import read_surface
from packgen.container.openings import refuse_open
from packgen.container.stitching import stitched
from packgen.container.topology import with_consistent_winding
from packgen.errors import GeometryError
from packgen.geometry import Surface
from packgen.units import LENGTHS


def read_stone(path: Path, units: str = "m", warn: Callable[[str], None] = lambda _: None) -> Body:
    """Return the body that a closed mesh bounds.

    Args:
        path: An STL, PLY, OBJ or OFF file, or anything that meshio reads.
        units: Unit of its coordinates, a key of `packgen.units.LENGTHS`.
        warn: Called with a sentence for each fault of the mesh that was mended.

    Raises:
        GeometryError: The mesh cannot be read, has holes, or bounds no volume.
    """
    surface, mended = read_surface(path, LENGTHS[units], "clump")
    for sentence in mended:
        warn(f"{path.name}: {sentence}")
    surface = stitched(surface)
    refuse_open(surface, lambda count: f"clump: {path.name} has holes: {count} open edges")
    if not _is_wound_alike(surface):
        try:
            surface, turned = with_consistent_winding(surface)
        except GeometryError as error:
            raise GeometryError(f"clump: {path.name}: {error}") from error
        warn(f"{path.name}: {turned} facets turned to agree with their neighbours")
    return body_of(surface, f"clump: {path.name}")


def _is_wound_alike(surface: Surface) -> bool:
    """Return whether each edge is run along as often one way as the other."""
    count = len(surface.vertices)
    edges = surface.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    along, back = (np.sort(edges[:, one] * count + edges[:, 1 - one]) for one in (0, 1))
    return np.array_equal(along, back)
