"""Scene file to ``Scene``: what the rest of packgen calls.

Example: ``load_scene(Path("furnace.yaml")).mark("zones[1].location.path")`` is ``"furnace.yaml:12:7"``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

from pydantic import BaseModel, ValidationError

from packgen.arrange.registry import DEFAULT, find, traits_of
from packgen.bed import Material
from packgen.errors import PackingError, SceneError
from packgen.scene.changes import Change, changed, parse_change, plain_data
from packgen.scene.checks import (
    across,
    algorithm_of,
    fill_proportions,
    of_amounts,
    of_free_sizes,
    of_start,
    ways_to_hold,
)
from packgen.scene.clumps import of_clumps
from packgen.scene.document import FreeParams, SceneFile, scene_file
from packgen.scene.faults import Fault, Said, faults_of, known_keys, lines_of
from packgen.scene.models import ContainerSpec, MaterialSpec, StartSpec, ValidationSpec, ZoneSpec
from packgen.scene.sets import SetKeys
from packgen.scene.walls import WallSpec
from packgen.scene.yamlmarks import MarkedData, path_location, read_yaml
from packgen.values import Unit3

__all__ = ["DEFAULT_MATERIAL", "Scene", "load_scene"]

DEFAULT_MATERIAL = "default"

NO_FILE = "scene"
"""What a scene that no file holds is called."""

TOLERANCE = 1.0e-6
"""Largest overlap of a bed whose algorithm has no tolerance, as a fraction of the smaller radius."""


@dataclass(frozen=True)
class Scene:
    """A scene, complete and valid; SI units.

    Attributes:
        path: The scene file.
        container: The container.
        gravity_direction: Unit vector along which spheres fall.
        gravity: Acceleration of gravity [m/s2]; 0 of an algorithm without gravity.
        seed: Seed of everything random.
        algorithm: Name of the algorithm.
        params: Settings of the algorithm, an instance of its own ``Params``; a mapping where it has none.
        tolerance: Largest overlap that its settings allow, as a fraction of the smaller radius; None: any.
        particle_sets: The sets, names and materials filled in; each with its ``distribution``.
        materials: Declared and used materials, defaults filled in.
        soft_materials: Names of the materials whose spheres may be squeezed out of shape.
        wall_material: Name of the walls' material.
        walls: Named parts of the walls, materials filled in.
        zones: The zones in the order of filling, proportions filled in.
        validation: Limits of a solver's verdict.
        start_from: A bed that is there before, its ``hold`` filled in; None: there is none.
    """

    path: Path
    container: ContainerSpec
    gravity_direction: Unit3
    gravity: float
    seed: int
    algorithm: str
    params: Any
    tolerance: float | None
    particle_sets: tuple[SetKeys, ...]
    materials: tuple[Material, ...]
    soft_materials: frozenset[str]
    wall_material: str
    walls: tuple[WallSpec, ...]
    zones: tuple[ZoneSpec, ...]
    validation: ValidationSpec
    marked: MarkedData = field(repr=False, compare=False)
    start_from: StartSpec | None = None

    def named(self, path: str) -> str:
        """Return ``file:line:column: path`` of a value such as ``zones[1].location``, each said once."""
        return self.marked.named(path_location(path))

    def mark(self, path: str) -> str:
        """Return ``file:line:column`` of a value such as ``zones[1].location``, or of what is around it."""
        return self.marked.place(path_location(path))

    def model_dump(self, *, mode: str = "json") -> dict[str, Any]:
        """Return everything that shaped the bed, defaults filled in, as plain data; mode as in pydantic."""
        own, start = isinstance(self.params, BaseModel), self.start_from
        walls = [each.model_dump(mode=mode, exclude_none=True) for each in self.walls]
        return {
            "container": self.container.model_dump(mode=mode, exclude_none=True),
            "gravity_direction": list(self.gravity_direction),
            "gravity": self.gravity,
            "seed": self.seed,
            "algorithm": self.algorithm,
            "params": self.params.model_dump(mode=mode) if own else dict(self.params),
            "particle_sets": [each.model_dump(mode=mode, exclude_none=True) for each in self.particle_sets],
            "materials": [asdict(each) for each in self.materials],
            "wall_material": self.wall_material,
            **({"walls": walls} if walls else {}),
            "zones": [each.model_dump(mode=mode, exclude_none=True) for each in self.zones],
            "validation": self.validation.model_dump(mode=mode),
        } | ({} if start is None else {"start_from": start.model_dump(mode=mode, exclude_none=True)})


def load_scene(source: Path | str | Mapping[str, Any], changes: Sequence[str | Change] = ()) -> Scene:
    """Read a scene file, or take what it would say.

    Args:
        source: The YAML file; paths in it start at its folder. Or its content as a mapping; paths in it
            start at the current folder.
        changes: Values in place of the scene's, each ``KEY=VALUE`` such as ``zones[0].n_particles=500``, the
            value as YAML.

    Returns:
        The scene.

    Raises:
        SceneError: The file cannot be read, or says what no scene can; all faults at once, one line each,
            ``file:line:column: path: found, expected``, or ``--set path: found, expected``.
    """
    path, marked = _document(source)
    marked, wrong = _changed(marked, changes)
    data = marked.data
    if not isinstance(data, dict):
        raise SceneError(
            lines_of([Fault((), data, "a mapping with the keys container and particle_sets")], marked)
        )
    model, unknown = _model(data)
    faults = across(data)
    data = data | {"params": {} if data.get("params") is None else data["params"]}
    try:
        document = model.model_validate(data, context={"folder": path.parent})
    except ValidationError as error:
        faults += faults_of(error, model, data)
        faults += _hidden_faults(data, faults, model, path.parent)
        raise SceneError([*wrong, *lines_of(_without_echoes(faults + unknown), marked)]) from error
    faults += unknown
    if not faults:
        zones = fill_proportions(document)
        algorithm = algorithm_of(document.algorithm, document.params)
        faults = of_free_sizes(document, zones)
        faults = faults or [
            *of_amounts(document, zones),
            *of_start(document),
            *of_clumps(document, algorithm),
        ]
    if faults or wrong:
        raise SceneError([*wrong, *lines_of(faults, marked)])
    return _scene(path, document, zones, marked)


def _document(source: Path | str | Mapping[str, Any]) -> tuple[Path, MarkedData]:
    """Return the path of a scene, and what it says."""
    if isinstance(source, Mapping):
        return Path(NO_FILE), MarkedData(NO_FILE, plain_data(source))
    return Path(source), read_yaml(Path(source), spell=_spell)


def _changed(marked: MarkedData, changes: Sequence[str | Change]) -> tuple[MarkedData, list[str]]:
    """Return a document with changes, and a line for each change that cannot be made."""
    made: list[Change] = []
    wrong: list[str] = []
    for each in changes:
        try:
            made.append(parse_change(each, spell=_spell) if isinstance(each, str) else each)
        except SceneError as error:
            wrong += error.problems
    marked, lost = changed(marked, made)
    return marked, wrong + lost


def _model(data: dict[str, Any]) -> tuple[type[SceneFile], list[Fault]]:
    """Return the model of a document, with its algorithm's settings, and the fault of a name unknown."""
    name = data.get("algorithm") or DEFAULT
    try:
        params = find(name).params if isinstance(name, str) else None
    except PackingError as error:
        return scene_file(FreeParams), [Fault(("algorithm",), name, str(error))]
    return scene_file(params or FreeParams), []


