"""Which particle set each sphere of a file is of, and how dense the sets are.

Spheres of one group (set, type or name) and one density are one kind. Without a scene each kind is a set.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from packgen.arrays import Int32Array, Int64Array, distinct
from packgen.bed import ParticleSet
from packgen.errors import ReadError
from packgen.filefaults import Faults, fault
from packgen.reading.known import Known
from packgen.reading.spheres import Groups, SphereFile

KINDS_MAX = 1000
SAME_DENSITY = 1.0e-5  # relative: files have six digits
NOT_KNOWN = float("nan")


@dataclass(frozen=True, eq=False, slots=True)
class _Kinds:
    """The kinds of a file: group and density [kg/m3] of each, and the kind of each sphere, shape (N,)."""

    numbers: tuple[int, ...]
    densities: tuple[float, ...]
    index: Int64Array


def sets_of(
    spheres: SphereFile, known: Known, *, walls: bool, warn: Callable[[str], None]
) -> tuple[tuple[ParticleSet, ...], Int32Array]:
    """Return the sets and the set of each sphere, shape (N,).

    Args:
        spheres: The spheres.
        known: Sets that are known; where none are, each kind of spheres is one.
        walls: Whether the bed has walls, whose material then has a type in the decks.
        warn: Called with a line for each thing that looks wrong.

    Raises:
        ReadError: The spheres cannot be told apart by what file and scene say.
    """
    groups = spheres.groups or Groups(np.zeros(spheres.count, np.int64), "set")
    kinds = _kinds(spheres, groups)
    if not known.particle_sets:
        return _own_sets(groups, kinds), kinds.index.astype(np.int32)
    choices = _choices(spheres, groups, known, walls=walls)
    faults, of_kind = Faults(spheres.path), np.zeros(len(kinds.numbers), np.int32)
    for kind, (number, density) in enumerate(zip(kinds.numbers, kinds.densities, strict=True)):
        label = "" if spheres.groups is None else f" of {groups.label(number)}"
        of_kind[kind] = _chosen(label, choices[number], density, known, faults, warn)
    faults.check()
    return known.particle_sets, of_kind[kinds.index]


def with_densities(sets: Sequence[ParticleSet], given: Mapping[str, float]) -> tuple[ParticleSet, ...]:
    """Return sets with densities [kg/m3] that are given by name, or by the name "" for all unknown ones.

    Raises:
        ReadError: There is no set of that name, or none whose density is unknown.
    """
    names = ", ".join(each.name for each in sets)
    for name in given:
        if name and name not in [each.name for each in sets]:
            raise ReadError(f"--density: found the set {name!r}, expected one of {names}")
    if "" in given and not any(np.isnan(each.density) for each in sets):
        raise ReadError(
            f"--density: found {given['']:g} kg/m3, but the densities of all sets ({names}) are known; "
            f"say which set it is for, such as {sets[0].name}={given['']:g}, or leave it out"
        )
    general = given.get("", NOT_KNOWN)
    return tuple(
        replace(each, density=given.get(each.name, general if np.isnan(each.density) else each.density))
        for each in sets
    )


def _kinds(spheres: SphereFile, groups: Groups) -> _Kinds:
    numbers = distinct(groups.number)
    of_number = np.searchsorted(numbers, groups.number)
    if spheres.density is None:
        densities, of_density = np.array([NOT_KNOWN]), np.zeros(spheres.count, np.int64)
    else:
        densities, of_density = np.unique(spheres.density, return_inverse=True)
    pair = of_number * len(densities) + of_density
    present = distinct(pair)
    if len(present) > KINDS_MAX:
        raise fault(
            spheres.path, f"{len(numbers):,} sets or types and {len(densities):,} densities",
            f"at most {KINDS_MAX:,} kinds of spheres", remedy="is each in the right column?",
        )  # fmt: skip
    return _Kinds(
        tuple(numbers[present // len(densities)].tolist()),
        tuple(densities[present % len(densities)].tolist()),
        np.searchsorted(present, pair),
    )


def _own_sets(groups: Groups, kinds: _Kinds) -> tuple[ParticleSet, ...]:
    """Return a set for each kind, named after its group, and its density where the group has several."""
    return tuple(
        ParticleSet(
            groups.label(number) + ("" if kinds.numbers.count(number) == 1 else f"_{density:g}"), density, ""
        )
        for number, density in zip(kinds.numbers, kinds.densities, strict=True)
    )


def _choices(spheres: SphereFile, groups: Groups, known: Known, *, walls: bool) -> dict[int, list[int]]:
    """Return the places of the known sets that each group may be."""
    sets = known.particle_sets
    numbers = distinct(groups.number).tolist()
    if spheres.groups is None:
        return {0: list(range(len(sets)))}
    if groups.kind == "set":
        return {each: place_of_set(each, groups.names, sets) for each in numbers}
    if groups.kind == "name":
        return {
            number: [place for place, each in enumerate(sets) if each.name == groups.label(number)]
            for number in numbers
        }
    # The decks number the materials that are used, from 1.
    used = {each.material for each in sets} | ({known.wall_material} if walls else set())
    materials = [each.name for each in known.materials if each.name in used]
    names = {number: materials[number - 1] if 1 <= number <= len(materials) else None for number in numbers}
    return {
        number: [place for place, each in enumerate(sets) if each.material == name]
        for number, name in names.items()
    }


def place_of_set(number: int, names: Sequence[str], sets: Sequence[ParticleSet]) -> list[int]:
    """Return the place, among known sets, of that which a file has at a number; nothing: none is it.

    Args:
        number: The number.
        names: What the file calls its sets, where it does: a scene may have them in another order, or beside
            those of a bed that it goes on from. One by another name stands at its number.
        sets: The known sets.
    """
    own = [each.name for each in sets]
    if names and names[number] in own:
        return [own.index(names[number])]
    return [number] if number < len(own) and own[number] not in names else []


def _chosen(
    label: str, places: list[int], density: float, known: Known, faults: Faults, warn: Callable[[str], None]
) -> int:
    """Return the place of the known set that a kind of spheres is; 0, and a fault, where none is."""
    sets = known.particle_sets
    what = f"spheres{label}" + ("" if np.isnan(density) else f" with {density:g} kg/m3")
    if not places:
        there = ", ".join(each.name for each in sets)
        faults.add(what, f"one of the sets of {known.source}: {there}")
        return 0
    fitting = [
        place for place in places if abs(sets[place].density - density) <= SAME_DENSITY * sets[place].density
    ]
    left = fitting or places
    named = " or ".join(sets[place].name for place in left)
    if len({(sets[place].density, sets[place].material) for place in left}) > 1:
        faults.add(
            f"{what} that may be {named}",
            "what tells them apart",
            remedy="add a column set or density to the file",
        )
    elif len(left) > 1:
        warn(f"{what} may be {named}, of equal density and material; they are taken for {sets[left[0]].name}")
    if not fitting and not np.isnan(density):
        warn(f"{what}: {known.source} gives {named} {sets[left[0]].density:g} kg/m3, which is taken")
    return left[0]
