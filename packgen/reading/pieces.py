"""A bed in pieces from its manifest, and from what is known besides."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from packgen.bed import Census, ParticleSet
from packgen.container.primitives import box_surface
from packgen.errors import ReadError
from packgen.geometry import Box, Container
from packgen.pieces import Manifest, PieceBed, read_manifest
from packgen.reading.bed import GRAVITY, TOLERANCE, provenance_of
from packgen.reading.known import Known, known_by_provenance, known_by_scene, set_names
from packgen.reading.sets import place_of_set, with_densities

if TYPE_CHECKING:
    from packgen.scene import Scene

FORMAT = "manifest of a bed in pieces"


def read_pieces(
    path: Path,
    container: Container | None = None,
    *,
    scene: Scene | None = None,
    density: Mapping[str, float] = MappingProxyType({}),
    warn: Callable[[str], None] = lambda _: None,
) -> PieceBed:
    """Read the manifest of a bed in pieces; its spheres are read where they are used.

    Args:
        path: The manifest.
        container: The vessel; None: the scene's, else the one that the manifest knows.
        scene: Says sets, densities, materials, walls and gravity.
        density: Densities [kg/m3] by name of the set; "" stands for all that are not known.
        warn: Called with a line for each thing that looks wrong.

    Raises:
        ReadError: The manifest is not what it claims, or does not fit the scene.
    """
    manifest = read_manifest(path)
    if manifest.census.count == 0:
        raise ReadError(f"{path}: found no spheres, expected at least one")
    if scene is None:
        known = known_by_provenance(manifest.provenance)
    else:
        from packgen.container import load_container

        known = known_by_scene(scene, container or load_container(scene, warn))
    vessel = container or known.container
    if vessel is None:
        vessel = _own_container(manifest.census)
        warn(
            f"{path}: walls are not in the file: figures are of the box around the spheres; --scene or "
            "--container says otherwise"
        )
    if any(vessel.periodic):
        raise ReadError(
            f"{path}: found a box that wraps around, expected walls on all sides of a bed in pieces"
        )
    if known.gravity is None:
        warn(f"{path}: gravity is not in the file: -z is taken for down; --scene says otherwise")
    gravity = np.array(GRAVITY) if known.gravity is None else known.gravity
    said = provenance_of(
        path, FORMAT, {**manifest.provenance, **known.provenance}, walls_known=vessel.walls_known
    )
    return PieceBed(
        path.parent, manifest.pieces, manifest.census,
        with_densities(_sets(path, known, manifest), density), known.materials, known.wall_material,
        vessel, gravity, known.tolerance if known.source else TOLERANCE, said,
    )  # fmt: skip


def _sets(path: Path, known: Known, manifest: Manifest) -> tuple[ParticleSet, ...]:
    """Return the sets in the order of the manifest's."""
    number = len(manifest.census.counts)
    if not known.particle_sets:
        return tuple(ParticleSet(f"set_{each}", float("nan"), "") for each in range(number))
    names = set_names(manifest.provenance)
    names = names if len(names) == number else ()
    places = [place_of_set(each, names, known.particle_sets) for each in range(number)]
    if len(known.particle_sets) != number or [] in places:
        raise ReadError(
            f"{path}: found spheres of {number} sets, expected those of {known.source}: "
            f"{', '.join(each.name for each in known.particle_sets)}"
        )
    return tuple(known.particle_sets[place] for [place] in places)


def _own_container(census: Census) -> Container:
    """Return a box around all spheres, as if each were as large as the largest."""
    low = np.array(census.low) - max(census.radius_max)
    high = np.array(census.high) + max(census.radius_max)
    volume = float(np.prod(high - low))
    box = Box(low, high)
    return Container("box", box, box_surface(box), np.stack([low, high]), volume, walls_known=False)
