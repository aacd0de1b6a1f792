"""What does not take particles that are clumps, yet: each by its own place in the scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from packgen.arrange.registry import BUILTIN, find, traits_of
from packgen.scene.faults import Fault, Said

if TYPE_CHECKING:
    from packgen.scene.document import SceneFile

__all__ = ["of_clumps"]


def of_clumps(document: SceneFile, algorithm: str) -> list[Fault]:
    """Return what a scene asks for beside clumps that nobody does with them.

    Args:
        document: The scene.
        algorithm: The algorithm that arranges.
    """
    shaped = [index for index, each in enumerate(document.particle_sets) if each.form is not None]
    if not shaped:
        return []
    faults = []
    if not _takes(algorithm):
        others = [each for each in BUILTIN if _takes(each)]
        expected = f"none: not supported yet by {algorithm}; leave it out, or take {' or '.join(others)}"
        faults = [
            Fault(("particle_sets", index, "shape"), Said("a clump"), expected, at_key=True)
            for index in shaped
        ]
    for index, zone in enumerate(document.zones):
        if zone.density_key is not None:
            found: Any = getattr(zone, zone.density_key).value
            expected = "none: not supported yet with clumps; friction decides how dense their bed is"
            faults.append(Fault(("zones", index, zone.density_key), found, expected))
    if document.start_from is not None:
        expected = "none: not supported yet with clumps; leave it out, or the shapes"
        faults.append(Fault(("start_from",), Said(document.start_from.path.name), expected))
    if getattr(document.params, "batch_size", None) is not None and _takes(algorithm):
        expected = "none: not supported yet with clumps, whose layers are as thick as they are"
        faults.append(Fault(("params", "batch_size"), document.params.batch_size, expected))
    return faults


def _takes(algorithm: str) -> bool:
    return traits_of(find(algorithm).params).takes_clumps
