"""The JSON Schema of scene files, for editors: keys, kinds and bounds of values, and what they mean.

It knows what a single value may be. What several values together may be, and what files hold, is told by
``load_scene`` alone.
"""

from __future__ import annotations

import inspect
import re
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue

from packgen.arrange.registry import DEFAULT, find, names
from packgen.errors import PackingError
from packgen.scene.document import SceneFile
from packgen.version import __version__

__all__ = ["SCHEMA_NAME", "scene_schema"]

SCHEMA_NAME = "packgen.schema.json"
DIALECT = "https://json-schema.org/draft/2020-12/schema"


def scene_schema() -> dict[str, Any]:
    """Return the JSON Schema of scenes, the algorithms' settings and those of plug-ins included."""
    schema = SceneFile.model_json_schema(schema_generator=_Generator)
    definitions, rules = schema.pop("$defs"), []
    for name in names():
        try:
            params = find(name).params
        except PackingError:  # a plug-in that does not load says so when it is asked for
            continue
        if params is None:
            continue
        own = params.model_json_schema(schema_generator=_Generator)
        definitions |= own.pop("$defs", {})
        definitions[f"params.{name}"] = {"additionalProperties": False, **own}
        chosen = {"properties": {"algorithm": {"const": name}}, "required": ["algorithm"]}
        rule: dict[str, Any] = chosen
        if name == DEFAULT:
            absent = {"not": {"required": ["algorithm"]}}
            rule = {"anyOf": [chosen, absent, {"properties": {"algorithm": {"type": "null"}}}]}
        rules.append({"if": rule, "then": {"properties": {"params": _or_null(f"params.{name}")}}})
    schema["properties"]["particle_sets"]["items"].pop("discriminator")  # OpenAPI's, no editor reads it
    for key, each in schema["properties"].items():
        if key not in schema["required"]:  # a section whose lines are all commented out
            schema["properties"][key] = _nullable(each)
    schema["properties"]["algorithm"]["examples"] = list(names())
    head = {"$schema": DIALECT, "title": "packgen scene", "$comment": f"packgen {__version__}"}
    return {**head, **schema, "allOf": rules, "$defs": definitions}


def _or_null(name: str) -> dict[str, Any]:
    return {"anyOf": [{"$ref": f"#/$defs/{name}"}, {"type": "null"}]}


def _nullable(schema: dict[str, Any]) -> dict[str, Any]:
    """Return a schema that takes null as well; what it says of the key stays outside."""
    outside: dict[str, Any] = {name: schema[name] for name in ("description", "default") if name in schema}
    inner = {name: value for name, value in schema.items() if name not in outside}
    return {**outside, "anyOf": [inner, {"type": "null"}]} if inner else schema


class _Generator(GenerateJsonSchema):
    """Pydantic's generator, with the words of the docstrings and without titles."""

    def field_title_should_be_set(self, schema: Any) -> bool:
        """Say that no key has a title: its name says as much."""
        del schema
        return False

    def model_schema(self, schema: Any) -> JsonSchemaValue:
        """Return the schema of a mapping, each key with its meaning."""
        found = super().model_schema(schema)
        model: type[BaseModel] = schema["cls"]
        found.pop("title", None)
        found["description"] = _summary(model)
        meanings = _meanings(model)
        for key, each in found.get("properties", {}).items():
            # Once read, values have other forms than in a file; only plain ones are alike.
            if isinstance(each.get("default", 0), list | dict | None | str) and not _is_word(each):
                each.pop("default", None)
            if key in meanings:
                each["description"] = meanings[key]
        return found


def _is_word(schema: dict[str, Any]) -> bool:
    return isinstance(schema.get("default"), str) and bool(schema["default"])


def _summary(model: type) -> str:
    """Return what a class says of itself before its attributes."""
    text = inspect.cleandoc(model.__doc__ or "")
    return _plain(re.split(r"\n\s*Attributes:", text)[0])


def _meanings(model: type) -> dict[str, str]:
    """Return what the docstrings of a class and its bases say of their attributes."""
    found: dict[str, str] = {}
    for base in reversed(model.__mro__):
        _, _, listed = inspect.cleandoc(base.__doc__ or "").partition("\nAttributes:\n")
        if not issubclass(base, BaseModel) or base is BaseModel:
            continue
        for entry in re.split(r"^    (?=\w+:)", listed.split("\n\n")[0], flags=re.MULTILINE):
            name, colon, meaning = entry.partition(":")
            if colon:
                found[name.strip()] = _plain(meaning)
    return found


def _plain(text: str) -> str:
    """Return a docstring's text in one line, without marks of code, and null for Python's None."""
    return re.sub(r"\bNone\b", "null", re.sub(r"\s+", " ", text).strip().replace("`", ""))
