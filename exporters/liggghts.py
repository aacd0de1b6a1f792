"""LIGGGHTS-PUBLIC 3.8: ``in.bed``, ``bed.data`` and ``wall.stl``; ``liggghts -in in.bed`` runs them.

Reference: LIGGGHTS manual, pages "read_data", "pair_style gran", "fix mesh/surface", "fix wall/gran". The
contact model is Hertz with tangential history, and the rolling model epsd2 where a material has rolling
friction. The input has two parts: the definitions, and the run (dumps, steps, restart). ``-var setup_only 1``
leaves the second out, so that another script can ``include`` the deck unedited; validation does just that.

Neighbours are listed by ``bin`` for every range of sizes: with ``multi`` Debian's LIGGGHTS 3.8.0 lists none
at all, and spheres fall through each other (found by running it).

Named parts of the walls are meshes of their own, each of its own material. They move in the deck's own run
alone, and those that are to be removed are there for ``steps``, and gone for ``steps_open`` more.

Where the walls are a mesh that is too small or too large for LIGGGHTS in metres, the deck is in another unit
of length and says so, see ``exporters.shared.lengths``.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field

from exporters.protocol import Outlook
from exporters.shared import contact, deck, lammps_data, lengths, particulate
from exporters.shared.clumps import clumps_of
from exporters.walls import crowding
from exporters.walls import facets as walls
from exporters.walls import parts as named
from exporters.walls.stl import write_stl
from packgen.bed import AnyBed
from packgen.errors import ExportError
from packgen.geometry import Container, Translation

NAME = "liggghts"
IS_DECK = True
STREAMS = True
CLUMPS = True
YOUNGS_MODULUS_SOFT = 5.0e6  # Pa; below, LIGGGHTS asks for "soft_particles yes"
YOUNGS_MODULUS_HARD = 1.0e9  # Pa; above, for "hard_particles yes"
RESTITUTION_MIN = 0.05  # LIGGGHTS takes values above it only


class Options(deck.DeckOptions):
    """Options of a LIGGGHTS deck.

    Attributes:
        walls: ``auto``: primitive walls for an axis-parallel box or cylinder, facets for all else; ``mesh``:
            facets.
        stl: ``ascii`` (double precision) or ``binary`` (single precision).
        curvature: Angle up to which facets are one smooth wall [degrees]; None: from the facets.
        timestep_fraction: Time step as a fraction of the smallest Rayleigh time.
        steps: Steps of the run; None: 100 to 1000, fewer for larger beds.
        dumps: Form of the dumps: ``text`` (LAMMPS) or ``vtk``.
    """

    walls: Literal["auto", "mesh"] = "auto"
    stl: Literal["ascii", "binary"] = "ascii"
    curvature: float | None = Field(default=None, gt=0, lt=60)
    timestep_fraction: float = Field(default=0.1, gt=0, le=0.5)
    steps: int | None = Field(default=None, ge=0)
    dumps: Literal["text", "vtk"] = "text"


def write(bed: AnyBed, folder: Path, options: Options) -> list[Path]:
    """Write the deck of a bed into an existing folder and return the paths of its files.

    Raises:
        ExportError: LIGGGHTS cannot take the bed: it is empty, or a material is outside the limits.
    """
    deck.check_exportable(bed, NAME, clumps=True)
    has_wall = walls.has_wall(bed)
    types = contact.number_types(bed, has_wall=has_wall)
    particulate.check_materials(NAME, types.materials, restitution_min=RESTITUTION_MIN)
    unit = length_unit(bed, options)
    bed = lengths.in_unit(bed, unit)
    facets = walls.wall_facets(bed.container) if has_wall else None
    values = _values(bed, types, facets, options) | lengths.unit_values(unit)
    clumps = clumps_of(bed, NAME)
    values |= lammps_data.clump_values(clumps, values)
    paths = [deck.write_text(folder / "in.bed", deck.render("liggghts/in.bed.j2", values, options.templates))]
    paths += lammps_data.write_spheres(bed, folder, types, _simulation_box(bed, facets), clumps, motion=False)
    if facets is not None:
        paths += _write_walls(bed.container, folder, binary=options.stl == "binary")
    return paths


def _write_walls(container: Container, folder: Path, *, binary: bool) -> list[Path]:
    """Write the facets of the walls, and of each of their named parts."""
    parts = named.parts_of(container)
    body = walls.wall_facets(named.body_of(container)).triangles
    files = [(each.file, each.facets.triangles) for each in parts]
    if len(body):
        files.insert(0, ("wall.stl", body))
    return [write_stl(folder / name, triangles, binary=binary) for name, triangles in files]


def deck_values(bed: AnyBed, options: Options) -> dict[str, Any]:
    """Return the values that LIGGGHTS' templates place, for decks built on LIGGGHTS' own and in SI units.

    Raises:
        ExportError: LIGGGHTS cannot take the bed.
    """
    has_wall = walls.has_wall(bed)
    types = contact.number_types(bed, has_wall=has_wall)
    return _values(bed, types, walls.wall_facets(bed.container) if has_wall else None, options)


def length_unit(bed: AnyBed | Outlook, options: Options) -> float:
    """Return the unit of length [m] of a bed's deck: 1, except for meshes that LIGGGHTS refuses then."""
    return lengths.mesh_unit(bed.container) if _has_mesh(bed, options) else 1.0


def check_outlook(outlook: Outlook, options: Options) -> None:
    """Refuse a scene whose beds LIGGGHTS cannot take.

    Raises:
        ExportError: A material is outside the limits, the container has no usable facet, too many facets
            meet, or the user's folder of templates does not exist.
    """
    deck.check_templates(options.templates)
    particulate.check_materials(NAME, outlook.materials, restitution_min=RESTITUTION_MIN, place=outlook.place)
    if _has_mesh(outlook, options):
        with outlook.placed("container"):
            _check_facets(walls.wall_facets(outlook.container))
            named.parts_of(outlook.container)


def _has_mesh(bed: AnyBed | Outlook, options: Options) -> bool:
    return walls.has_wall(bed) and _primitives(bed, options) is None


def _check_facets(facets: walls.Facets) -> None:
    if len(facets.triangles) == 0:
        raise ExportError(
            f"{NAME}: no facet of the container's surface is usable; check the mesh and its units"
        )


def _primitives(bed: AnyBed | Outlook, options: Options) -> tuple[walls.PrimitiveWall, ...] | None:
    return walls.primitive_walls(bed.container) if options.walls == "auto" else None


def _simulation_box(bed: AnyBed, facets: walls.Facets | None) -> lammps_data.Float64Array:
    open_top = facets is not None and facets.open_edges > 0
    return lammps_data.simulation_box(
        bed, open_top=open_top, walls=named.reach_of_motions(bed.container) if bed.container.parts else None
    )


def _values(
    bed: AnyBed, types: contact.Types, facets: walls.Facets | None, options: Options
) -> dict[str, Any]:
    """Return what the template places."""
    primitives = _primitives(bed, options)
    if facets is not None and primitives is None:
        _check_facets(facets)
    box = _simulation_box(bed, facets)
    values = particulate.common_values(
        bed, types, timestep_fraction=options.timestep_fraction, steps=options.steps
    )
    moduli = [each.youngs_modulus for each in types.materials]
    has_mesh = facets is not None and primitives is None
    body = facets if not bed.container.parts else walls.wall_facets(named.body_of(bed.container))
    mesh = _mesh_values(body, options) if has_mesh and body is not None and len(body.triangles) else None
    if mesh is not None and facets is not None:
        mesh["is_open"] = facets.open_edges > 0  # not where a part closes it
    parts = _part_values(bed.container, types, options) if has_mesh else []
    values |= lammps_data.box_values(bed, box)
    of_mesh = facets if primitives is None else None
    one, page = crowding.neighbor_room(of_mesh, values["radius_max"], values["skin"])
    return values | {
        "boundary": _boundary(values["boundary"], bed.container) if parts else values["boundary"],
        "neighbors_one": one,
        "neighbors_page": page,
        "soft": min(moduli) < YOUNGS_MODULUS_SOFT,
        "hard": max(moduli) > YOUNGS_MODULUS_HARD,
        "youngs_modulus": moduli,
        "poissons_ratio": [each.poissons_ratio for each in types.materials],
        "restitution": contact.pair_matrix([each.restitution for each in types.materials]),
        "friction": contact.pair_matrix([each.friction for each in types.materials]),
        "rolling_friction": contact.pair_matrix([each.rolling_friction for each in types.materials]),
        "rolling": any(each.rolling_friction > 0 for each in types.materials),
        "dumps": options.dumps,
        "primitives": primitives or (),
        "mesh": mesh,
        "parts": parts,
        "meshes": [*(["wall_mesh"] if mesh else []), *(each["fix"] for each in parts)],
        "meshes_left": [
            *(["wall_mesh"] if mesh else []),
            *(each["fix"] for each in parts if not each["remove"]),
        ],
        "removed": [each for each in parts if each["remove"]],
        "moving": [each for each in parts if each["motion"] is not None],
        "wall_folder": "",
        "clumps": None,
    }


def _boundary(styles: str, container: Container) -> str:
    """Return the styles of the box's sides: those that parts leave by moving along a line grow with them.

    LIGGGHTS stops where facets have left a fixed box.
    """
    velocity = [each.motion.velocity for each in container.parts if isinstance(each.motion, Translation)]
    along = np.array(velocity).reshape(-1, 3)
    grown = []
    for axis, style in enumerate(styles.split()):
        low, high = (along[:, axis] < 0).any(), (along[:, axis] > 0).any()
        grown.append(style if not (low or high) else ("m" if low else "f") + ("m" if high else "f"))
    return " ".join(grown)


def _part_values(container: Container, types: contact.Types, options: Options) -> list[dict[str, Any]]:
    return [
        _mesh_values(each.facets, options)
        | {
            "name": each.part.name,
            "fix": f"part_{each.label}",
            "file": each.file,
            "type": number,
            "remove": each.part.remove,
            "motion": None if each.part.motion is None else named.motion_values(each.part.motion),
        }
        for each, number in zip(named.parts_of(container), types.by_part, strict=True)
    ]


def _mesh_values(facets: walls.Facets, options: Options) -> dict[str, Any]:
    return {
        "count": len(facets.triangles),
        "dropped": facets.dropped,
        "is_open": facets.open_edges > 0,
        "curvature": facets.smooth_angle if options.curvature is None else options.curvature,
    }
