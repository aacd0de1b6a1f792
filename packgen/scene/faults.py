"""Turns what pydantic says of a scene into lines for people: ``file:line:column: path: found, expected``."""

from __future__ import annotations

import difflib
import types
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from packgen.errors import printable
from packgen.scene.yamlmarks import Key, Location, MarkedData, joined, path_text
from packgen.values import Where

__all__ = ["Fault", "Said", "faults_of", "known_keys", "lines_of"]

LINE_LIMIT = 50
TEXT_LIMIT = 60


class Said(str):
    """Text that describes a value, as opposed to being one."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that is wrong with a scene.

    Attributes:
        location: Where.
        found: The value that stands there; a ``Said`` is shown as it is.
        expected: What should stand there.
        at_key: Whether the key is meant rather than its value.
    """

    location: Location
    found: Any
    expected: str
    at_key: bool = False


def lines_of(faults: Iterable[Fault], marked: MarkedData) -> list[str]:
    """Return one line a fault, in the order of the file."""
    ordered = sorted(faults, key=lambda fault: marked.order(fault.location, key=fault.at_key))
    lines = []
    for fault in ordered[:LINE_LIMIT]:
        path = path_text(tuple(_short(each) if isinstance(each, str) else each for each in fault.location))
        place = joined(marked.place(fault.location, key=fault.at_key), path)
        lines.append(f"{place}: found {_shown(fault.found)}, expected {fault.expected}")
    if len(ordered) > LINE_LIMIT:
        lines.append(f"{marked.name}: found {len(ordered) - LINE_LIMIT} faults more, expected none")
    return list(dict.fromkeys(lines))


def faults_of(error: ValidationError, model: type[BaseModel], data: Any) -> list[Fault]:
    """Return the faults in a validation error.

    Args:
        error: What pydantic raised.
        model: The model of the whole document.
        data: The document.
    """
    faults: list[Fault] = []
    for each in error.errors(include_url=False):
        location = _in_document(each["loc"], data, keep_last=each["type"] == "missing")
        faults += _faults(each, location, model)
    return faults


def _faults(detail: ErrorDetails, location: Location, model: type[BaseModel]) -> list[Fault]:
    """Return the faults in one of pydantic's errors."""
    kind, value = detail["type"], detail["input"]
    context: Mapping[str, Any] = detail.get("ctx", {})
    if kind == "packgen":
        return [_inner(location, *each) for each in context["faults"]]
    if kind == "extra_forbidden":
        names = _keys_at(detail["loc"][:-1], model)
        return [Fault(location, Said("an unknown key"), _choice(str(location[-1]), names), at_key=True)]
    if kind == "missing":
        return [Fault(location, Said("nothing"), "this key and a value", at_key=True)]
    if kind in ("union_tag_not_found", "union_tag_invalid"):
        return [_tag_fault(location, value, context, _tags_at(detail["loc"], model))]
    at_key = bool(detail["loc"]) and detail["loc"][-1] == "[key]"
    return [Fault(location, value, _expectation(detail, context, value), at_key)]


def _inner(location: Location, where: Where, found: Any, expected: str) -> Fault:
    """Return a fault at a place inside the value at ``location``."""
    inner = where if isinstance(where, tuple) else (where,) if where != "" else ()
    return Fault((*location, *inner), Said(found) if isinstance(found, str) else found, expected)


def _tag_fault(location: Location, value: Any, context: Mapping[str, Any], tags: list[str]) -> Fault:
    """Return the fault of a mapping whose kind is not given or not known."""
    if not isinstance(value, dict):
        return Fault(location, value, "a mapping of keys")
    key = str(context["discriminator"]).strip("'")
    if key not in value:
        return Fault((*location, key), Said("nothing"), _choice("", tags), at_key=True)
    return Fault((*location, key), value[key], _choice(str(value[key]), tags))


def known_keys(model: type[BaseModel]) -> frozenset[str]:
    """Return every key that a model and the models in it know."""
    names: set[str] = set()
    seen: set[type[BaseModel]] = set()
    waiting = [model]
    while waiting:
        each = waiting.pop()
        if each in seen:
            continue
        seen.add(each)
        names |= set(each.model_fields)
        for information in each.model_fields.values():
            waiting += _models_in(information.annotation)
    return frozenset(names)


def _expectation(detail: ErrorDetails, context: Mapping[str, Any], value: Any) -> str:
    """Return what one of pydantic's own checks expected."""
    kind = detail["type"]
    if kind == "value_error":
        return str(context["error"])
    if kind == "literal_error":
        options = [each.strip("'") for each in str(context["expected"]).replace(" or ", ", ").split(", ")]
        return _choice(str(value), options)
    if kind in ("model_type", "model_attributes_type", "dict_type", "mapping_type"):
        return "a mapping of keys"
    if kind in ("tuple_type", "list_type"):
        return "a list"
    return detail["msg"].removeprefix("Input should be ")


def _choice(found: str, options: Iterable[str]) -> str:
    """Return ``one of ...``, with the likeliest one first where there is one."""
    names = sorted(options)
    listed = f"one of {', '.join(names)}" if len(names) > 1 else "".join(names)
    close = difflib.get_close_matches(found[:64].lower(), names, n=1)
    return f"{listed}; did you mean {close[0]}?" if close and len(names) > 1 else listed


def _in_document(loc: tuple[Key, ...], data: Any, *, keep_last: bool) -> Location:
    """Return pydantic's location without what is not in the document, such as the tags of its unions."""
    location: list[Key] = []
    here = data
    for index, part in enumerate(loc):
        in_mapping = isinstance(here, dict) and part in here
        in_list = isinstance(here, list) and isinstance(part, int) and part < len(here)
        if in_mapping or in_list:
            here = here[part]
            location.append(part)
        elif keep_last and index == len(loc) - 1:
            location.append(part)
    return tuple(location)


def _keys_at(loc: tuple[Key, ...], model: type[BaseModel]) -> list[str]:
    """Return the keys that the mapping at a location may have."""
    models = [model]
    for part in loc:
        if isinstance(part, int):
            continue
        tagged = [each for each in models if part in _tags(each)]
        if tagged:
            models = tagged
            continue
        fields = [each.model_fields[part].annotation for each in models if part in each.model_fields]
        inner = [found for annotation in fields for found in _models_in(annotation)]
        models = inner or models
    return sorted({name for each in models for name in each.model_fields})


def _tags_at(loc: tuple[Key, ...], model: type[BaseModel]) -> list[str]:
    """Return the tags of the union at a location."""
    models = [model]
    for part in loc:
        if isinstance(part, str):
            fields = [each.model_fields[part].annotation for each in models if part in each.model_fields]
            models = [found for annotation in fields for found in _models_in(annotation)]
    return [tag for each in models for tag in _tags(each)]


def _tags(model: type[BaseModel]) -> tuple[str, ...]:
    """Return the value of ``radius_distribution`` that stands for a model, where it is one of a union."""
    information = model.model_fields.get("radius_distribution")
    return tuple(get_args(information.annotation)) if information else ()


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    """Return the models that an annotation mentions."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    if get_origin(annotation) in (Annotated, Union, types.UnionType, tuple, list, dict):
        return [found for each in get_args(annotation) for found in _models_in(each)]
    return []


def _shown(value: Any) -> str:
    """Return a value as a short piece of one line."""
    if isinstance(value, Said):
        return _short(value)
    if value is None:
        return "nothing (null)"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (dict, list)):
        kind = "a mapping" if isinstance(value, dict) else "a list"
        return _short(repr(value)) if len(value) <= 8 else f"{kind} of {len(value)}"
    return _short(repr(value))


def _short(text: str) -> str:
    plain = printable(text[: 2 * TEXT_LIMIT])
    return plain if len(plain) <= TEXT_LIMIT else f"{plain[: TEXT_LIMIT - 3]}..."
