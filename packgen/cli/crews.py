"""The processes that share a run's work, and what is true of the run while they do."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from packgen.cli.ending import Ending
from packgen.cli.options import RunOptions
from packgen.stopping import tidied

GATHERED_MANY = 20_000_000  # spheres
GATHERED_BYTES = 400  # a sphere, with check and measures

if TYPE_CHECKING:  # a scene with a fault must not wait for numba
    from packgen.arrange.crew import Crew
    from packgen.scene import Scene
    from packgen.workers.parts import Parts


def gathering_remark(options: RunOptions, scene: Scene) -> str | None:
    """Return a line that tells of the memory that a very large bed of several processes takes in one."""
    count = sum(zone.n_particles or 0 for zone in scene.zones)
    if not options.shared or options.pieces or count <= GATHERED_MANY:
        return None
    return (
        f"found {count:,} spheres, which come together in this process by about "
        f"{count * GATHERED_BYTES / 1e9:.0f} GB; --pieces leaves them in pieces"
    )


@contextmanager
def parts_of(options: RunOptions) -> Iterator[Parts | None]:
    """Give the folder of the parts that a run leaves until its results are there; None: it leaves none.

    It is the run's own until the end, once it is opened.
    """
    if not options.shared:
        yield None
        return
    from packgen.workers.parts import Parts

    parts = Parts.beside(options.target)
    try:
        with tidied(parts.unlock):
            yield parts
    finally:
        parts.unlock()


@contextmanager
def crew_of(options: RunOptions, scene: Scene, parts: Parts | None, ending: Ending) -> Iterator[Crew | None]:
    """Give the processes that share a run's work; None: this one does all of it.

    Args:
        options: What the command line asks for.
        scene: The scene as it is packed.
        parts: Where they keep what they make.
        ending: Is told what is kept.

    Yields:
        The crew.

    Raises:
        PackgenError: Dask is not installed, its scheduler or its workers will not do, or the parts that are
            there are not to be gone on with.
    """
    if parts is None:
        yield None
        return
    from packgen.workers.cluster import local_cluster, remote_cluster

    parts.open(scene, resume=options.resume)
    claim, ending.claim = ending.claim, f"what is done is in {parts.folder}, --resume goes on with it"
    try:
        if options.scheduler is None:
            chosen = local_cluster(options.workers or 1, parts.folder, options.threads)
        else:
            chosen = remote_cluster(options.scheduler, parts.folder, options.threads)
        with chosen as crew:
            yield crew
    except BaseException:
        if not parts.begun:
            parts.remove()
            ending.claim = claim
        raise