def free_params(params: FreeParams) -> Mapping[str, Any]:
    """Return settings without a model as the file has them."""
    given = params.model_dump()
    return MappingProxyType({name: given[name] for name in given if name in params.model_fields_set})


def _scene(path: Path, document: SceneFile, zones: tuple[ZoneSpec, ...], marked: MarkedData) -> Scene:
    """Fill in names and materials."""
    declared = document.materials
    default = next(iter(declared)) if len(declared) == 1 else DEFAULT_MATERIAL
    sets = tuple(
        each.model_copy(update={"name": each.name or f"set_{index}", "material": each.material or default})
        for index, each in enumerate(document.particle_sets)
    )
    set_materials = [each.material for each in sets]
    wall = document.wall_material or set_materials[0]
    walls = tuple(each.model_copy(update={"material": each.material or wall}) for each in document.walls)
    names = dict.fromkeys([*declared, *set_materials, wall, *(each.material or wall for each in walls)])
    return Scene(
        path=path,
        container=document.container,
        gravity_direction=document.gravity_axis,
        gravity=0.0 if traits_of(document.params).weightless else document.gravity,
        seed=document.seed,
        algorithm=document.algorithm,
        params=free_params(document.params) if isinstance(document.params, FreeParams) else document.params,
        tolerance=getattr(document.params, "tolerance", TOLERANCE),
        particle_sets=sets,
        materials=tuple(_material(name, declared.get(name)) for name in names),
        soft_materials=frozenset(
            name for name in names if document.allow_soft or (name in declared and declared[name].allow_soft)
        ),
        wall_material=wall,
        walls=walls,
        zones=zones,
        validation=document.validation,
        marked=marked,
        start_from=_start(document),
    )


