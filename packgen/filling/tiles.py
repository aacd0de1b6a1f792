"""Whether a scene's bed is divided into tiles: by its own settings, or as several processes work on it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from packgen.arrange.traits import traits_of
from packgen.errors import PackingError
from packgen.filling.clumps import has_clumps

if TYPE_CHECKING:
    from packgen.scene import Scene

REMEDY = "leave --workers, --scheduler and params.tile out"


def in_tiles(scene: Scene, *, shared: bool) -> Scene:
    """Return the scene as it is packed.

    Args:
        scene: The scene.
        shared: Whether several processes work on it: it has tiles then, as wide as it or its vessel says.

    Raises:
        PackingError: Its algorithm knows no tiles.
    """
    params = scene.params
    tile, instead = getattr(params, "tile", None), traits_of(params).instead
    if not shared and tile is None:
        return scene
    if not hasattr(params, "tile") or instead is not None:
        name = instead or scene.algorithm
        raise PackingError(
            f"{scene.named('algorithm')}: not supported yet with --workers, --scheduler or "
            f"params.tile: found {name}, expected COLLECTIVE_ARRANGEMENT by projection; {REMEDY}"
        )
    if has_clumps(scene):
        index = next(k for k, each in enumerate(scene.particle_sets) if each.form is not None)
        place = scene.named(f"particle_sets[{index}].shape")
        raise PackingError(
            f"{place}: found a clump, expected none: not supported yet "
            f"with --workers, --scheduler or params.tile; {REMEDY}"
        )
    if tile is not None:
        return scene
    return replace(scene, params=params.model_copy(update={"tile": "auto"}))
