"""What a sweep goes over: ``seed=0:9``, ``materials.glass.friction=0.1,0.3``, and the runs that follow."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from types import MappingProxyType

from packgen.errors import PackgenError, SceneError
from packgen.scene.changes import Change, parse_change
from packgen.scene.yamlmarks import path_text

__all__ = ["OPTION", "Over", "Run", "parse_over", "runs_over"]

OPTION = "--over"
RUNS_MAX = 10_000
NAME_MAX = 100  # characters of a folder's name
EXPECTED = "KEY=VALUES, such as --over seed=0:9 or --over materials.glass.friction=0.1,0.3"

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_RANGE = re.compile(rf"\s*({_NUMBER})\s*:\s*({_NUMBER})\s*(?::\s*({_NUMBER})\s*)?")
_RANGE_LIKE = re.compile(r"[^\[\]{}\"',]*:[^\s\[\]{}\"',][^\[\]{}\"',]*")
_QUOTES, _OPENING, _CLOSING = "\"'", "[{", "]}"


@dataclass(frozen=True, slots=True)
class Over:
    """A key of the scene, and the values that it gets.

    Attributes:
        key: Its path, such as ``zones[0].n_particles``.
        values: The values as texts of YAML, each once.
    """

    key: str
    values: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Run:
    """A run of a sweep.

    Attributes:
        name: Name of its folder.
        values: The value of each key, by its path.
        beside: Values of other keys, which are not told.
        option: The option that gives them.
    """

    name: str
    values: dict[str, str]
    beside: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    option: str = OPTION

    def settings(self) -> list[str]:
        """Return all values, each as ``KEY=VALUE``."""
        return [f"{key}={value}" for key, value in {**self.values, **self.beside}.items()]

    def changes(self) -> list[Change]:
        """Return all values as changes of the scene."""
        return [parse_change(each, option=self.option) for each in self.settings()]

    def label(self) -> str:
        """Return the values as a line."""
        return " ".join(f"{key}={value}" for key, value in self.values.items())


def parse_over(text: str) -> Over:
    """Read ``KEY=VALUES``: values of YAML with commas between, or a range ``FIRST:LAST`` or with ``:STEP``.

    Both ends of a range belong to it.

    Raises:
        PackgenError: It has another form; one line.
    """
    key, equals, values = text.partition("=")
    key = key.strip()
    if not equals or not key or not values.strip():
        raise PackgenError(f"{OPTION}: found {text!r}, expected {EXPECTED}")
    found = _values(key, values)
    for each in found:
        try:
            change = parse_change(f"{key}={each}", option=OPTION)
        except SceneError as error:
            raise PackgenError(str(error)) from error
    return Over(path_text(change.location), tuple(dict.fromkeys(found)))


def _values(key: str, text: str) -> list[str]:
    match = _RANGE.fullmatch(text)
    if match is not None:
        return _in_range(key, *match.groups())
    if _RANGE_LIKE.fullmatch(text):
        raise PackgenError(
            f"{OPTION} {key}: found {text!r}, expected a range of numbers such as 0:9 or 0:1:0.25"
        )
    found = [each.strip() for each in _split(text)]
    if "" in found:
        raise PackgenError(f"{OPTION} {key}: found {text!r}, expected a value between the commas")
    return found


def _in_range(key: str, first: str, last: str, step: str | None) -> list[str]:
    """Return the numbers of a range, whole ones without a point."""
    low, high, width = float(first), float(last), 1.0 if step is None else float(step)
    said = f"{OPTION} {key}: found {first}:{last}{'' if step is None else f':{step}'}, expected"
    if step is None and not (low.is_integer() and high.is_integer()):
        raise PackgenError(f"{said} a step as well, such as {first}:{last}:{(high - low) / 4 or 0.1:g}")
    if not width > 0.0:
        raise PackgenError(f"{said} a step greater than 0")
    if high < low:
        raise PackgenError(f"{said} the lower end first, {last}:{first}")
    count = math.floor((high - low) / width * (1.0 + 1e-12) + 1e-9) + 1
    if count > RUNS_MAX:
        raise PackgenError(f"{said} at most {RUNS_MAX:,} values, not {count:,}")
    return [f"{low + place * width:.12g}" for place in range(count)]


def _split(text: str) -> list[str]:
    """Return the parts between commas that stand in no bracket and no quotes."""
    parts, depth, quote = [""], 0, ""
    for each in text:
        if quote:
            quote = "" if each == quote else quote
        elif each in _QUOTES:
            quote = each
        elif each in _OPENING:
            depth += 1
        elif each in _CLOSING:
            depth -= 1
        elif each == "," and depth == 0:
            parts.append("")
            continue
        parts[-1] += each
    return parts


def runs_over(overs: Sequence[Over]) -> list[Run]:
    """Return all combinations, the last key's values changing fastest.

    Raises:
        PackgenError: A key comes twice, or there are too many.
    """
    keys = [each.key for each in overs]
    twice = [key for place, key in enumerate(keys) if key in keys[:place]]
    if twice:
        raise PackgenError(f"{OPTION} {twice[0]}: found the key twice, expected it once with all its values")
    count = math.prod(len(each.values) for each in overs)
    if count > RUNS_MAX:
        raise PackgenError(f"{OPTION}: found {count:,} combinations, expected at most {RUNS_MAX:,}")
    combinations = [
        dict(zip(keys, values, strict=True)) for values in product(*(each.values for each in overs))
    ]
    short = _short_names(keys)
    names = [_name(short, values) for values in combinations]
    width = len(str(count - 1))
    numbered = len({each.lower() for each in names}) < count or max(map(len, names)) > NAME_MAX
    return [
        Run(f"{place:0{width}d}_{name[:NAME_MAX]}" if numbered else name, values)
        for place, (name, values) in enumerate(zip(names, combinations, strict=True))
    ]


def _short_names(keys: Sequence[str]) -> dict[str, str]:
    """Return the last part of each key, or all of it where another key ends alike."""
    last = {key: key.rpartition(".")[2] for key in keys}
    endings = list(last.values())
    return {key: short if endings.count(short) == 1 else key for key, short in last.items()}


def _name(short: dict[str, str], values: dict[str, str]) -> str:
    """Return the name of a folder that every file system takes."""
    text = "_".join(f"{short[key]}={value}" for key, value in values.items())
    return re.sub(r"[^A-Za-z0-9_.=+-]+", "-", text).strip("-.") or "run"
