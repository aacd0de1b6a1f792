"""YADE: ``bed.py``, ``bed.txt``, ``wall.stl``; ``yade -n -x bed.py`` runs them, ``yade bed.py`` shows them.

Reference: YADE manual, classes ``Ip2_FrictMat_FrictMat_MindlinPhys``, ``Law2_ScGeom_MindlinPhys_Mindlin``,
``Wall``, ``Facet``. The force of two spheres is LIGGGHTS' Hertz-Mindlin. Walls differ: YADE takes a facet for
a sphere of twice the radius of the sphere that touches it, which makes the wall's force sqrt(2/3) of
LIGGGHTS', and a sphere above the edge of two facets touches both. Flat walls across an axis are therefore
planes (``Wall``, a sphere of the same radius: sqrt(1/2)), see `flat_walls`; ``wall.stl`` has the other walls.
Named parts of the walls are facets of files of their own; they move in the deck's own run alone, and those
that are to be removed are there for ``steps``, and gone for ``steps_open`` more.
``bed.txt`` has the columns x y z r and the number of the particle set; ``ymport.text`` reads it too. Of a bed
with clumps the number of the body comes before that, as ``ymport.textClumps`` has it, and ``clumps.txt`` has
mass, centre and inertia of each.

YADE's rolling friction (``includeMoment``) has one coefficient for all contacts, and its limit is the normal
force times the mean of both radii, where LIGGGHTS' epsd2 has the effective radius, half of it: `rolling`
makes both the same for two equal spheres.

A box that wraps around along some axes and has walls along others is refused (tried with YADE 2023.02a): in a
periodic cell a body longer than half the cell stops the collider, with ``allowBiggerThanPeriod`` a ``Wall``
hangs it at the second step, and a wall of small facets counts a sphere above an edge twice.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from exporters.protocol import Outlook
from exporters.shared import contact, deck, particulate, table
from exporters.shared.clumps import Clumps, clumps_of
from exporters.walls import facets as walls
from exporters.walls import parts as named
from exporters.walls.edges import edge_uses
from exporters.walls.stl import write_stl
from packgen.arrays import Float64Array, unique_rows
from packgen.bed import AnyBed, Bed
from packgen.errors import ExportError
from packgen.geometry import Container

NAME = "yade"
IS_DECK = True
STREAMS = True
CLUMPS = True
TIMESTEP_FRACTION = 0.1
# In the narrow tip of a cone a sphere touches a hundred facets at once, each of which pushes and damps: with
# fractions of 0.05 and more, a sphere between 193 of them was thrown out sooner or later.
FACETS_AT_ONCE = 25  # facets of a sphere that need no shorter time step; more shorten it in proportion
TOUCHING = 1.002  # radii; within that a facet counts as touched
DISTANCES_MAX = 20_000_000  # sphere-facet distances computed: of the lowest spheres, where hoppers end
DISTANCES_AT_A_TIME = 1_000_000
VERLET_SHARE = 0.2  # distance that spheres move before neighbours are sought again [smallest radii]


class Options(deck.DeckOptions):
    """Options of a YADE deck.

    Attributes:
        timestep_fraction: Time step as a fraction of the smallest Rayleigh time; None: 0.1, and less where
            a sphere touches many facets at once.
        steps: Steps of the run; None: 100 to 1000, fewer for larger beds.
    """

    timestep_fraction: float | None = Field(default=None, gt=0, le=0.5)
    steps: int | None = Field(default=None, ge=0)


def write(bed: AnyBed, folder: Path, options: Options) -> list[Path]:
    """Write the deck of a bed into an existing folder and return the paths of its files.

    Raises:
        ExportError: YADE cannot take the bed: it is empty, a material is outside the limits, or the box
            wraps around along one or two of its axes only.
    """
    deck.check_exportable(bed, NAME, clumps=True)
    clumps = clumps_of(bed, NAME)
    _check_periodic(bed.container, min(bed.census.radius_min), max(bed.census.radius_max))
    has_wall = walls.has_wall(bed)
    types = contact.number_types(bed, has_wall=has_wall)
    particulate.check_materials(NAME, types.materials)
    planes, facets = _walls(bed.container) if has_wall else ([], np.zeros((0, 3, 3)))
    parts = named.parts_of(bed.container, angle_min=0.0)
    fraction = options.timestep_fraction
    if fraction is None:
        crowd = max(
            FACETS_AT_ONCE,
            facets_at_once(bed, np.concatenate([facets, *(each.facets.triangles for each in parts)])),
        )
        fraction = float(f"{TIMESTEP_FRACTION * FACETS_AT_ONCE / crowd:.2g}")
    values = particulate.common_values(bed, types, timestep_fraction=fraction, steps=options.steps)
    values |= _material_values(bed, types)
    values |= {
        "facets": len(facets) > 0,
        "planes": planes,
        "parts": _part_values(parts, types),
        "rolling": rolling(bed, types),
        "periodic": (bed.container.bounds[1] - bed.container.bounds[0]).tolist() if not has_wall else [],
        "gravity_vector": bed.acceleration.tolist(),
        "verlet_distance": VERLET_SHARE * values["radius_min"],
        "clumps": None if clumps is None else {"count": clumps.count, "reach": clumps.reach},
    }
    paths = [deck.write_text(folder / "bed.py", deck.render("yade/bed.py.j2", values, options.templates))]
    paths += _write_spheres(bed, folder, clumps)
    if len(facets):
        paths.append(write_stl(folder / "wall.stl", facets))
    return paths + [write_stl(folder / each.file, each.facets.triangles) for each in parts]


def _write_spheres(bed: AnyBed, folder: Path, clumps: Clumps | None) -> list[Path]:
    """Write ``bed.txt``, and ``clumps.txt`` where there are clumps."""
    if clumps is None:
        rows = ([*chunk.position.T, chunk.radius, chunk.set_index] for chunk in bed.chunks())
        return [table.write_parts(folder / "bed.txt", rows, head="#format x_y_z_r_matId\n")]
    assert isinstance(bed, Bed)
    assert bed.body_index is not None
    columns = [*clumps.member.T, bed.radius, bed.body_index, bed.set_index]
    spheres = table.write_rows(folder / "bed.txt", columns, head="#format x_y_z_r_clumpId\n")
    moments, axes = np.linalg.eigh(clumps.inertia)  # rising moments, axes as columns
    bodies = [clumps.row, clumps.mass, *clumps.position.T, *moments.T, *axes[:, :, 0].T, *axes[:, :, 1].T]
    head = "# body mass x y z I1 I2 I3 axis1 (x y z) axis2 (x y z)\n"
    return [spheres, table.write_rows(folder / "clumps.txt", bodies, head=head)]


def check_outlook(outlook: Outlook, options: Options) -> None:
    """Refuse a scene whose beds YADE cannot take.

    Raises:
        ExportError: A material is outside the limits, the box wraps around along one or two of its axes only
            or after too short a way, or the user's folder of templates does not exist.
    """
    deck.check_templates(options.templates)
    with outlook.placed("container", "periodic"):
        # The bed's largest sphere has at least this radius. Limits of larger spheres are left to ``write``.
        _check_periodic(outlook.container, outlook.radius_min, outlook.radius_min)
    particulate.check_materials(NAME, outlook.materials, place=outlook.place)


def _check_periodic(container: Container, radius_min: float, radius_max: float) -> None:
    """Refuse a box that wraps around along one or two of its axes only, or after too short a way.

    Args:
        container: The container.
        radius_min: Smallest radius of the spheres [m].
        radius_max: Largest one [m].

    Raises:
        ExportError: The box wraps around so.
    """
    if not any(container.periodic):
        return
    if not all(container.periodic):
        raise ExportError(
            "yade: the box wraps around along some axes only, YADE along all or none; export it for liggghts"
            " or lammps, or give `periodic: [x, y, z]`"
        )
    size = float((container.bounds[1] - container.bounds[0]).min())
    least = 4 * (radius_max + VERLET_SHARE * radius_min)
    if size <= least:
        raise ExportError(
            f"yade: the box wraps around after {size:g} m, YADE's spheres of {radius_max:g} m want more than"
            f" {least:g} m; enlarge the box"
        )


def _material_values(bed: AnyBed, types: contact.Types) -> dict[str, Any]:
    """Return a material for each particle set, since YADE's have the density, and for parts and walls."""
    wall = types.materials[types.wall - 1]
    of_set = [types.materials[max(1, number) - 1] for number in types.by_set]
    of_part = [types.materials[number - 1] for number in types.by_part]
    each = [*of_set, *of_part, wall]
    names = [
        *(f"set {one.name}, material {one.material}" for one in bed.particle_sets),
        *(f"wall {one.name}, material {one.material}" for one in bed.container.parts),
        f"walls, {wall.name}",
    ]
    like = bed.particle_sets[0].density  # walls have no weight, and every material a density
    densities = [*(one.density for one in bed.particle_sets), *(like for _ in of_part), like]
    angles = contact.pair_matrix([one.friction for one in each])
    return {
        "materials": [
            {
                "name": deck.comment_text(name),
                "young": one.youngs_modulus,
                "poisson": one.poissons_ratio,
                "density": density,
                "angle": float(np.arctan(one.friction)),
            }
            for name, one, density in zip(names, each, densities, strict=True)
        ],
        "restitution": contact.pair_matrix([one.restitution for one in each]),
        "friction": np.arctan(angles).tolist(),
    }


