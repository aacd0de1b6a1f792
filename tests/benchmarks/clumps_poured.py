"""Clumps poured by LAMMPS: the same bodies from apart, until still; then thinner until none overlaps."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from columns import column_document, read_scene

from exporters import lammps
from packgen.bed import Bed
from packgen.bodies import Bodies, members_of, random_turns, rotations
from packgen.check import near_pairs, wall_clearance
from packgen.clumps import template_of_spheres
from packgen.settling import settle

HAIR = 1.0e-12  # of a radius: rounding must not leave an overlap
ROUNDS = 1_000


def mark_of(bed: Bed, seed: int) -> Bed:
    """Return a bed of the clumps of another one, poured by LAMMPS and trimmed; it stands in a cylinder."""
    apart = _apart(bed, np.random.default_rng(seed))
    with tempfile.TemporaryDirectory(prefix="packgen_") as scratch:
        lammps.write(apart, Path(scratch), lammps.Options())
        poured = settle(apart, Path(scratch), solver="lammps").bed
    return trimmed(replace(poured, tolerance=None))


def _apart(bed: Bed, rng: np.random.Generator) -> Bed:
    """Return the clumps of a bed turned at random on a lattice above the floor of a higher cylinder."""
    assert bed.bodies is not None
    low, high = bed.container.bounds
    radius, spacing = 0.5 * float(high[0] - low[0]), 2.01 * float(bed.bodies.reach.max())
    across = np.arange(-radius, radius, spacing) + 0.5 * spacing
    grid = np.stack(np.meshgrid(across, across, indexing="ij"), axis=-1).reshape(-1, 2)
    grid = grid[np.linalg.norm(grid, axis=1) < radius - 0.5 * spacing]
    layer, place = np.divmod(np.arange(len(bed.bodies)), len(grid))
    middle = 0.5 * (low + high)[:2]
    centre = np.column_stack([middle + grid[place], low[2] + spacing * (layer + 0.5)])
    turned = replace(bed.bodies, position=centre, orientation=random_turns(rng, len(centre)))
    height = float(centre[:, 2].max() + spacing - low[2])
    document = column_document(1, seed=0)
    document["container"] = {"cylinder": {"radius": radius, "height": height}}
    return replace(_with(bed, turned), container=read_scene(document)[1])


def trimmed(bed: Bed) -> Bed:
    """Return a bed without overlap: the spheres of each clump made smaller about their centres as need be.

    Spheres stay where they are: a whole clump made smaller would draw its arms through others between them,
    and tetrapods that hold each other would never part.
    """
    assert bed.bodies is not None
    left = np.ones(len(bed.bodies))  # of the radii of each clump
    for _ in range(ROUNDS):
        share = _needed(bed, bed.radius * left[bed.body_index])
        if not share.any():
            return _with(bed, _thinner(bed.bodies, left))
        left *= 1.0 - 0.6 * share - HAIR * (share > 0.0)
    raise RuntimeError("clumps still overlap")


def _thinner(bodies: Bodies, left: np.ndarray) -> Bodies:
    """Return bodies whose spheres have some share of their radii each, (B,), and stay where they are."""
    templates, place = [], bodies.position.copy()
    turn = rotations(bodies.orientation)
    for k, share in enumerate(left):
        known = bodies.templates[bodies.template_index[k]]
        templates.append(template_of_spheres(known.name, known.spheres * [1.0, 1.0, 1.0, share]))
        place[k] += bodies.scale[k] * turn[k] @ templates[-1].place
    index = np.arange(len(left), dtype=np.int32)
    return replace(bodies, templates=tuple(templates), template_index=index, position=place)


def _with(bed: Bed, bodies: Bodies) -> Bed:
    position, radius, owner = members_of(bodies)
    return replace(bed, position=position, radius=radius, bodies=bodies, body_index=owner, tolerance=None)


def _needed(bed: Bed, radius: np.ndarray) -> np.ndarray:
    """Return the share of its radii by which each clump of a bed is too thick, were it to part alone, (B,).

    Args:
        bed: The bed; it stands in a vessel without seams.
        radius: Radii that its spheres have now [m], shape (N,).
    """
    assert bed.bodies is not None
    assert bed.body_index is not None
    share, owner = np.zeros(len(bed.bodies)), bed.body_index
    for pairs in near_pairs(bed.position, radius, body_index=owner, period=bed.container.period):
        for end in (pairs.first, pairs.second):
            np.maximum.at(share, owner[end], -pairs.gap / radius[end])
    into = radius - wall_clearance(bed.container, bed.position, radius)
    np.maximum.at(share, owner, into / radius)
    return np.asarray(np.where(share > HAIR, share, 0.0))