def _start(document: SceneFile) -> StartSpec | None:
    """Return the bed that is there before, with the way in which the algorithm holds it."""
    start = document.start_from
    if start is None or start.hold is not None:
        return start
    usual, *_ = ways_to_hold(algorithm_of(document.algorithm, document.params))
    return start.model_copy(update={"hold": usual})


def _hidden_faults(
    data: dict[str, Any], faults: list[Fault], model: type[BaseModel], folder: Path
) -> list[Fault]:
    """Return what is wrong with sets and zones as wholes: a fault at one key keeps that from being seen."""
    faulty: dict[tuple[Any, ...], set[Any]] = {}
    for fault in faults:
        if len(fault.location) > 2:
            faulty.setdefault(fault.location[:2], set()).add(fault.location[2])
    cleaned = dict(data)
    for name in ("particle_sets", "zones", "walls"):
        if isinstance(data.get(name), list):
            cleaned[name] = [
                _without(each, faulty.get((name, i), set())) for i, each in enumerate(data[name])
            ]
    try:
        model.model_validate(cleaned, context={"folder": folder})
    except ValidationError as error:
        found = faults_of(error, model, cleaned)
        return [each for each in found if each.location[2:3] and _is_new(each, faulty)]
    return []


def _is_new(fault: Fault, faulty: dict[tuple[Any, ...], set[Any]]) -> bool:
    place = faulty.get(fault.location[:2])
    return place is not None and fault.location[2] not in place


def _without(values: Any, keys: set[Any]) -> Any:
    """Leave faulty keys out; lists get a stand-in, so that the others can be checked against them."""
    if not isinstance(values, dict):
        return values
    stand_ins = {key: _stand_in(values.get(key)) for key in keys}
    kept = {key: each for key, each in values.items() if key not in keys}
    return kept | {key: each for key, each in stand_ins.items() if each is not None}


def _stand_in(values: Any) -> list[float] | None:
    """Return numbers up to 1 that rise or fall as those of a list do; None where that cannot be told."""
    numbers = [each for each in values if isinstance(each, int | float)] if isinstance(values, list) else []
    if len(numbers) < 2 or numbers[0] == numbers[-1]:
        return None
    rising = [(place + 1) / len(values) for place in range(len(values))]
    return rising if numbers[0] < numbers[-1] else rising[::-1]


def _material(name: str, spec: MaterialSpec | None) -> Material:
    return Material(name, **(spec or MaterialSpec()).model_dump(exclude={"allow_soft"}))


def _without_echoes(faults: list[Fault]) -> list[Fault]:
    """Leave out a second fault at a place that is wrong already."""
    kept: dict[tuple[Any, ...], Fault] = {}
    for fault in faults:
        kept.setdefault((*fault.location, fault.found if isinstance(fault.found, Said) else ""), fault)
    return list(kept.values())


@cache
def _keys() -> frozenset[str]:
    return known_keys(scene_file(find(DEFAULT).params or FreeParams))


def _spell(key: str) -> str:
    """Return a key with underscores for blanks where that makes it one that scenes know.

    The paper's own example (Fig. 9) is printed with blanks in ``radius distribution`` and ``n particles``.
    """
    regular = key.replace(" ", "_")
    return regular if regular in _keys() else key
