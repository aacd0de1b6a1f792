"""Lethe (lethe-particles): ``particles_0.input``, ... for the insertion method ``file``, and ``bed.prm``.

A file a particle set, in the order of Lethe's particle types: a head of column names and a row a sphere, all
with semicolons. ``bed.prm`` has the subsections that go with them, insertion info and Lagrangian physical
properties, to be copied into the case's parameter file: Lethe inserts one type after the other, a file each
insertion. For CFD-DEM let lethe-particles write a checkpoint.

Reference: Lethe documentation, pages "Insertion Info" and "Lagrangian Physical Properties", and its source,
``insertion_file.cc``: columns are found by name; densities are those of the particle types.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from exporters.shared import deck, table
from packgen.bed import Bed, Material

NAME = "lethe"
NEEDS = ("density", "materials")
MOTION = ("v_x", "v_y", "v_z", "w_x", "w_y", "w_z")
FLUID = tuple(f"fem_{what}_{axis}" for what in ("force", "torque") for axis in "xyz")  # read by CFD-DEM alone


class Options(BaseModel):
    """Options of the files.

    Attributes:
        temperature: Temperature of all spheres [K], for heat transfer; None: no column of it.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    temperature: float | None = Field(default=None, gt=0)


def write(bed: Bed, folder: Path, options: Options) -> list[Path]:
    """Write the files into an existing folder and return their paths.

    Raises:
        ExportError: The bed is empty, or a number in it is not finite.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    used = [index for index in range(len(bed.particle_sets)) if (bed.set_index == index).any()]
    paths = [
        _write_set(bed, index, folder / f"particles_{place}.input", options)
        for place, index in enumerate(used)
    ]
    return [
        *paths,
        deck.write_text(folder / "bed.prm", _parameters(bed, used, [path.name for path in paths])),
    ]


def _write_set(bed: Bed, index: int, path: Path, options: Options) -> Path:
    chosen = bed.set_index == index
    zero = np.broadcast_to(np.int64(0), (int(chosen.sum()),))
    names = ["p_x", "p_y", "p_z", *MOTION, "diameters", *FLUID]
    columns = [*bed.position[chosen].T, *[zero] * 6, 2 * bed.radius[chosen], *[zero] * 6]
    if options.temperature is not None:
        names.append("T")
        columns.append(np.broadcast_to(options.temperature, zero.shape))
    columns.append(np.broadcast_to("", zero.shape))  # a semicolon at the end of each row
    return table.write_rows(path, columns, head="; ".join(names) + ";\n", separator="; ")


def _parameters(bed: Bed, used: list[int], files: list[str]) -> str:
    material = {each.name: each for each in bed.materials}
    told = deck.provenance_values(bed)
    lines = [
        f"# {bed.count} spheres, packgen {told['version']}, scene {told['scene']}, seed {told['seed']}",
        "subsection insertion info",
        "  set insertion method    = file",
        "  set insertion frequency = 1",
        f"  set list of input files = {', '.join(files)}",
        "end",
        "subsection lagrangian physical properties",
        *(f"  set g{axis} = {value!r}" for axis, value in zip("xyz", bed.acceleration.tolist(), strict=True)),
        f"  set number of particle types = {len(used)}",
    ]
    for place, index in enumerate(used):
        each = bed.particle_sets[index]
        lines += _particle_type(bed, index, place, each.density, material[each.material])
    wall = material.get(bed.wall_material)
    if wall is not None:
        lines += _properties("wall", wall, "  ")
    return "\n".join([*lines, "end", ""])


def _particle_type(bed: Bed, index: int, place: int, density: float, material: Material) -> list[str]:
    radius = bed.radius[bed.set_index == index]
    return [
        f"  subsection particle type {place}",
        f"    # {deck.comment_text(bed.particle_sets[index].name)}, {deck.comment_text(material.name)}; "
        "diameters are those of the file, this is the largest",
        "    set size distribution type = uniform",
        f"    set diameter = {2 * float(radius.max())!r}",
        f"    set number of particles = {len(radius)}",
        f"    set density particles = {density!r}",
        *_properties("particles", material, "    "),
        "  end",
    ]


def _properties(what: str, material: Material, indent: str) -> list[str]:
    rows = (
        ("young modulus", material.youngs_modulus),
        ("poisson ratio", material.poissons_ratio),
        ("restitution coefficient", material.restitution),
        ("friction coefficient", material.friction),
        ("rolling friction", material.rolling_friction),
    )
    return [f"{indent}set {name} {what} = {value!r}" for name, value in rows]
