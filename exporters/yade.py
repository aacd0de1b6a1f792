"""YADE: ``bed.py``, ``bed.txt``, ``wall.stl``; ``yade -n -x bed.py`` runs them, ``yade bed.py`` shows them.

Reference: YADE manual, classes ``Ip2_FrictMat_FrictMat_MindlinPhys``, ``Law2_ScGeom_MindlinPhys_Mindlin``,
``Wall``, ``Facet``. The force of two spheres is LIGGGHTS' Hertz-Mindlin. Walls differ: YADE takes a facet for
a sphere of twice the radius of the sphere that touches it, which makes the wall's force sqrt(2/3) of
LIGGGHTS', and a sphere above the edge of two facets touches both. Flat walls across an axis are therefore
planes (``Wall``, a sphere of the same radius: sqrt(1/2)), see `flat_walls`. ``bed.txt`` has the columns
x y z r and the number of the particle set, which ``ymport.text`` reads too. Rolling friction is left out.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from exporters import contact, deck, particulate, table, walls
from packgen.bed import Bed, Material
from packgen.errors import ExportError

NAME = "yade"
VERLET_SHARE = 0.2  # of the smallest radius: how far spheres move before neighbours are looked for again


class Options(deck.DeckOptions):
    """What a user may choose of a YADE deck.

    Attributes:
        timestep_fraction: Time step as a fraction of the smallest Rayleigh time.
        steps: Steps of the run; None: 100 to 1000, fewer for larger beds.
    """

    timestep_fraction: float = Field(default=0.1, gt=0, le=0.5)
    steps: int | None = Field(default=None, ge=0)


def write(bed: Bed, folder: Path, options: Options) -> list[Path]:
    """Write the deck of a bed into an existing folder and return the paths of its files.

    Raises:
        ExportError: YADE cannot take the bed: it is empty, a material is outside the limits, or the box
            wraps around along one or two of its axes only.
    """
    deck.check_exportable(bed, NAME)
    if any(bed.container.periodic) and not all(bed.container.periodic):
        raise ExportError(
            "yade: the box wraps around along some axes only, YADE along all or none; export it for liggghts"
            " or lammps, or give `periodic: [x, y, z]`"
        )
    has_wall = walls.has_wall(bed)
    reach = float(bed.radius.max()) + VERLET_SHARE * float(bed.radius.min())
    size = bed.container.bounds[1] - bed.container.bounds[0]
    if not has_wall and size.min() <= 4 * reach:
        raise ExportError(
            f"yade: the box wraps around after {size.min():g} m, YADE's spheres of {bed.radius.max():g} m"
            f" want more than {4 * reach:g} m; enlarge the box"
        )
    types = contact.number_types(bed, has_wall=has_wall)
    check_materials(types.materials)
    values = particulate.common_values(
        bed, types, timestep_fraction=options.timestep_fraction, steps=options.steps
    )
    # YADE takes narrow facets, and counts the edges of wider ones twice.
    facets = walls.wall_facets(bed.container, angle_min=0.0) if has_wall else None
    values |= _material_values(bed, types)
    values |= {
        "facets": facets is not None,
        "planes": [] if facets is None else flat_walls(facets.triangles),
        "periodic": size.tolist() if not has_wall else [],
        "gravity_vector": bed.gravity.tolist(),
        "verlet_distance": VERLET_SHARE * values["radius_min"],
    }
    paths = [deck.write_text(folder / "bed.py", deck.render("yade/bed.py.j2", values, options.templates))]
    columns = [*bed.position.T, bed.radius, bed.set_index]
    paths.append(table.write_rows(folder / "bed.txt", columns, head="#format x_y_z_r_matId\n"))
    if facets is not None:
        paths.append(walls.write_stl(folder / "wall.stl", facets.triangles))
    return paths


def check_materials(materials: tuple[Material, ...]) -> None:
    """Refuse materials that YADE refuses, all at once.

    Raises:
        ExportError: A value is out of range; the message gives material, value and range.
    """
    particulate.check_materials(NAME, materials)


def _material_values(bed: Bed, types: contact.Types) -> dict[str, Any]:
    """Return a material for each particle set, since YADE's have the density, and one for the walls."""
    wall = types.materials[types.wall - 1]
    of_set = [types.materials[max(1, number) - 1] for number in types.by_set]
    each = [*of_set, wall]
    names = [
        *(f"set {one.name}, material {one.material}" for one in bed.particle_sets),
        f"walls, {wall.name}",
    ]
    densities = [*(one.density for one in bed.particle_sets), bed.particle_sets[0].density]
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


def flat_walls(triangles: walls.Float64Array) -> list[tuple[int, float]]:
    """Return the planes (axis, position) that bound the container across x, y or z and are closed walls.

    Such a plane may be infinite: nothing of the container is beyond it. A rim around an open top is none.

    Args:
        triangles: Corners of the facets [m], shape (F, 3, 3), float64.
    """
    corners = triangles.reshape(-1, 3)
    vertices, faces = np.unique(corners, axis=0, return_inverse=True)
    faces = faces.reshape(-1, 3)
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    _, inverse, use = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    is_open = (use[inverse.reshape(-1)] == 1).reshape(-1, 3).any(axis=1)
    planes = []
    for axis in range(3):
        for position in (vertices[:, axis].min(), vertices[:, axis].max()):
            there = (triangles[:, :, axis] == position).all(axis=1)
            if there.any() and not (is_open & there).any():
                planes.append((axis, float(position)))
    return planes
