"""The walls of a deck part by part: what has no name, and each named part with what becomes of it in the run.

What LIGGGHTS 3.8 and YADE do, and what follows (found by running them): LIGGGHTS keeps a mesh that a
``wall/gran`` refers to, so that this fix is made anew without a part that is removed. Facets of two meshes
are no neighbours: a sphere above the seam of two parts is pushed by both, within the overlaps of the bed.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np

from exporters.walls import facets as walls
from packgen.arrays import Float64Array
from packgen.errors import ExportError
from packgen.geometry import Container, Motion, Rotation, Surface, Translation, WallPart

BODY = "mesh"


@dataclass(frozen=True, eq=False, slots=True)
class DeckPart:
    """A named part of the walls as a deck has it.

    Attributes:
        part: The part.
        label: Its name in letters, digits and underscores, unlike every other one.
        facets: Its facets.
    """

    part: WallPart
    label: str
    facets: walls.Facets

    @property
    def file(self) -> str:
        """Name of the file of its facets."""
        return f"wall_{self.label}.stl"


def body_of(container: Container) -> Container:
    """Return a container whose surface is what has no name."""
    if not container.parts:
        return container
    return _with_faces(container, container.part_index < 0)


def parts_of(container: Container, *, angle_min: float = walls.FACET_ANGLE_MIN) -> tuple[DeckPart, ...]:
    """Return the named parts of a container's walls.

    Args:
        container: The container.
        angle_min: Facets with a smaller angle are too narrow for the solver [degrees].

    Raises:
        ExportError: A part has no facet that a solver takes.
    """
    index, found = container.part_index, []
    taken: set[str] = set()
    for number, part in enumerate(container.parts):
        facets = walls.wall_facets(_with_faces(container, index == number), angle_min=angle_min)
        if len(facets.triangles) == 0:
            raise ExportError(f"walls: no facet of {part.name} is usable; check its mesh and its units")
        label = re.sub(r"\W", "_", part.name)
        while label in taken:
            label += "_"
        taken.add(label)
        found.append(DeckPart(part, label, facets))
    return tuple(found)


def _with_faces(container: Container, chosen: np.ndarray) -> Container:
    surface = Surface(container.surface.vertices, container.surface.faces[chosen])
    return replace(container, surface=surface, parts=())


def motion_values(motion: Motion) -> dict[str, object]:
    """Return a motion as templates place it: its kind, and its vectors and times."""
    if isinstance(motion, Rotation):
        return {
            "kind": "rotate", "origin": motion.origin.tolist(), "axis": motion.axis.tolist(),
            "period": motion.period,
        }  # fmt: skip
    if isinstance(motion, Translation):
        speed = float(np.linalg.norm(motion.velocity))
        return {
            "kind": "linear", "velocity": motion.velocity.tolist(), "speed": speed,
            "direction": (motion.velocity / speed).tolist(),
        }  # fmt: skip
    return {"kind": "vibrate", "amplitude": motion.amplitude.tolist(), "period": motion.period}


def reach_of_motions(container: Container) -> Float64Array:
    """Return the lower and upper corner of what the walls may reach when they turn or swing [m], (2, 3).

    Walls that move along a line leave it sooner or later.
    """
    low, high = container.bounds[0].copy(), container.bounds[1].copy()
    for part in container.parts:
        corners = container.surface.vertices[np.unique(container.surface.faces[part.faces])]
        if isinstance(part.motion, Rotation):
            away = corners - part.motion.origin
            along = away @ part.motion.axis
            radius = np.linalg.norm(away - along[:, None] * part.motion.axis, axis=1)
            across = np.sqrt(np.maximum(1.0 - part.motion.axis**2, 0.0))
            centre = part.motion.origin + along[:, None] * part.motion.axis
            low = np.minimum(low, (centre - radius[:, None] * across).min(axis=0))
            high = np.maximum(high, (centre + radius[:, None] * across).max(axis=0))
        elif part.motion is not None and not isinstance(part.motion, Translation):
            low = np.minimum(low, (corners - np.abs(part.motion.amplitude)).min(axis=0))
            high = np.maximum(high, (corners + np.abs(part.motion.amplitude)).max(axis=0))
    return np.stack([low, high])
