"""A bed that wraps around, several times side by side."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from packgen.arrays import Float64Array, Int32Array, Int64Array
from packgen.bed import Bed
from packgen.bodies import Bodies, joined_rows
from packgen.check import near_pairs
from packgen.container.primitives import box_surface
from packgen.errors import GeometryError
from packgen.geometry import Box, Container
from packgen.geometry.cells import cell_container, into_cell, upright_cell
from packgen.part import Part
from packgen.reading.bed import wrapped
from packgen.reshape.bodies import bodies_beside, periods

SPHERES_MAX = 2**31 - 1
GAP = 1.0e-3  # largest gap of a contact, in smaller radii, as in the report


@dataclass(frozen=True, eq=False, slots=True)
class Repeated:
    """A bed of copies.

    Attributes:
        bed: The spheres, copy by copy; those of the first copy keep their index.
        contacts: Contacts of one copy that cross a seam between copies.
        seam_contacts: Contacts between spheres of different copies, gap `GAP` and less.
        worst_overlap: Largest overlap of these, as a fraction of the smaller radius; negative: a gap.
    """

    bed: Bed
    contacts: int
    seam_contacts: int
    worst_overlap: float


def repeat_bed(bed: Bed, counts: tuple[int, int, int]) -> Repeated:
    """Return a bed so many times along x, y, z.

    Args:
        bed: The bed; its container is a box that wraps around along each axis along which it is repeated, or
            a periodic cell of any shape.
        counts: Copies along x, y, z, or along the vectors of the cell, at least 1 each.

    Raises:
        GeometryError: It does not wrap around along such an axis, or there would be too many spheres.
    """
    _refuse_walls(bed.container, counts)
    total = int(np.prod(np.array(counts, dtype=object)))
    if total * bed.count > SPHERES_MAX:
        raise GeometryError(
            f"{' '.join(map(str, counts))}: found {total * bed.count:,} spheres, expected at most "
            f"{SPHERES_MAX:,}; give fewer copies"
        )
    cells = _cells(counts)
    vectors = bed.container.cell
    if vectors is None:
        vectors = np.diag([length or 0.0 for length in bed.container.period])
    moves = cells @ vectors
    # Known bodies are copied as wholes, so that their spheres stay in consecutive rows.
    start = bed.position if bed.bodies is None else bed.position + periods(bed) @ vectors
    placed = (start[None] + moves[:, None]).reshape(-1, 3)
    container = _container(bed.container, counts)
    if container.cell is not None:
        placed = into_cell(placed, container.cell)
    elif bed.bodies is not None:
        placed = wrapped(placed, container)
    copied = replace(
        bed,
        position=placed,
        radius=np.tile(bed.radius, total),
        set_index=np.tile(bed.set_index, total),
        zone_index=np.tile(bed.zone_index, total),
        batch_index=np.tile(bed.batch_index, total),
        body_index=_bodies(bed, cells, counts),
        bodies=_known_bodies(bed, start, moves),
        container=container,
    )
    crossing = sum(each.sum() for each in _crossings(bed, np.array(counts) > 1))
    seam_contacts, worst = _between_copies(copied, bed.count)
    provenance = _provenance(copied, bed, counts, seam_contacts)
    return Repeated(replace(copied, provenance=provenance), int(crossing), seam_contacts, worst)


def _refuse_walls(container: Container, counts: tuple[int, int, int]) -> None:
    walled = [
        f"{axis} (found {count})"
        for axis, count, wraps in zip("xyz", counts, container.periodic, strict=True)
        if count > 1 and not wraps
    ]
    if walled:
        wraps = ", ".join(axis for axis, each in zip("xyz", container.periodic, strict=True) if each)
        raise GeometryError(
            f"{' '.join(map(str, counts))}: the container of the bed has walls along {' and '.join(walled)}, "
            f"expected 1 there; it wraps around along {wraps or 'no axis'}"
        )


def _cells(counts: tuple[int, int, int]) -> Int64Array:
    """Return the place of each copy in whole periods along x, y, z, x fastest, shape (copies, 3), int64."""
    z, y, x = np.meshgrid(*(np.arange(count) for count in counts[::-1]), indexing="ij")
    return np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1).astype(np.int64)


def _bodies(bed: Bed, cells: Int64Array, counts: tuple[int, int, int]) -> Int32Array | None:
    """Return the body of each sphere, copy by copy; one that a seam tore apart hangs together again."""
    if bed.body_index is None:
        return None
    numbers, body = np.unique(bed.body_index, return_inverse=True)
    if bed.bodies is not None:
        whole = np.arange(len(cells))[:, None] * len(numbers) + body[None]
        return np.asarray(whole.reshape(-1), np.int32)
    # A member that is beside its body one period on belongs to the body of the copy before.
    owner = np.mod(cells[:, None] - periods(bed)[None], counts)
    copy = owner[..., 0] + counts[0] * (owner[..., 1] + counts[1] * owner[..., 2])
    joined: Int32Array = (copy * len(numbers) + body[None]).reshape(-1).astype(np.int32)
    return joined


def _known_bodies(bed: Bed, position: Float64Array, moves: Float64Array) -> Bodies | None:
    """Return the bodies of all copies, by the moves of these (copies, 3) [m]; None where none are known."""
    bodies = bodies_beside(bed, position)
    if bodies is None:
        return None
    return joined_rows([replace(bodies, position=bodies.position + move) for move in moves])


def _container(container: Container, counts: tuple[int, int, int]) -> Container:
    if container.cell is not None:
        vectors, _ = upright_cell(container.cell * np.array(counts)[:, None])
        return cell_container(vectors, container.name)
    low = container.bounds[0]
    size = (container.bounds[1] - low) * np.array(counts)
    box = Box(low, low + size)
    bounds = np.stack([low, low + size])
    return replace(container, shape=box, surface=box_surface(box), bounds=bounds, volume=float(np.prod(size)))


def _crossings(bed: Bed, axes: np.ndarray) -> list[np.ndarray]:
    """Return for the contacts of a bed, piece by piece, whether they cross a seam along one of some axes."""
    found = []
    if bed.container.cell is not None:
        part = Part.whole(bed)
        inverse = np.linalg.inv(bed.container.cell)
        for first, second, _ in _contacts(part):
            apart = part.bed.position[first] - part.bed.position[second]
            own = bed.position[part.name[first]] - bed.position[part.name[second]]
            found.append(((np.abs((apart - own) @ inverse) > 0.5) & axes).any(axis=1))
        return found
    lengths = np.array([length or np.inf for length in bed.container.period])
    for pairs in near_pairs(
        bed.position, bed.radius, gap_fraction=GAP, period=bed.container.period, body_index=bed.body_index
    ):
        apart = bed.position[pairs.first] - bed.position[pairs.second]
        found.append(((np.abs(apart) > 0.5 * lengths) & axes).any(axis=1))
    return found


def _between_copies(copied: Bed, count: int) -> tuple[int, float]:
    """Return how many contacts there are between copies of ``count`` spheres, and their largest overlap."""
    contacts, worst = 0, -np.inf
    part = Part.whole(copied)
    for first, second, gap in _contacts(part):
        one, other = part.name[first], part.name[second]
        seam = one // count != other // count
        contacts += int(np.count_nonzero(seam))
        if seam.any():
            smaller: Float64Array = np.minimum(copied.radius[one], copied.radius[other])
            worst = max(worst, float((-gap / smaller)[seam].max()))
    return contacts, worst


def _contacts(part: Part) -> Iterator[tuple[Int64Array, Int64Array, Float64Array]]:
    """Yield the contacts of a part: both spheres, and their gaps [m]."""
    bed = part.bed
    for pairs in near_pairs(
        bed.position, bed.radius, gap_fraction=GAP, period=bed.container.period, body_index=bed.body_index
    ):
        counted = part.counted(pairs.first, pairs.second)
        yield pairs.first[counted], pairs.second[counted], pairs.gap[counted]


def _provenance(copied: Bed, bed: Bed, counts: tuple[int, int, int], seam_contacts: int) -> dict[str, Any]:
    told: dict[str, Any] = dict(bed.provenance)
    told["repeated"] = {
        "counts": list(counts), "spheres_before": bed.count, "contacts_between_copies": seam_contacts
    }  # fmt: skip
    settings = told.get("settings")
    if copied.container.cell is None and isinstance(settings, Mapping) and "container" in settings:
        low, high = copied.container.bounds.tolist()
        box = {"box": {"min": low, "max": high}, "periodic": list(copied.container.periodic)}
        told["settings"] = {**settings, "container": box}
    return told
