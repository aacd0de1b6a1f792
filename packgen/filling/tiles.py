"""Whether a scene's bed is divided into tiles, by its own settings or because several processes work on it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from packgen.arrange.crew import Crew
from packgen.errors import PackingError

if TYPE_CHECKING:
    from packgen.scene import Scene

REMEDY = "leave --workers, --scheduler and params.tile out"


def in_tiles(scene: Scene, crew: Crew | None) -> Scene:
    """Return the scene whose bed a crew makes: it has tiles, those of its own or as wide as the vessel says.

    Args:
        scene: The scene.
        crew: Who does the work; None: this process alone, and without tiles unless the scene has them.

    Raises:
        PackingError: Its algorithm knows no tiles.
    """
    params = scene.params
    tile, instead = getattr(params, "tile", None), getattr(params, "instead", None)
    if crew is None and tile is None:
        return scene
    if not hasattr(params, "tile") or instead is not None:
        name = instead or scene.algorithm
        raise PackingError(
            f"{scene.mark('algorithm')}: algorithm: not supported yet with --workers, --scheduler or "
            f"params.tile: found {name}, expected COLLECTIVE_ARRANGEMENT by projection; {REMEDY}"
        )
    if tile is not None:
        return scene
    return replace(scene, params=params.model_copy(update={"tile": "auto"}))
