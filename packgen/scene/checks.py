"""Faults that only several parts of a scene together can have.

``across`` looks at the plain data, so that its faults are shown together with those of single values;
``of_amounts`` needs the laws of size.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from packgen.arrange.registry import BUILTIN, DEFAULT, find, traits_of
from packgen.distributions import Free, Listed
from packgen.errors import PackingError
from packgen.scene.document import SceneFile
from packgen.scene.faults import Fault, Said
from packgen.scene.models import AMOUNTS, FRACTIONS, ZoneSpec
from packgen.scene.yamlmarks import Location
from packgen.supply.shares import expected_count, number_shares

__all__ = [
    "across", "algorithm_of", "fill_proportions", "of_amounts", "of_free_sizes", "of_start", "ways_to_hold",
]  # fmt: skip


def across(data: dict[str, Any]) -> list[Fault]:
    """Return the faults of references and counts between the sections of a document."""
    sets = _list(data.get("particle_sets"))
    faults = [*_materials(data), *_names(sets), *_walls(data)]
    count = len(sets)
    faults += [*_densities(data), *_cell(data)]
    for index, zone in enumerate(_list(data.get("zones"))):
        proportions = zone.get("set_proportions") if isinstance(zone, dict) else None
        if isinstance(proportions, list) and proportions and count and len(proportions) != count:
            expected = f"{count}, one for each of particle_sets"
            numbers = "1 number" if len(proportions) == 1 else f"{len(proportions)} numbers"
            faults.append(Fault(("zones", index, "set_proportions"), Said(numbers), expected))
    return faults


def _densities(data: dict[str, Any]) -> list[Fault]:
    """Return the fractions and gaps that the algorithm does not keep, and those beside an amount."""
    name = data.get("algorithm") or DEFAULT
    try:
        known = find(name).params if isinstance(name, str) else None
    except PackingError:
        return []
    traits = traits_of(known)
    faults = []
    for index, zone in enumerate(_list(data.get("zones"))):
        values = zone if isinstance(zone, dict) else {}
        given = [key for key in (*FRACTIONS, "gap") if values.get(key) is not None]
        amount = next((key for key in AMOUNTS if values.get(key) is not None), None)
        for key in given:
            place = ("zones", index, key)
            if key not in traits.zone_keys:
                expected = f"none: not supported yet by {name}; leave it out, or take `algorithm: DISPERSED`"
                faults.append(Fault(place, values[key], expected))
            elif amount is not None and key in FRACTIONS and not traits.compacts:
                expected = f"one of both: {name} spreads an amount over the whole zone; leave the other out"
                faults.append(Fault(place, Said(f"{key} beside {amount}"), expected))
    return faults


def _cell(data: dict[str, Any]) -> list[Fault]:
    """Return a free cell where the algorithm knows none, or another container where it needs one."""
    container, name = data.get("container"), data.get("algorithm") or DEFAULT
    if not isinstance(container, dict) or not isinstance(name, str):
        return []
    try:
        needed = traits_of(find(name).params).free_cell
    except PackingError:
        return []
    given = container.get("cell")
    if given is not None and not needed:
        expected = f"a container with {name}; take `algorithm: SHRINKING_CELL`, which finds the cell's shape"
        return [Fault(("container", "cell"), given, expected)]
    if needed and given is None and container:
        expected = f"{{cell: free}} with {name}, which finds the shape of a periodic cell"
        return [Fault(("container",), Said(next(iter(container))), expected)]
    return []


def _materials(data: dict[str, Any]) -> list[Fault]:
    """Return the materials that are used but not declared, where any are declared."""
    declared = data.get("materials")
    if not isinstance(declared, dict) or not declared:
        return []
    used: list[tuple[Location, Any]] = [
        (("particle_sets", index, "material"), each.get("material"))
        for index, each in enumerate(_list(data.get("particle_sets")))
        if isinstance(each, dict)
    ]
    used.append((("wall_material",), data.get("wall_material")))
    used += [
        (("walls", index, "material"), each.get("material"))
        for index, each in enumerate(_list(data.get("walls")))
        if isinstance(each, dict)
    ]
    expected = f"one of the materials: {', '.join(declared)}"
    return [
        Fault(place, name, expected) for place, name in used if isinstance(name, str) and name not in declared
    ]


def _names(sets: list[Any]) -> list[Fault]:
    """Return the names that two sets share; a set without a name is called by its number."""
    names = [
        each.get("name") or f"set_{index}" if isinstance(each, dict) else ""
        for index, each in enumerate(sets)
    ]
    texts = [name if isinstance(name, str) else "" for name in names]
    first = {name: index for index, name in reversed(list(enumerate(texts)))}
    return [
        Fault(("particle_sets", index, "name"), name, "a name that no other set has")
        for index, name in enumerate(texts)
        if name and first[name] < index
    ]


def _walls(data: dict[str, Any]) -> list[Fault]:
    """Return the names that two walls share, and the containers beside which no walls can be."""
    walls = [each if isinstance(each, dict) else {} for each in _list(data.get("walls"))]
    container = data.get("container")
    container = container if isinstance(container, dict) else {}
    faults: list[Fault] = []
    if walls and container.get("periodic"):
        expected = "a container that does not wrap around beside `walls`; leave one of both out"
        faults.append(Fault(("container", "periodic"), container["periodic"], expected))
    if walls and container.get("shape") == "convex_hull":
        expected = "mesh: a hull has no place for `walls`; leave one of both out"
        faults.append(Fault(("container", "shape"), "convex_hull", expected))
    seen: set[str] = set()
    for index, each in enumerate(walls):
        name = each.get("name")
        if isinstance(name, str) and name in seen:
            faults.append(Fault(("walls", index, "name"), name, "a name that no other wall has"))
        if each.get("path") is None and container.get("path") is None and container:
            expected = "this key and a mesh file: only a container with a `path` has parts by name"
            faults.append(Fault(("walls", index, "path"), Said("nothing"), expected, at_key=True))
        seen.add(name if isinstance(name, str) else "")
    return faults


def fill_proportions(document: SceneFile) -> tuple[ZoneSpec, ...]:
    """Return the zones with proportions that add up to 1.

    A zone that says none gets equal shares of all sets but those whose sizes are free, unless all are; where
    every set is a file of radii, shares that use each sphere once.
    """
    laws = [each.distribution for each in document.particle_sets]
    lists = [law.count for law in laws if isinstance(law, Listed)]
    equal = [float(count) for count in lists] if len(lists) == len(laws) else [1.0] * len(laws)
    if not all(isinstance(law, Free) for law in laws):
        equal = [0.0 if isinstance(law, Free) else share for law, share in zip(laws, equal, strict=True)]
    zones = []
    for zone in document.zones:
        by_list = not zone.set_proportions and len(lists) == len(laws)
        shares = list(zone.set_proportions) or equal
        total = sum(shares)
        update: dict[str, Any] = {"set_proportions": tuple(each / total for each in shares)}
        zones.append(zone.model_copy(update=update | ({"proportions_by": "number"} if by_list else {})))
    return tuple(zones)


def of_amounts(document: SceneFile, zones: tuple[ZoneSpec, ...]) -> list[Fault]:
    """Return the zones that ask for less than a sphere, or for more spheres than a file of radii has."""
    sets = document.particle_sets
    faults = _shared_files(sets, zones)
    for index, zone in enumerate(zones):
        count = expected_count(zone, sets)
        key = next((name for name in AMOUNTS if getattr(zone, name) is not None), "")
        if count is None:
            continue
        if count < 0.5:
            expected = "at least that of one sphere of mean size; check its unit and that of the radii"
            faults.append(Fault(("zones", index, key), getattr(zone, key), expected))
        for share, each in zip(number_shares(zone, sets), sets, strict=True):
            law = each.distribution
            if isinstance(law, Listed) and share * count > law.count + 0.5:
                expected = f"at most {law.count / share / count * getattr(zone, key):.6g}: "
                expected += f"the file of radii has {law.count} spheres"
                faults.append(Fault(("zones", index, key), getattr(zone, key), expected))
    return faults


def of_free_sizes(document: SceneFile, zones: tuple[ZoneSpec, ...]) -> list[Fault]:
    """Return the sets of free sizes that the algorithm does not size, and what zones cannot ask of them."""
    free = [isinstance(each.distribution, Free) for each in document.particle_sets]
    if not any(free):
        return []
    name, sized = document.algorithm, traits_of(document.params).free_sizes
    if sized is None:
        place = ("particle_sets", free.index(True), "radius_distribution")
        expected = f"a law of sizes: {name} sizes no spheres by their voids; take `algorithm: VOID_FILLING`"
        return [Fault(place, "free", f"{expected}, or the `fill` of ADVANCING_FRONT")]
    faults = []
    for index, zone in enumerate(zones):
        shares = [share for share, each in zip(zone.set_proportions, free, strict=True) if each and share > 0]
        place = ("zones", index, "set_proportions")
        said = Said(f"a share of {shares[0]:g} of a set of free sizes" if shares else "")
        if shares and sized == "fill":
            faults.append(Fault(place, said, f"a share of 0: `fill` of {name} places it; leave it out"))
        elif shares and max(shares) < 1.0:
            expected = "a zone of its own: it takes the voids that others leave; give it one after theirs"
            faults.append(Fault(place, said, expected))
        elif shares and (key := next((key for key in AMOUNTS[1:] if getattr(zone, key) is not None), None)):
            expected = "n_particles, or none: nobody knows sizes before; `params: {coverage: ...}` is a limit"
            faults.append(Fault(("zones", index, key), getattr(zone, key), expected))
    unused = [
        index
        for index, each in enumerate(free)
        if each and sized == "zones" and not any(zone.set_proportions[index] > 0.0 for zone in zones)
    ]
    expected = "one whose `set_proportions` give it all, after those of the other sets"
    faults += [Fault(("particle_sets", each), Said("no zone for free sizes"), expected) for each in unused]
    return faults


def of_start(document: SceneFile) -> list[Fault]:
    """Return what an algorithm cannot do with the bed that is there before."""
    start, algorithm = document.start_from, algorithm_of(document.algorithm, document.params)
    if start is None:
        return []
    ways = ways_to_hold(algorithm)
    if not ways:
        others = [each for each in BUILTIN if ways_to_hold(each)]
        expected = f"none: not supported yet by {algorithm}; leave it out, or take {' or '.join(others)}"
        return [Fault(("start_from",), Said(start.path.name), expected)]
    if start.hold is not None and start.hold not in ways:
        expected = f"{' or '.join(ways)}: {algorithm} moves no sphere that is there before"
        return [Fault(("start_from", "hold"), start.hold, expected)]
    return []


def algorithm_of(name: str, params: Any) -> str:
    """Return the name of the algorithm that arranges: settings may choose another one in its place."""
    return traits_of(params).instead or name


def ways_to_hold(algorithm: str) -> tuple[str, ...]:
    """Return how an algorithm can hold a bed that is there before, its usual way first; none: not at all."""
    return traits_of(find(algorithm).params).holds


def _shared_files(sets: Sequence[Any], zones: tuple[ZoneSpec, ...]) -> list[Fault]:
    """Return the files of radii that two zones would use: each of their spheres exists once."""
    faults = []
    for index, each in enumerate(sets):
        users = [place for place, zone in enumerate(zones) if zone.set_proportions[index] > 0.0]
        if isinstance(each.distribution, Listed) and len(users) > 1:
            said = Said(f"a file of radii used by {', '.join(f'zones[{place}]' for place in users)}")
            expected = "one zone: each of its spheres exists once; split the file, a set for each zone"
            faults.append(Fault(("particle_sets", index), said, expected))
    return faults


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []
