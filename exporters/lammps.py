"""LAMMPS (package GRANULAR, 2021 and newer): ``in.bed`` and ``bed.data``; ``lmp -in in.bed`` runs them.

Reference: LAMMPS manual, pages "read_data", "pair_style granular", "fix wall/gran/region", "region". The
force is LIGGGHTS' Hertz-Mindlin: the stiffnesses are given as numbers (``hertz K``), not as moduli
(``hertz/material``), because the wall of LAMMPS 29 Sep 2021 takes E / (2 (1 - nu)) for the effective modulus,
(1 + nu) too much. ``damping tsuji`` has the form of LIGGGHTS' damping but, given the restitution, a factor
of sqrt(2) less of it: `tsuji_argument` gives the number that makes both equal. The ratio of tangential to
normal damping is sqrt(8 G / (2 Y)) in both. A curved wall has its curvature in the effective radius, which
LIGGGHTS leaves out.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from exporters.protocol import Outlook
from exporters.shared import contact, deck, lammps_data, particulate
from exporters.shared.clumps import clumps_of
from exporters.walls import facets as walls
from exporters.walls import lammps_parts as lammps_walls
from exporters.walls import parts as named
from packgen.bed import AnyBed

NAME = "lammps"
IS_DECK = True
STREAMS = True
CELLS = True
CLUMPS = True
NEIGHBORS_ONE = 2000  # most neighbours of a sphere, LAMMPS' default
TSUJI = np.array([4.8218, -18.022, 27.467, -22.348, 11.087, -4.2783, 1.2728])  # highest power first


class Options(deck.DeckOptions):
    """Options of a LAMMPS deck.

    Attributes:
        timestep_fraction: Time step as a fraction of the smallest Rayleigh time.
        steps: Steps of the run; None: 100 to 1000, fewer for larger beds.
    """

    timestep_fraction: float = Field(default=0.1, gt=0, le=0.5)
    steps: int | None = Field(default=None, ge=0)


def write(bed: AnyBed, folder: Path, options: Options) -> list[Path]:
    """Write the deck of a bed into an existing folder and return the paths of its files.

    Raises:
        ExportError: LAMMPS cannot take the bed: it is empty, a material is outside the limits, or the
            container is not convex.
    """
    deck.check_exportable(bed, NAME, clumps=True)
    types, box, values = deck_values(bed, options)
    values["bond_coeff"] = None
    clumps = clumps_of(bed, NAME)
    values |= lammps_data.clump_values(clumps, values)
    text = deck.render("lammps/in.bed.j2", values, options.templates)
    return [
        deck.write_text(folder / "in.bed", text),
        *lammps_data.write_spheres(bed, folder, types, box, clumps, motion=True),
    ]


def deck_values(
    bed: AnyBed, options: Options, solver: str = NAME
) -> tuple[contact.Types, lammps_data.Float64Array, dict[str, Any]]:
    """Return the types of a bed, the corners of the solver's box [m], and the values of the template.

    Args:
        bed: The bed.
        options: The options.
        solver: What messages call the format.

    Raises:
        ExportError: A material is outside the limits, or LAMMPS has no walls for the container.
    """
    has_wall = walls.has_wall(bed)
    types = contact.number_types(bed, has_wall=has_wall)
    particulate.check_materials(solver, types.materials)
    room = (
        lammps_walls.walls_of(bed.container, bed.wall_material) if has_wall else lammps_walls.Walls((), False)
    )
    box = lammps_data.simulation_box(
        bed,
        open_top=room.open_top,
        walls=named.reach_of_motions(bed.container) if bed.container.parts else None,
    )
    return types, box, _values(bed, types, box, options) | _wall_values(bed, types, room)


def check_outlook(outlook: Outlook, options: Options) -> None:
    """Refuse a scene whose beds LAMMPS cannot take.

    Raises:
        ExportError: A material is outside the limits, LAMMPS has no walls for the container, or the user's
            folder of templates does not exist.
    """
    deck.check_templates(options.templates)
    particulate.check_materials(NAME, outlook.materials, place=outlook.place)
    if walls.has_wall(outlook):
        with outlook.placed("walls" if outlook.container.parts else "container"):
            lammps_walls.walls_of(outlook.container, outlook.wall_material)


def _values(
    bed: AnyBed, types: contact.Types, box: lammps_data.Float64Array, options: Options
) -> dict[str, Any]:
    """Return the values that the template places, except those of the walls."""
    values = particulate.common_values(
        bed, types, timestep_fraction=options.timestep_fraction, steps=options.steps
    )
    radius_min, radius_max = values["radius_min"], values["radius_max"]
    ratio = radius_max / radius_min
    models = _models(bed, types)
    neighbors = max(NEIGHBORS_ONE, int((ratio + 2) ** 3))
    values |= lammps_data.box_values(bed, box)
    return values | {
        "clumps": None,
        "neighbor_style": "multi" if ratio > particulate.NEIGHBOR_BY_SIZE_RATIO else "bin",
        "size_intervals": _size_intervals(radius_min, radius_max),
        "neighbors_one": neighbors,
        "neighbors_page": 50 * neighbors,
        "rolling": any(each.rolling_friction > 0 for each in types.materials),
        "pairs": [
            {"first": first + 1, "second": second + 1, "model": models[first][second]}
            for first in range(len(types.materials))
            for second in range(first, len(types.materials))
        ],
    }


def _wall_values(bed: AnyBed, types: contact.Types, room: lammps_walls.Walls) -> dict[str, Any]:
    """Return the values of the walls and of their parts that the template places."""
    models = _models(bed, types)

    def fixes(label: str, wall: int) -> list[dict[str, Any]]:
        unlike = len({models[index][wall - 1] for index in range(len(types.materials))}) > 1
        return [
            {
                "name": f"{label}_{index + 1}",
                "group": f"type_{index + 1}" if unlike else "all",
                "model": models[index][wall - 1],
            }
            for index in range(len(types.materials) if unlike else 1)
        ]

    parts: list[dict[str, Any]] = []
    for each in room.blocks:
        motion = each.part.motion
        variables, moves = lammps_walls.motion_commands(motion, each.label) if motion else ((), "")
        parts.append(
            {
                "name": each.part.name,
                "region": f"part_{each.label}",
                "shape": each.region,
                "fixes": fixes(f"part_{each.label}", types.by_part[each.number]),
                "remove": each.part.remove,
                "variables": variables,
                "moves": moves,
            }
        )
    body = fixes("wall", types.wall) if room.commands else []
    groups = {fix["group"] for fix in [*body, *(fix for part in parts for fix in part["fixes"])]} - {"all"}
    return {
        "regions": room.commands,
        "wall_fixes": body,
        "parts": parts,
        "wall_groups": sorted(groups, key=lambda name: int(name.removeprefix("type_"))),
        "removed": [*room.removed, *(part["name"] for part in parts if part["remove"])],
        "opens": bool(room.removed),
        "regions_left": room.commands_left,
    }


def _size_intervals(radius_min: float, radius_max: float) -> list[float]:
    """Return the upper ends [m] of the size classes of neighbour lists, an octave of diameter each."""
    if radius_max <= particulate.NEIGHBOR_BY_SIZE_RATIO * radius_min:
        return []
    octaves = int(np.ceil(np.log2(radius_max / radius_min)))
    return [2.0 * radius_min * 2.0**k for k in range(1, octaves)] + [2.1 * radius_max]


def _models(bed: AnyBed, types: contact.Types) -> list[list[str]]:
    """Return the contact model of each pair of types as LAMMPS has it, a (T, T) table."""
    materials = types.materials
    tables = {
        name: contact.pair_matrix([getattr(each, name) for each in materials])
        for name in ("restitution", "friction", "rolling_friction")
    }
    rolling = any(each.rolling_friction > 0 for each in materials)

    def model(i: int, j: int) -> str:
        young, shear = contact.effective_moduli(materials[i], materials[j])
        text = (
            f"hertz {4 / 3 * young!r} {tsuji_argument(tables['restitution'][i][j])!r}"
            f" tangential mindlin {8 * shear!r} {float(np.sqrt(4 * shear / young))!r}"
            f" {tables['friction'][i][j]!r}"
        )
        if rolling:
            stiffness = contact.rolling_stiffness(bed, young, shear)
            text += f" rolling sds {stiffness!r} 0.0 {tables['rolling_friction'][i][j]!r}"
        return text + " damping tsuji"

    return [[model(i, j) for j in range(len(materials))] for i in range(len(materials))]


def tsuji_argument(restitution: float) -> float:
    """Return the restitution with which LAMMPS damps as LIGGGHTS does with the true one.

    LIGGGHTS: sqrt(5) beta sqrt(m K sqrt(R delta)) with beta = -ln e / sqrt(ln^2 e + pi^2), which is exact for
    Hertz' law (Antypov and Elliott, EPL 94 (2011) 50004); LAMMPS: alpha in place of sqrt(5) beta, with the
    polynomial alpha of its manual's page "pair_style granular". Below e = 0.12 alpha cannot be as large:
    0 is returned. For e = 1 the root of alpha is returned, just above 1.
    """
    logarithm = np.log(max(restitution, np.finfo(float).tiny))
    wanted = -np.sqrt(5) * logarithm / np.hypot(logarithm, np.pi)
    argument = np.linspace(0, 1, 2001)
    # alpha falls all the way; between the points of the table a few steps of Newton's rule.
    found = float(np.interp(-wanted, -np.polyval(TSUJI, argument), argument))
    for _ in range(20):
        found -= float((np.polyval(TSUJI, found) - wanted) / np.polyval(np.polyder(TSUJI), found))
    return max(found, 0.0)
