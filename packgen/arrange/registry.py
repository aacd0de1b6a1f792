"""The algorithms by name: ours, and those that other packages add.

Each is a package with two modules: ``params`` has the pydantic model ``Params`` of the scene's ``params``,
``arrange`` the function ``arrange``, from a ``Task`` to ``Spheres``. Third parties add theirs through the
entry-point group ``packgen.algorithms``. The entry point's name is the name in the scene; its object is a
function, or anything with the attributes ``arrange`` and ``Params``, a module for example. A function without
``Params`` gets the scene's ``params`` as they are, as a mapping. A built-in one wins over a plug-in of the
same name.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from packgen.arrange.traits import Traits, traits_of
from packgen.errors import PackingError

if TYPE_CHECKING:  # a scene with a fault must not wait for numba
    from pydantic import BaseModel

    from packgen.arrange.task import Algorithm

__all__ = ["BUILTIN", "DEFAULT", "ENTRY_POINT_GROUP", "Registered", "Traits", "find", "names", "traits_of"]

ENTRY_POINT_GROUP = "packgen.algorithms"
DEFAULT = "COLLECTIVE_ARRANGEMENT"
BUILTIN = MappingProxyType(
    {
        DEFAULT: "packgen.arrange.collective",
        "ADAM": "packgen.arrange.adam",
        "DISPERSED": "packgen.arrange.dispersed",
        "JAMMED": "packgen.arrange.jammed",
        "OPTIMAL": "packgen.arrange.optimal",
        "SHRINKING_CELL": "packgen.arrange.shrinking_cell",
        "VOID_FILLING": "packgen.arrange.void_filling",
        "ADVANCING_FRONT": "packgen.arrange.advancing_front",
    }
)


@dataclass(frozen=True, slots=True)
class Registered:
    """An algorithm that can be asked for.

    Attributes:
        name: Its name in a scene.
        params: The model of its ``params``; None: it takes any.
    """

    name: str
    params: type[BaseModel] | None
    _plugin: Any = None

    def load(self) -> Algorithm:
        """Return the function that arranges."""
        if self._plugin is None:
            arrange: Algorithm = import_module(f"{BUILTIN[self.name]}.arrange").arrange
            return arrange
        function: Algorithm = getattr(self._plugin, "arrange", self._plugin)
        return function


def names() -> tuple[str, ...]:
    """Return the names of all algorithms, built-in ones first, then plug-ins in alphabetical order."""
    return (*BUILTIN, *sorted(set(_plugins()) - set(BUILTIN)))


def find(name: str) -> Registered:
    """Return an algorithm by name; what it needs to run is not yet loaded.

    Raises:
        PackingError: No algorithm has that name, or the plug-in that offers it cannot be loaded.
    """
    if name in BUILTIN:
        return Registered(name, import_module(f"{BUILTIN[name]}.params").Params)
    plugin = _plugins().get(name)
    if plugin is None:
        raise PackingError(f"one of {', '.join(names())}")
    try:
        loaded = plugin.load()
    except Exception as error:
        raise PackingError(f"a plug-in that loads; {plugin.value} does not: {error}") from error
    if not callable(getattr(loaded, "arrange", loaded)):
        raise PackingError(f"a plug-in with a function; {plugin.value} is none and has no arrange")
    return Registered(name, getattr(loaded, "Params", None), loaded)


def _plugins() -> dict[str, EntryPoint]:
    return {each.name: each for each in entry_points(group=ENTRY_POINT_GROUP)}