def _part_values(parts: tuple[named.DeckPart, ...], types: contact.Types) -> list[dict[str, Any]]:
    """Return the named parts of the walls as the template places them."""
    return [
        {
            "name": each.part.name,
            "file": each.file,
            "material": len(types.by_set) + number,
            "remove": each.part.remove,
            "motion": None if each.part.motion is None else named.motion_values(each.part.motion),
        }
        for number, each in enumerate(parts)
    ]


def rolling(bed: AnyBed, types: contact.Types) -> dict[str, float] | None:
    """Return YADE's coefficient and stiffness [N m] of rolling; None where no material rolls with friction.

    Where the materials differ, the coefficient is the mean over all pairs of spheres.
    """
    tables = contact.pair_matrix([each.rolling_friction for each in types.materials])
    counts = np.zeros(len(types.materials))
    for number, count in zip(types.by_set, bed.census.counts, strict=True):
        counts[number - 1] += count
    share = counts / bed.count
    mean = float(share @ np.array(tables) @ share)
    if not any(each.rolling_friction > 0 for each in types.materials):
        return None
    most = types.materials[int(share.argmax())]
    stiffness = contact.rolling_stiffness(bed, *contact.effective_moduli(most, most))
    effective_radius = bed.census.radius_mean / 2
    return {"coefficient": mean / 2, "stiffness": stiffness * effective_radius**2}


