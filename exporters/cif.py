"""CIF: ``bed.cif``, the cell of a bed that is periodic all round, for VESTA, ASE, pymatgen and OVITO.

Reference: International Tables for Crystallography G, core dictionary. Space group P 1, a site a sphere, by
fractions of the cell's vectors. Programs take lengths for angstroms and sites for atoms: one largest radius
is written as one angstrom, and each particle set as an element, noble gases as a rule. The radii are in a
column of packgen's own, which other programs skip.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, field_validator

from exporters.protocol import Outlook
from exporters.shared import deck, table
from packgen.bed import AnyBed, Container, numbered
from packgen.errors import ExportError

NAME = "cif"
NEEDS: tuple[str, ...] = ()
STREAMS = True
CELLS = True
ELEMENTS = ("Ar", "Kr", "Xe", "Ne", "He", "Rn")


class Options(BaseModel):
    """Options of a CIF.

    Attributes:
        elements: Symbols of the elements that stand for the particle sets, with commas between.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    elements: tuple[str, ...] = ELEMENTS

    @field_validator("elements", mode="before")
    @classmethod
    def _split(cls, value: Any) -> Any:
        return tuple(each.strip() for each in value.split(",")) if isinstance(value, str) else value

    @field_validator("elements")
    @classmethod
    def _are_symbols(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        wrong = [each for each in value if not (each.isascii() and each.isalpha() and len(each) <= 2)]
        if wrong or not value:
            raise ValueError(f"expected symbols such as Na,Cl; {', '.join(wrong) or 'nothing'} is none")
        return value


def check_outlook(outlook: Outlook, options: Options) -> None:
    """Refuse containers that are not periodic all round, and sets without an element.

    Raises:
        ExportError: It is one, or they are more than the elements.
    """
    with outlook.placed("container"):
        _check_periodic(outlook.container)
    with outlook.placed("particle_sets"):
        _check_sets(len(outlook.particle_sets), options)


def write(bed: AnyBed, folder: Path, options: Options) -> list[Path]:
    """Write ``bed.cif`` into an existing folder and return its path.

    Raises:
        ExportError: The bed is empty, not periodic all round, or has more sets than there are elements.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    _check_periodic(bed.container)
    _check_sets(len(bed.particle_sets), options)
    unit = max(bed.census.radius_max)
    low, vectors = _frame(bed.container)
    inverse = np.linalg.inv(vectors)

    def parts() -> Iterator[list[NDArray[Any]]]:
        for start, chunk in numbered(bed):
            element = np.array(options.elements[: len(bed.particle_sets)])[chunk.set_index]
            place = np.mod((chunk.position - low) @ inverse, 1.0)
            place[place >= 1.0] = 0.0
            label = np.char.add(element, table.ids(chunk, start=start + 1).astype(str))
            yield [label, element, *place.T, np.ones(chunk.count, np.int64), chunk.radius / unit]

    return [table.write_parts(folder / "bed.cif", parts(), head=_head(bed, vectors / unit, unit, options))]


def _frame(container: Container) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the corner of a cell [m], shape (3,), and its vectors as rows [m], shape (3, 3)."""
    if container.cell is not None:
        return np.zeros(3), container.cell
    low, high = container.bounds
    return low, np.diag(high - low)


def _head(bed: AnyBed, vectors: NDArray[np.float64], unit: float, options: Options) -> str:
    told = deck.provenance_values(bed)
    a, b, c = np.linalg.norm(vectors, axis=1)
    cosines = [
        vectors[1] @ vectors[2] / b / c,
        vectors[0] @ vectors[2] / a / c,
        vectors[0] @ vectors[1] / a / b,
    ]
    alpha, beta, gamma = np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))
    sets = [
        f"# {options.elements[index]}: particle set {each.name}"
        for index, each in enumerate(bed.particle_sets)
    ]
    lines = [
        f"# {bed.count} spheres, packgen {told['version']}, scene {told['scene']}, seed {told['seed']}",
        f"# One angstrom is the largest radius, {unit!r} m.",
        *sets,
        "data_bed",
        *(f"_cell_length_{name} {float(each)!r}" for name, each in zip("abc", (a, b, c), strict=True)),
        f"_cell_angle_alpha {float(alpha)!r}",
        f"_cell_angle_beta {float(beta)!r}",
        f"_cell_angle_gamma {float(gamma)!r}",
        "_symmetry_space_group_name_H-M 'P 1'",
        "_symmetry_Int_Tables_number 1",
        f"_packgen_unit_of_length {unit!r}",
        "loop_",
        "_symmetry_equiv_pos_as_xyz",
        "'x, y, z'",
        "loop_",
        "_atom_site_label",
        "_atom_site_type_symbol",
        "_atom_site_fract_x",
        "_atom_site_fract_y",
        "_atom_site_fract_z",
        "_atom_site_occupancy",
        "_packgen_atom_site_radius",
    ]
    return "\n".join(lines) + "\n"


def _check_periodic(container: Container) -> None:
    if not all(container.periodic):
        raise ExportError(
            "cif: found a container with walls, expected a cell that repeats: a box with "
            "`periodic: [x, y, z]`, or `{cell: free}`"
        )


def _check_sets(count: int, options: Options) -> None:
    if count > len(options.elements):
        raise ExportError(
            f"cif: found {count} particle sets and {len(options.elements)} elements, expected an "
            "element a set; give --export-option cif.elements=Ar,Kr,..."
        )
