"""What the decks of all DEM solvers need: checked materials, time step, length of the run, gravity."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from exporters.protocol import Place
from exporters.shared import contact, deck
from packgen.bed import AnyBed, Material
from packgen.errors import ExportError

SPHERE_STEPS = 1.0e8  # work of a deck's own run; it has 100 to 1000 steps
NEIGHBOR_BY_SIZE_RATIO = 3.0  # a wider range of radii gets neighbour lists by size


def check_materials(
    solver: str,
    materials: tuple[Material, ...],
    *,
    restitution_min: float = 0.0,
    place: Place | None = None,
) -> None:
    """Refuse materials that a solver refuses, all at once.

    Args:
        solver: What messages call it.
        materials: The materials.
        restitution_min: Restitution has to be above this.
        place: Returns ``file:line:column`` of a value; None: no scene is at hand.

    Raises:
        ExportError: A value is out of range; the message gives place, material, value and range.
    """
    lines = []
    for each in materials:
        for key, problem in _faults(each, restitution_min):
            before = "" if place is None else f"{place(('materials', each.name, key))}: "
            lines.append(f"{before}{solver}: materials.{deck.comment_text(each.name)}.{key}: {problem}")
    if lines:
        raise ExportError("\n".join(lines))


def _faults(material: Material, restitution_min: float) -> Iterator[tuple[str, str]]:
    """Yield the key of each value that is out of range, and what is wrong with it."""
    modulus, ratio, restitution = material.youngs_modulus, material.poissons_ratio, material.restitution
    if not (np.isfinite(modulus) and modulus > 0):
        yield "youngs_modulus", f"found {modulus} Pa, expected more than 0"
    if not 0 <= ratio <= 0.5:
        yield "poissons_ratio", f"found {ratio}, expected 0 to 0.5"
    if not restitution_min < restitution <= 1:
        yield "restitution", f"found {restitution}, expected above {restitution_min:g}, at most 1"
    for key in ("friction", "rolling_friction"):
        value = getattr(material, key)
        if not (np.isfinite(value) and value >= 0):
            yield key, f"found {value}, expected at least 0"


def common_values(
    bed: AnyBed, types: contact.Types, *, timestep_fraction: float, steps: int | None
) -> dict[str, Any]:
    """Return what every template places: provenance, sizes, types, gravity, time step and steps."""
    radius_min, radius_max = min(bed.census.radius_min), max(bed.census.radius_max)
    strength = float(np.linalg.norm(bed.acceleration))
    count = int(np.clip(SPHERE_STEPS / bed.count, 100, 1000)) if steps is None else steps
    return {
        **deck.provenance_values(bed),
        "sphere_count": bed.count,
        "radius_min": radius_min,
        "radius_max": radius_max,
        "type_names": [deck.comment_text(each.name) for each in types.materials],
        "wall_type": types.wall,
        "timestep": timestep_fraction * contact.smallest_rayleigh_time(bed),
        "timestep_fraction": timestep_fraction,
        "gravity": strength,
        "gravity_direction": (bed.acceleration / strength).tolist() if strength > 0 else [0.0, 0.0, 0.0],
        "endless": bed.endless,
        "steps": count,
        "dump_every": max(1, count // 10),
    }
