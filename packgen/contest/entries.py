"""Which runs a contest has: each algorithm with each seed, one seed of all before the next."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

from packgen.arrange.registry import find, names
from packgen.errors import PackgenError, PackingError
from packgen.sweep.over import Run

if TYPE_CHECKING:
    from packgen.scene import Scene

__all__ = ["OPTION", "entries", "known_algorithms"]

OPTION = "--algorithms"


def known_algorithms(asked: Sequence[str]) -> tuple[str, ...]:
    """Return the algorithms that are asked for, each once; all that there are where none is.

    Raises:
        PackgenError: There is none of some name; a line each.
    """
    faults = []
    for name in asked:
        try:
            find(name)
        except PackingError as error:
            faults.append(f"{OPTION}: found {name!r}, expected {error}")
    if faults:
        raise PackgenError("\n".join(faults))
    return tuple(dict.fromkeys(asked)) or names()


def entries(scene: Scene, algorithms: Sequence[str], seeds: int) -> list[Run]:
    """Return the runs of a contest.

    The scene's own algorithm keeps its settings. Another one has its own defaults, and the scene's tolerance.

    Args:
        scene: The scene.
        algorithms: Their names.
        seeds: How many seeds, from the scene's on.
    """
    return [
        Run(
            f"{re.sub(r'[^A-Za-z0-9_.+-]+', '-', name)}_seed={seed}",
            {"algorithm": name, "seed": str(seed)},
            {} if name == scene.algorithm else {"params": _params(scene, name)},
            OPTION,
        )
        for seed in range(scene.seed, scene.seed + seeds)
        for name in algorithms
    ]


def _params(scene: Scene, name: str) -> str:
    """Return the settings of another algorithm than the scene's, as YAML."""
    model = find(name).params
    if model is None or "tolerance" not in model.model_fields:
        return "{}"
    return f"{{tolerance: {'null' if scene.tolerance is None else repr(scene.tolerance)}}}"
