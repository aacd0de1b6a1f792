"""The exporters: one module a format, each with ``NAME``, ``Options`` and ``write(bed, folder, options)``.

A module may also have ``check_outlook(outlook, options)``, which refuses a scene before the run, and
``IS_DECK``, ``NEEDS``, ``STREAMS``, ``CELLS`` and ``CLUMPS``; see ``exporters.protocol``.

An exporter knows the bed, the shapes and the errors of packgen, nothing else of it. Third parties add one
through the entry-point group ``packgen.exporters``: the entry point's name is the name on the command line,
its object anything that has the attributes, a module for example. A built-in one wins over a plug-in of the
same name.

Example::

    exporter = exporters.get("liggghts")
    paths = exporter.write(bed, folder, exporter.Options())
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import MappingProxyType
from typing import Any, cast

from exporters.protocol import ALL_NEEDS, Exporter, Outlook
from packgen.errors import ExportError
from packgen.geometry import Container

__all__ = ["BUILTIN", "ENTRY_POINT_GROUP", "Exporter", "Outlook", "get", "names"]

ENTRY_POINT_GROUP = "packgen.exporters"
BUILTIN = MappingProxyType(
    {
        "liggghts": "exporters.liggghts",
        "lammps": "exporters.lammps",
        "yade": "exporters.yade",
        "vtk": "exporters.vtk",
        "csv": "exporters.csv",
        "cfdem": "exporters.cfdem",
        "fraction": "exporters.fraction",
        "surface": "exporters.surface",
        "mfix": "exporters.mfix",
        "mercury": "exporters.mercury",
        "esys": "exporters.esys",
        "kratos": "exporters.kratos",
        "geotaichi": "exporters.geotaichi",
        "chrono": "exporters.chrono",
        "extxyz": "exporters.extxyz",
        "cif": "exporters.cif",
        "lethe": "exporters.lethe",
        "phasicflow": "exporters.phasicflow",
        "serpent": "exporters.serpent",
        "openmc": "exporters.openmc",
        "voxels": "exporters.voxels",
        "bonds": "exporters.bonds",
        "bpm": "exporters.bpm",
    }
)


@dataclass(frozen=True, slots=True)
class _Complete:
    """An exporter with every attribute of the protocol."""

    NAME: str
    Options: type[Any]
    write: Callable[..., list[Path]]
    check_outlook: Callable[..., None]
    IS_DECK: bool
    NEEDS: tuple[str, ...]
    STREAMS: bool
    CELLS: bool
    CLUMPS: bool


def names() -> tuple[str, ...]:
    """Return the names of all exporters, built-in ones first, then plug-ins in alphabetical order."""
    return (*BUILTIN, *sorted(set(_plugins()) - set(BUILTIN)))


def get(name: str) -> Exporter:
    """Return the exporter called ``name``, complete: what it may leave out is filled in.

    Raises:
        ExportError: No exporter has that name, or the plug-in that offers it cannot be loaded.
    """
    if name in BUILTIN:
        return _completed(import_module(BUILTIN[name]))
    plugin = _plugins().get(name)
    if plugin is None:
        raise ExportError(f"export: no exporter is called {name!r}; there are {', '.join(names())}")
    try:
        exporter = plugin.load()
    except Exception as error:
        raise ExportError(f"export: the plug-in {name!r} ({plugin.value}) does not load: {error}") from error
    missing = [each for each in ("NAME", "Options", "write") if not hasattr(exporter, each)]
    if missing:
        raise ExportError(f"export: the plug-in {name!r} ({plugin.value}) has no {', '.join(missing)}")
    return _completed(exporter)


def _completed(exporter: Any) -> Exporter:
    check = getattr(exporter, "check_outlook", _accept)
    is_deck = bool(getattr(exporter, "IS_DECK", False))
    needs = tuple(getattr(exporter, "NEEDS", ALL_NEEDS))
    streams, cells, clumps = (bool(getattr(exporter, name, False)) for name in ("STREAMS", "CELLS", "CLUMPS"))
    write = exporter.write
    if not cells:
        check, write = _without_cells(exporter.NAME, check, write)
    return cast(
        "Exporter",
        _Complete(exporter.NAME, exporter.Options, write, check, is_deck, needs, streams, cells, clumps),
    )


def _without_cells(
    name: str, check: Callable[..., None], write: Callable[..., list[Path]]
) -> tuple[Callable[..., None], Callable[..., list[Path]]]:
    """Return a check and a writer that refuse periodic cells of any shape first."""

    def refuse(container: Container) -> None:
        if container.cell is not None:
            modules = {each: import_module(path) for each, path in BUILTIN.items()}
            known = ", ".join(each for each, module in modules.items() if getattr(module, "CELLS", False))
            raise ExportError(
                f"{name}: found a periodic cell whose edges are not along x, y and z, expected a box or "
                f"walls; take a format that knows such cells: {known}"
            )

    def check_first(outlook: Outlook, options: Any) -> None:
        with outlook.placed("container"):
            refuse(outlook.container)
        check(outlook, options)

    def write_after(bed: Any, folder: Path, options: Any) -> list[Path]:
        refuse(bed.container)
        return write(bed, folder, options)

    return check_first, write_after


def _accept(_outlook: Outlook, _options: Any) -> None:
    """Refuse nothing."""


def _plugins() -> dict[str, EntryPoint]:
    return {each.name: each for each in entry_points(group=ENTRY_POINT_GROUP)}
