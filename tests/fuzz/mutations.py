"""One thing in a scene broken at random: it must end in a clean refusal, or be a valid scene all the same."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from tests.fuzz.generator import Case

WRONG: list[Any] = [
    float("nan"), float("inf"), -float("inf"), -1, -0.5, 0, 1e30, 1e-30, 10**400, True, None, "", "many",
    "12 mm", "3 parsec", "1e-3", [], [1.0], {}, {"radius": 1.0}, "../scene.yaml", "missing.stl", ".",
]  # fmt: skip
KEYS = ["radious", "n_particle", "", "zones", "path", "colour", "Container", "0"]
MESHES = (".stl", ".off", ".obj", ".ply")


def break_case(case: Case, rng: np.random.Generator) -> None:
    """Break a scene in its folder, and say how in ``case.broken``; ``case.data`` stays as it was made.

    The broken scene may have any value anywhere: the judge does not have to expect that.
    """
    ways: list[Callable[[Case, np.random.Generator], str]] = [_value, _value, _value, _key, _missing, _text]
    if any(each.suffix in (*MESHES, ".csv") for each in case.folder.iterdir()):
        ways += [_file, _file]
    broken = replace(case, data=copy.deepcopy(case.data))
    case.broken = ways[int(rng.integers(len(ways)))](broken, rng)


def _places(value: Any) -> list[tuple[Any, Any]]:
    """Return every (mapping or list, key) in plain data."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [found for key, inner in items for found in [(value, key), *_places(inner)]]


def _place(case: Case, rng: np.random.Generator) -> tuple[Any, Any]:
    places = _places(case.data)
    return places[int(rng.integers(len(places)))]


def _value(case: Case, rng: np.random.Generator) -> str:
    parent, key = _place(case, rng)
    former, way = parent[key], int(rng.integers(len(WRONG) + 4))
    if way < len(WRONG):
        parent[key] = WRONG[way]
    elif isinstance(former, float):
        parent[key] = [-former, str(former), former * 1e9, [former]][way - len(WRONG)]
    else:
        parent[key] = [former]
    case.write()
    return f"{key}: {former!r} becomes {parent[key]!r}"[:200]


def _key(case: Case, rng: np.random.Generator) -> str:
    maps = [case.data, *(parent[key] for parent, key in _places(case.data) if isinstance(parent[key], dict))]
    chosen, name = maps[int(rng.integers(len(maps)))], str(rng.choice(KEYS))
    if rng.random() < 0.5 and chosen:
        old = list(chosen)[int(rng.integers(len(chosen)))]
        chosen[name] = chosen.pop(old)
        name = f"{old} -> {name}"
    else:
        chosen[name] = 1.0
    case.write()
    return f"key {name}"


def _missing(case: Case, rng: np.random.Generator) -> str:
    parent, key = _place(case, rng)
    del parent[key]
    case.write()
    return f"without {key}"


def _text(case: Case, rng: np.random.Generator) -> str:
    content = case.path.read_bytes()
    place = int(rng.integers(len(content)))
    if rng.random() < 0.5:
        case.path.write_bytes(content[:place])
        return f"cut after {place} bytes"
    byte = bytes([int(rng.integers(256))])
    case.path.write_bytes(content[:place] + byte + content[place + 1 :])
    return f"byte {place} becomes {byte!r}"


def _file(case: Case, rng: np.random.Generator) -> str:
    files = sorted(each for each in case.folder.iterdir() if each.suffix in (*MESHES, ".csv"))
    path = files[int(rng.integers(len(files)))]
    content = path.read_bytes()
    way = str(rng.choice(["empty", "cut", "byte", "rubbish", "lines", "twice"]))
    if way == "empty":
        path.write_bytes(b"")
    elif way == "cut":
        path.write_bytes(content[: int(rng.integers(len(content)))])
    elif way == "byte":
        place = int(rng.integers(len(content)))
        path.write_bytes(content[:place] + bytes([int(rng.integers(256))]) + content[place + 1 :])
    elif way == "rubbish":
        path.write_bytes(rng.bytes(int(rng.integers(1, 400))))
    elif way == "twice":
        path.write_bytes(content + content)
    else:
        lines = content.split(b"\n")
        del lines[int(rng.integers(len(lines)))]
        path.write_bytes(b"\n".join(lines))
    return f"{path.name}: {way}"
