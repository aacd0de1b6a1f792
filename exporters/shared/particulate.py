"""What the decks of all DEM solvers need: checked materials, time step, length of the run, gravity."""

from __future__ import annotations

from typing import Any

import numpy as np

from exporters.shared import contact, deck
from packgen.bed import Bed, Material
from packgen.errors import ExportError

SPHERE_STEPS = 1.0e8  # work of a deck's own run; it has 100 to 1000 steps
NEIGHBOR_BY_SIZE_RATIO = 3.0  # a wider range of radii gets neighbour lists by size


def check_materials(solver: str, materials: tuple[Material, ...], *, restitution_min: float = 0.0) -> None:
    """Refuse materials that a solver refuses, all at once.

    Args:
        solver: What messages call it.
        materials: The materials.
        restitution_min: Restitution has to be above this.

    Raises:
        ExportError: A value is out of range; the message gives material, value and range.
    """
    problems = []
    for each in materials:
        name = deck.comment_text(each.name)
        if not (np.isfinite(each.youngs_modulus) and each.youngs_modulus > 0):
            problems.append(f"{name}.youngs_modulus: found {each.youngs_modulus} Pa, expected more than 0")
        if not 0 <= each.poissons_ratio <= 0.5:
            problems.append(f"{name}.poissons_ratio: found {each.poissons_ratio}, expected 0 to 0.5")
        if not restitution_min < each.restitution <= 1:
            problems.append(
                f"{name}.restitution: found {each.restitution}, expected above {restitution_min:g}, at most 1"
            )
        for key in ("friction", "rolling_friction"):
            value = getattr(each, key)
            if not (np.isfinite(value) and value >= 0):
                problems.append(f"{name}.{key}: found {value}, expected at least 0")
    if problems:
        raise ExportError("\n".join(f"{solver}: materials.{problem}" for problem in problems))


def common_values(
    bed: Bed, types: contact.Types, *, timestep_fraction: float, steps: int | None
) -> dict[str, Any]:
    """Return what every template places: provenance, sizes, types, gravity, time step and steps."""
    radius_min, radius_max = float(bed.radius.min()), float(bed.radius.max())
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
