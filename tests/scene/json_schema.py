"""A small validator of JSON Schema: the keywords that the schema of scenes uses, and no other.

It shares nothing with pydantic, which wrote the schema. A keyword that it does not know is an error, so that
no rule of the schema goes untested.
"""

from __future__ import annotations

import math
import re
from typing import Any

SILENT = {"$schema", "$comment", "$defs", "title", "description", "default", "examples"}
KINDS = {
    "object": dict, "array": list, "string": str, "boolean": bool, "null": type(None), "number": (int, float),
}  # fmt: skip


def faults(value: Any, schema: dict[str, Any], root: dict[str, Any], path: str = "") -> list[str]:
    """What is wrong with a value, as places and keywords."""
    found = []
    for keyword, rule in schema.items():
        if keyword in SILENT or keyword in ("then", "additionalProperties", "patternProperties"):
            continue
        if keyword == "properties":
            found += _in_mapping(value, schema, root, path)
        elif keyword == "items":
            for place, each in enumerate(value if isinstance(value, list) else ()):
                found += faults(each, rule, root, f"{path}[{place}]")
        elif keyword == "$ref":
            found += faults(value, _resolved(rule, root), root, path)
        elif keyword == "allOf":
            found += [each for part in rule for each in faults(value, part, root, path)]
        elif keyword == "if":
            if not faults(value, rule, root, path):
                found += faults(value, schema["then"], root, path)
        elif not RULES[keyword](value, rule, root):
            found.append(f"{path}: {keyword} {rule if len(str(rule)) < 60 else ''}")
    if "properties" not in schema and {"additionalProperties", "patternProperties"} & set(schema):
        found += _in_mapping(value, schema, root, path)
    return found


def _in_mapping(value: Any, schema: dict[str, Any], root: dict[str, Any], path: str) -> list[str]:
    if not isinstance(value, dict):
        return []
    own, patterns = schema.get("properties", {}), schema.get("patternProperties", {})
    found = []
    for key, each in value.items():
        rules = [own[key]] if key in own else []
        rules += [rule for pattern, rule in patterns.items() if re.search(pattern, key)]
        if not rules and schema.get("additionalProperties", True) is False:
            found.append(f"{path}.{key}: unknown")
        for rule in rules:
            found += faults(each, rule, root, f"{path}.{key}")
    return found


def _resolved(reference: str, root: dict[str, Any]) -> dict[str, Any]:
    here: Any = root
    for part in reference.removeprefix("#/").split("/"):
        here = here[part]
    return here


def _is_kind(value: Any, kind: str, _root: Any) -> bool:
    if kind == "integer":
        return isinstance(value, int | float) and not isinstance(value, bool) and float(value).is_integer()
    return isinstance(value, KINDS[kind]) and not (kind == "number" and isinstance(value, bool))


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


RULES = {
    "type": _is_kind,
    "const": lambda value, rule, _: value == rule,
    "enum": lambda value, rule, _: any(value == each and type(value) is type(each) for each in rule),
    "required": lambda value, rule, _: not isinstance(value, dict) or set(rule) <= set(value),
    "minimum": lambda value, rule, _: not _number(value) or value >= rule,
    "maximum": lambda value, rule, _: not _number(value) or value <= rule,
    "exclusiveMinimum": lambda value, rule, _: not _number(value) or value > rule,
    "exclusiveMaximum": lambda value, rule, _: not _number(value) or value < rule,
    "minItems": lambda value, rule, _: not isinstance(value, list) or len(value) >= rule,
    "maxItems": lambda value, rule, _: not isinstance(value, list) or len(value) <= rule,
    "uniqueItems": lambda value, rule, _: not isinstance(value, list) or len(set(value)) == len(value),
    "minLength": lambda value, rule, _: not isinstance(value, str) or len(value) >= rule,
    "pattern": lambda value, rule, _: not isinstance(value, str) or re.search(rule, value) is not None,
    "not": lambda value, rule, root: bool(faults(value, rule, root)),
    "anyOf": lambda value, rule, root: any(not faults(value, each, root) for each in rule),
    "oneOf": lambda value, rule, root: sum(not faults(value, each, root) for each in rule) == 1,
}
