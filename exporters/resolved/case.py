"""The files of an OpenFOAM case that meshes the space between spheres."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from exporters.resolved import surfaces
from exporters.resolved.channel import Channel
from exporters.resolved.treatment import Bridges, Treated
from exporters.shared import deck
from exporters.walls.stl import write_solids
from packgen.arrays import Float64Array, Int64Array
from packgen.bed import Bed, with_owned_images
from packgen.errors import ExportError

CELLS_A_DIAMETER = 5.0
CELLS_MAX = 50_000_000
DICTIONARIES = ("blockMeshDict", "snappyHexMeshDict", "controlDict", "fvSchemes", "fvSolution")
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
FACES = (("(0 4 7 3)", "(1 2 6 5)"), ("(0 1 5 4)", "(3 7 6 2)"), ("(0 3 2 1)", "(4 5 6 7)"))


class Wanted(Protocol):
    """What the surfaces need of the options."""

    @property
    def spheres(self) -> str:
        """Form of the spheres."""
        ...

    @property
    def chord_error(self) -> float:
        """Chord error, as a fraction of a radius."""
        ...


@dataclass(frozen=True, eq=False, slots=True)
class Background:
    """The background mesh: corners [m], shape (2, 3), and cells along x, y, z."""

    bounds: Float64Array
    shape: tuple[int, int, int]


@dataclass(frozen=True, eq=False, slots=True)
class Parts:
    """The solids, with the images of those that reach across a seam.

    Attributes:
        treated: The spheres after treatment.
        position: Centres [m], the bed's own first, shape (M, 3).
        radius: Radii [m], shape (M,).
        owner: Index in the bed, shape (M,).
        sets: Names of the sets that have spheres, each a word of its own, by their index.
        set_index: Set of each sphere, shape (M,).
        own: How many of them are the bed's own.
        bridges: The bridges and their images.
        base: Where the axes of bridges begin, centres of spheres [m], shape (B, 3).
    """

    treated: Treated
    position: Float64Array
    radius: Float64Array
    owner: Int64Array
    sets: dict[int, str]
    set_index: Int64Array
    own: int
    bridges: Bridges
    base: Float64Array

    @property
    def rods(self) -> tuple[Float64Array, Float64Array, Float64Array]:
        """Both ends, shape (B, 3) each, and radii of the bridges, shape (B,) [m]."""
        start, stop = (
            self.base + length[:, None] * self.bridges.direction
            for length in (self.bridges.start, self.bridges.stop)
        )
        return start, stop, self.bridges.radius


def background(bed: Bed, channel: Channel, cell_size: float | None) -> Background:
    """Return the background mesh: a box itself, or one that is wider than the channel by a cell.

    Raises:
        ExportError: It would have too many cells.
    """
    size = 2.0 * float(bed.radius.min()) / CELLS_A_DIAMETER if cell_size is None else cell_size
    bounds = np.array(channel.bounds)
    if channel.kind != "box":
        bounds += np.array([[-size], [size]])
    count = np.maximum(1, np.rint((bounds[1] - bounds[0]) / size))
    if count.prod() > CELLS_MAX:
        raise ExportError(
            f"surface: a background mesh of {count.prod():.3g} cells of {size:.3g} m, expected at most "
            f"{CELLS_MAX:,}; enlarge surface.cell_size"
        )
    return Background(bounds, (int(count[0]), int(count[1]), int(count[2])))


def make_parts(bed: Bed, treated: Treated) -> Parts:
    """Return the solids of a treated bed."""
    position, _, owner = with_owned_images(bed)
    bridges, base = _bridge_images(bed, treated.bridges)
    words = deck.different_words([each.name for each in bed.particle_sets])
    return Parts(
        treated,
        position,
        treated.radius[owner],
        owner,
        {index: words[index] for index in np.unique(bed.set_index).tolist()},
        bed.set_index[owner].astype(np.int64),
        bed.count,
        bridges,
        base,
    )


def _bridge_images(bed: Bed, bridges: Bridges) -> tuple[Bridges, Float64Array]:
    """Return bridges and their images that reach into the box, and where their axes begin [m]."""
    low, high = bed.container.bounds
    index, base = np.arange(len(bridges.owner)), bed.position[bridges.owner]
    if any(bed.container.periodic):
        steps = [(-1, 0, 1) if wraps else (0,) for wraps in bed.container.periodic]
        shifts = np.array(list(product(*steps))) * (high - low)
        index = np.tile(index, len(shifts))
        base = (base + shifts[:, None]).reshape(-1, 3)
        ends = np.stack([base + length[index, None] * bridges.direction[index] for length in
                         (bridges.start, bridges.stop)])  # fmt: skip
        thick = bridges.radius[index, None]
        reaches = ((ends.max(axis=0) + thick > low) & (ends.min(axis=0) - thick < high)).all(axis=1)
        index, base = index[reaches], base[reaches]
    chosen = Bridges(
        bridges.owner[index],
        bridges.direction[index],
        bridges.start[index],
        bridges.stop[index],
        bridges.radius[index],
    )
    return chosen, base


def write_surfaces(
    folder: Path, parts: Parts, walls: dict[str, Float64Array], options: Wanted
) -> tuple[list[Path], float | None]:
    """Write the STL files, and return their paths and the volume in the facets of the bed's spheres [m3]."""
    place, error = folder / "constant" / "triSurface", options.chord_error
    paths = (
        [write_solids(place / "walls.stl", {name: [each] for name, each in walls.items()})] if walls else []
    )
    if options.spheres == "analytic":
        return [*paths, _write_analytic(folder / "system" / "spheres", parts)], None
    total = [0.0]
    solids = {word: _set_triangles(parts, index, error, total) for index, word in parts.sets.items()}
    paths.append(write_solids(place / "spheres.stl", solids))
    if len(parts.base):
        rods = surfaces.bridge_triangles(parts.base, parts.bridges, error)
        paths.append(write_solids(place / "bridges.stl", {"bridges": rods}))
    return paths, total[0]


