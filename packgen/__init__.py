"""packgen: beds of spheres for DEM, from a scene file to a deck that the solver runs unedited.

What Python users call most is here, and is loaded on first use::

    from packgen import load_container, load_scene, pack

    scene = load_scene(Path("furnace.yaml"))
    bed = pack(scene, load_container(scene)).bed
"""

from __future__ import annotations

from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from packgen.version import __version__

if TYPE_CHECKING:
    from packgen.bed import Bed
    from packgen.check import check_bed
    from packgen.container import closed_mesh, load_container
    from packgen.errors import PackgenError
    from packgen.filling.pack import pack
    from packgen.reading import read_bed
    from packgen.report import build_report
    from packgen.reshape.carve import Cut, carve_bed
    from packgen.reshape.repeat import repeat_bed
    from packgen.scene import load_scene

__all__ = [
    "Bed", "Cut", "PackgenError", "__version__", "build_report", "carve_bed", "check_bed", "closed_mesh",
    "load_container", "load_scene", "pack", "read_bed", "repeat_bed",
]  # fmt: skip

_PLACES = MappingProxyType(
    {
        "Bed": "packgen.bed",
        "Cut": "packgen.reshape.carve",
        "PackgenError": "packgen.errors",
        "build_report": "packgen.report",
        "carve_bed": "packgen.reshape.carve",
        "check_bed": "packgen.check",
        "closed_mesh": "packgen.container",
        "load_container": "packgen.container",
        "load_scene": "packgen.scene",
        "pack": "packgen.filling.pack",
        "read_bed": "packgen.reading",
        "repeat_bed": "packgen.reshape.repeat",
    }
)


def __getattr__(name: str) -> Any:
    """Load one of the names above."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    # Not kept here: the name is always what its module has.
    return getattr(import_module(_PLACES[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
