"""What an exporter offers, and what it is told of a bed before the run."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from packgen.arrays import Float64Array
from packgen.bed import Material, ParticleSet
from packgen.errors import ExportError
from packgen.geometry import Container

ALL_NEEDS = ("density", "materials", "walls")
Place = Callable[[tuple[str | int, ...]], str]


@dataclass(frozen=True, eq=False, slots=True)
class Outlook:
    """What is known of a bed before its first sphere is placed.

    Attributes:
        container: The vessel.
        gravity: Acceleration of gravity [m/s2], shape (3,).
        particle_sets: All sets, including those that no zone uses.
        materials: The materials of the sets that some zone uses, and of the walls where there are any.
        radius_min: Smallest radius that a sphere may have [m].
        radius_max: Largest radius that a sphere may have [m]; the bed need not have one of that size.
        place: Returns ``file:line:column`` of a value of the scene, or of what is around it, by its names and
            indices, such as ``("materials", "glass", "friction")``.
        wall_material: Name of the material of the walls, but for named parts of others.
        clumps: Whether some particles are rigid clumps of spheres.
    """

    container: Container
    gravity: Float64Array
    particle_sets: tuple[ParticleSet, ...]
    materials: tuple[Material, ...]
    radius_min: float
    radius_max: float
    place: Place
    wall_material: str = ""
    clumps: bool = False

    @contextmanager
    def placed(self, *location: str | int) -> Iterator[None]:
        """Put the place of a value of the scene before each line of an error that is raised inside.

        Raises:
            ExportError: The code inside raises one.
        """
        try:
            yield
        except ExportError as error:
            lines = (f"{self.place(location)}: {line}" for line in str(error).splitlines())
            raise ExportError("\n".join(lines)) from error


class Exporter(Protocol):
    """What a format's module offers; ``NAME``, ``Options`` and ``write`` are all that it must have.

    Attributes:
        NAME: Its name on the command line.
        Options: What a user may choose, made from the keys and texts of ``--export-option``.
        IS_DECK: Whether a solver runs what is written, with the bed's materials; False where it is left out.
        NEEDS: What it writes of a bed beside its spheres: ``density``, ``materials``, ``walls``; all three
            where it is left out. A bed that was read from a file may lack some.
        STREAMS: Whether ``write`` takes a bed in pieces as well, which has the attributes of
            `packgen.bed.AnyBed` and no arrays of all spheres; False where it is left out.
        CELLS: Whether it takes beds whose container is a periodic cell of any shape, `Container.cell`; False
            where it is left out: such beds are refused, in its name.
        CLUMPS: Whether ``write`` takes a bed whose ``bodies`` are rigid clumps of spheres; False where it is
            left out: such a bed is refused then.
    """

    NAME: str
    Options: type[Any]
    IS_DECK: bool
    NEEDS: tuple[str, ...]
    STREAMS: bool
    CELLS: bool
    CLUMPS: bool

    def check_outlook(self, outlook: Outlook, options: Any) -> None:
        """Refuse before the run what the format cannot take; where it is left out, nothing is refused.

        It is called once the container is loaded, before the first sphere is placed. It refuses only what is
        sure: what depends on the spheres is left to ``write``.

        Raises:
            ExportError: The format cannot take any bed of this scene; a line a reason.
        """
        ...

    def write(self, bed: Any, folder: Path, options: Any) -> list[Path]:
        """Write ``bed`` into ``folder``, an existing directory, and return the paths of the files.

        The bed is a `packgen.bed.Bed`, and with ``STREAMS`` anything that is a `packgen.bed.AnyBed`.

        Raises:
            ExportError: The format cannot take this bed.
        """
        ...