def _set_triangles(parts: Parts, index: int, error: float, total: list[float]) -> Iterator[Float64Array]:
    """Yield the triangles of a set's spheres and images; add the volume of its own ones to a total."""
    for own in (True, False):
        chosen = np.flatnonzero(
            (parts.set_index == index) & ((np.arange(len(parts.owner)) < parts.own) == own)
        )
        for triangles in surfaces.sphere_triangles(
            parts.position[chosen], parts.radius[chosen], parts.owner[chosen], parts.treated.cuts, error
        ):
            total[0] += surfaces.enclosed_volume(triangles) if own else 0.0
            yield triangles


def _write_analytic(path: Path, parts: Parts) -> Path:
    """Write spheres and bridges as entries of snappyHexMeshDict's ``geometry``."""
    with path.open("w", encoding="ascii", newline="\n") as file:
        for number, (centre, radius, index) in enumerate(
            zip(parts.position.tolist(), parts.radius.tolist(), parts.set_index.tolist(), strict=True), 1
        ):
            file.write(
                f"sphere_{parts.sets[index]}_{number} {{ type searchableSphere; centre {vector(centre)}; "
                f"radius {radius!r}; }}\n"
            )
        for number, (start, stop, radius) in enumerate(
            zip(*(each.tolist() for each in parts.rods), strict=True), 1
        ):
            file.write(
                f"bridge_{number} {{ type searchableCylinder; point1 {vector(start)}; point2 {vector(stop)}; "
                f"radius {radius!r}; }}\n"
            )
    return path


def vector(values: Iterable[float]) -> str:
    """Return a vector as OpenFOAM writes it."""
    return f"({' '.join(repr(float(each)) for each in values)})"


def dictionary_values(
    bed: Bed, channel: Channel, mesh: Background, parts: Parts, walls: list[str]
) -> dict[str, Any]:
    """Return what the templates place beside the options and the point in the fluid."""
    return {
        **deck.provenance_values(bed),
        "count": bed.count,
        "vertices": [vector(mesh.bounds[corner, [0, 1, 2]]) for corner in np.array(CORNERS)],
        "cells": " ".join(map(str, mesh.shape)),
        "patches": _patches(channel),
        "walls": walls,
        "sets": list(parts.sets.values()),
        "bridges": len(parts.base),
    }


def _patches(channel: Channel) -> list[dict[str, Any]]:
    """Return the patches of the background mesh: name, type and faces."""
    if channel.kind != "box":
        faces = [face for pair in FACES for face in pair]
        return [{"name": "outside", "type": "patch", "faces": faces}]
    found: list[dict[str, Any]] = []
    closed: list[str] = []
    flow = int(np.argmax(np.abs(channel.up))) if channel.is_tube else None
    for axis in range(3):
        low, high = FACES[axis]
        if channel.container.periodic[axis]:
            found += [
                {"name": f"{'xyz'[axis]}_{end}", "type": "patch", "faces": [face]}
                for end, face in (("low", low), ("high", high))
            ]
        elif axis == flow:
            is_low = channel.inlet_low == bool(channel.up[axis] > 0.0)
            inlet, outlet = (low, high) if is_low else (high, low)
            found.append({"name": "inlet", "type": "patch", "faces": [inlet]})
            found.append({"name": "outlet", "type": "patch", "faces": [outlet]})
        else:
            closed += [low, high]
    return [*found, {"name": "walls_wall", "type": "wall", "faces": closed}] if closed else found


def write_dictionaries(folder: Path, values: dict[str, Any], templates: Path | None) -> list[Path]:
    """Write the dictionaries and ``Allrun``, and return their paths."""
    paths = [
        deck.write_text(folder / "system" / name, deck.render(f"surface/{name}.j2", values, templates))
        for name in DICTIONARIES
    ]
    paths.append(deck.write_text(folder / "Allrun", deck.render("surface/Allrun.j2", values, templates)))
    paths[-1].chmod(0o755)
    return paths