def _walls(container: Container) -> tuple[list[tuple[int, float]], Float64Array]:
    """Return the planes (axis, position), and the corners [m] of the facets that lie on none, (F, 3, 3)."""
    # YADE takes narrow facets, and counts the edges of wider ones twice.
    triangles = walls.wall_facets(named.body_of(container), angle_min=0.0).triangles
    low, high = named.reach_of_motions(container)
    planes = [
        (axis, position) for axis, position in flat_walls(triangles) if not low[axis] < position < high[axis]
    ]
    on_plane = np.zeros(len(triangles), dtype=bool)
    for axis, position in planes:
        on_plane |= (triangles[:, :, axis] == position).all(axis=1)
    return planes, triangles[~on_plane]


def facets_at_once(bed: AnyBed, facets: Float64Array) -> int:
    """Return the largest number of facets that one sphere touches: plane and box of each reach it.

    Args:
        bed: The bed; only the lowest spheres of a large one count.
        facets: Corners of the facets [m], shape (F, 3, 3), float64.
    """
    if len(facets) == 0:
        return 0
    centres, radii = _lowest(bed, max(1, DISTANCES_MAX // len(facets)))
    normal = np.cross(facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    offset = np.einsum("ij,ij->i", normal, facets[:, 0])
    low, high = facets.min(axis=1), facets.max(axis=1)
    most, step = 0, max(1, DISTANCES_AT_A_TIME // len(facets))
    for start in range(0, len(radii), step):
        position, reach = centres[start : start + step], TOUCHING * radii[start : start + step, None]
        touched = np.abs(position @ normal.T - offset) <= reach
        for axis in range(3):
            along = position[:, axis, None]
            touched &= (along >= low[:, axis] - reach) & (along <= high[:, axis] + reach)
        most = max(most, int(touched.sum(axis=1).max()))
    return most


def _lowest(bed: AnyBed, count: int) -> tuple[Float64Array, Float64Array]:
    """Return centres [m], (n, 3), and radii [m], (n,), of the lowest spheres, at most so many."""
    position, radius = np.zeros((0, 3)), np.zeros(0)
    for chunk in bed.chunks():
        position, radius = np.concatenate([position, chunk.position]), np.append(radius, chunk.radius)
        lowest = np.argsort(-position @ bed.gravity, kind="stable")[:count]
        position, radius = position[lowest], radius[lowest]
    return position, radius


def flat_walls(triangles: Float64Array) -> list[tuple[int, float]]:
    """Return the planes (axis, position) that bound the container across x, y or z and are closed walls.

    Such a plane may be infinite: nothing of the container is beyond it. A rim around an open top does not
    count.

    Args:
        triangles: Corners of the facets [m], shape (F, 3, 3), float64.
    """
    corners = triangles.reshape(-1, 3)
    place, corner = unique_rows(corners)
    vertices, is_open = corners[place], (edge_uses(corner.reshape(-1, 3)) == 1).any(axis=1)
    planes = []
    for axis in range(3):
        for position in (vertices[:, axis].min(), vertices[:, axis].max()):
            there = (triangles[:, :, axis] == position).all(axis=1)
            if there.any() and not (is_open & there).any():
                planes.append((axis, float(position)))
    return planes
