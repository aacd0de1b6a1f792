"""Values that the command line gives in place of a scene's: ``--set zones[0].n_particles=500``.

A change is made in the plain data, before anything is checked, so that its faults are found with those of the
file and in the same words; only the place is another one.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from packgen.errors import SceneError
from packgen.scene.yamlmarks import Key, Location, MarkedData, parse_yaml, path_location, path_text

__all__ = ["Change", "changed", "parse_change", "plain_data"]

EXAMPLE = "zones[0].n_particles=500"


@dataclass(frozen=True, slots=True)
class Change:
    """A value in place of the scene's.

    Attributes:
        option: The option that gives it, such as ``--set``.
        location: Where it goes.
        value: Plain data.
    """

    option: str
    location: Location
    value: Any

    @property
    def place(self) -> str:
        """What messages call its place."""
        return f"{self.option} {path_text(self.location)}"


def parse_change(text: str, *, option: str = "--set", spell: Callable[[str], str] = str) -> Change:
    """Read a change.

    Args:
        text: ``KEY=VALUE``; the value is YAML.
        option: The option that gives it.
        spell: Turns each key into its regular spelling.

    Returns:
        The change.

    Raises:
        SceneError: It has another form; one line.
    """
    key, equals, value = text.partition("=")
    location = _location(key.strip(), spell)
    if not equals or location is None:
        raise SceneError([f"{option}: found {text!r}, expected KEY=VALUE, such as {option} {EXAMPLE}"])
    try:
        # Its own words speak of a scene; a value is a line at most.
        data = parse_yaml(value, option, spell=spell).data
    except SceneError as error:
        reason = error.problems[0].partition("(")[2].rpartition(")")[0]
        why = f" ({reason})" if reason else ""
        raise SceneError(
            [f"{option} {key.strip()}: found {value!r}, expected a value as YAML has it{why}"]
        ) from error
    return Change(option, location, data)


def _location(text: str, spell: Callable[[str], str]) -> Location | None:
    """Return the path that a text names; None where it names none."""
    location = path_location(text)
    if not location or isinstance(location[0], int) or path_text(location) != text:
        return None
    return tuple(spell(each) if isinstance(each, str) else each for each in location)


def changed(marked: MarkedData, changes: Sequence[Change]) -> tuple[MarkedData, list[str]]:
    """Make changes in a document.

    Args:
        marked: The document; it stays as it is.
        changes: The changes, in their order: the last one of a place counts.

    Returns:
        (the document with all changes that could be made, a line for each one that could not).
    """
    data, given = marked.data, dict(marked.given)
    faults = []
    for each in changes:
        try:
            data, made = _put(data, each.location, 0, each.value)
        except _NoPlaceError as error:
            faults.append(f"{each.place}: {error}")
            continue
        for depth in range(made, len(each.location) + 1):
            given[each.location[:depth]] = each.place
    return replace(marked, data=data, given=given), faults


def plain_data(value: Any) -> Any:
    """Return a value as YAML would hold it: tuples and arrays as lists, paths as text."""
    if isinstance(value, Mapping):
        return {str(key): plain_data(each) for key, each in value.items()}
    if hasattr(value, "tolist"):  # numpy's arrays and numbers
        return value.tolist()
    if isinstance(value, list | tuple):
        return [plain_data(each) for each in value]
    return str(value) if isinstance(value, os.PathLike) else value


class _NoPlaceError(ValueError):
    """A path that leads nowhere; what was found and expected."""


def _put(here: Any, location: Location, depth: int, value: Any) -> tuple[Any, int]:
    """Return a copy of some data with a value at a place, and the depth from which on it is new."""
    if depth == len(location):
        return value, depth
    part, outer = location[depth], path_text(location[:depth])
    if here is None and depth:  # the section is absent; a list of one begins with its first item
        here = {} if isinstance(part, str) else []
        if part == 0:
            inner, _ = _put(None, location, depth + 1, value)
            return [inner], depth
    if isinstance(part, str) and isinstance(here, dict):
        there = part in here
        inner, made = _put(here.get(part), location, depth + 1, value)
        return {**here, part: inner}, made if there else depth + 1
    if isinstance(part, int) and isinstance(here, list):
        if part >= len(here):
            raise _NoPlaceError(f"found index {part}, expected {_indices(outer, len(here))}")
        inner, made = _put(here[part], location, depth + 1, value)
        return [*here[:part], inner, *here[part + 1 :]], made
    raise _NoPlaceError(_wrong_kind(here, part, outer))


def _indices(outer: str, count: int) -> str:
    if count == 0:
        return f"none: {outer} is empty"
    return f"0: {outer} has one item" if count == 1 else f"0 to {count - 1}: {outer} has {count} items"


def _wrong_kind(here: Any, part: Key, outer: str) -> str:
    """Return what is wrong with a step into a value of another kind."""
    if isinstance(here, list):
        return f"found the key {part} of a list, expected an index, such as {outer}[0].{part}"
    if isinstance(part, int) and isinstance(here, dict):
        keys = ", ".join(map(str, list(here)[:8]))
        return f"found an index of {outer}, which is no list, expected one of its keys: {keys}"
    step = f"[{part}]" if isinstance(part, int) else part
    return f"found {here!r} at {outer}, which has no {step}, expected a key of the scene"
