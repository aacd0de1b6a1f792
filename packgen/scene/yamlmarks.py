"""YAML text into plain data that remembers where each value stood.

Scalars follow YAML 1.2's core schema (https://yaml.org/spec/1.2.2/#103-core-schema), not PyYAML's 1.1:
``1e-3`` is a number, ``010`` is ten, ``no`` and ``12:30`` are text. Duplicate keys, tags and merge keys are
refused. The data is built from parser events, so depth and size are bounded while the file is being read:
nested brackets cannot exhaust the stack, and aliases cannot multiply.

Example: ``read_yaml(Path("scene.yaml")).mark(("container", "path"))`` is ``Mark(line=2, column=9)``.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn

import yaml

from packgen.errors import SceneError, printable

__all__ = [
    "Key", "Location", "Mark", "MarkedData", "joined", "parse_yaml", "path_location", "path_text",
    "read_yaml",
]  # fmt: skip

SIZE_LIMIT = 2_000_000  # bytes; radii by the million belong into a file of their own
NODE_LIMIT = 100_000
DEPTH_LIMIT = 32
FAULT_LIMIT = 20

Key = str | int
Location = tuple[Key, ...]

_INTEGER = re.compile(r"[-+]?[0-9]{1,40}")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_WORDS: dict[str, Any] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".inf", ".Inf", ".INF", "+.inf", "+.Inf", "+.INF"), float("inf")),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), float("-inf")),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}
_TEXT_TAGS = (None, "!")
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True, slots=True, order=True)
class Mark:
    """A place in a file; line and column count from 1."""

    line: int
    column: int


@dataclass(frozen=True, slots=True)
class MarkedData:
    """Plain data (dict, list, str, int, float, bool, None) and the places of its values.

    Attributes:
        name: What messages call the file.
        data: The document.
        values: Place of each value, by its path.
        keys: Place of each mapping key, by the path of its value.
        given: What messages call the place of a value that is not the file's, by its path.
    """

    name: str
    data: Any
    values: dict[Location, Mark] = field(default_factory=dict)
    keys: dict[Location, Mark] = field(default_factory=dict)
    given: dict[Location, str] = field(default_factory=dict)

    def mark(self, location: Location, *, key: bool = False) -> Mark | None:
        """Return the place of a value (or of its key) in the file, else of the nearest value around it."""
        if key and location in self.keys:
            return self.keys[location]
        for end in range(len(location), 0, -1):
            outer = location[:end]
            if outer in self.values:
                # A value left out is missed where the mapping's own key stands, not at its first entry.
                missing = end < len(location)
                return self.keys.get(outer, self.values[outer]) if missing else self.values[outer]
        return self.values.get(())

    def place(self, location: Location, *, key: bool = False) -> str:
        """Return ``file:line:column`` of a value, or only the file where nothing is known."""
        given = self._given(location)
        if given is not None:
            return given
        mark = self.mark(location, key=key)
        return f"{self.name}:{mark.line}:{mark.column}" if mark else self.name

    def named(self, location: Location, *, key: bool = False) -> str:
        """Return the place of a value and its path, ``file:line:column: path``, each said once."""
        return joined(self.place(location, key=key), path_text(location))

    def states(self, location: Location) -> bool:
        """Return whether the document has a value there."""
        here = self.data
        for part in location:
            in_list = isinstance(here, list) and isinstance(part, int) and part < len(here)
            if not in_list and not (isinstance(here, dict) and part in here):
                return False
            here = here[part]
        return True

    def order(self, location: Location, *, key: bool = False) -> tuple[int, int]:
        """Return what sorts values as they stand in the file, those first that are not the file's."""
        given = self._given(location)
        if given is not None:
            return (0, list(self.given.values()).index(given))
        mark = self.mark(location, key=key)
        return (mark.line, mark.column) if mark else (0, 0)

    def _given(self, location: Location) -> str | None:
        """Return what the place of a value that is not the file's is called; None: it is the file's."""
        for end in range(len(location), 0, -1):
            if location[:end] in self.given:
                return self.given[location[:end]]
        return None


def path_text(location: Location) -> str:
    """Return a path as people write it: ``("zones", 1, "location")`` gives ``zones[1].location``."""
    text = ""
    for part in location:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text


def joined(place: str, path: str) -> str:
    """Return ``place: path``; a place such as ``--set zones[0].mass`` has said its path already."""
    return place if not path or place.endswith(f" {path}") else f"{place}: {path}"


def path_location(text: str) -> Location:
    """Return the path that ``path_text`` writes: ``zones[1].location`` gives ``("zones", 1, "location")``."""
    parts = re.findall(r"\[(\d+)\]|([^.\[\]]+)", text)
    return tuple(int(index) if index else name for index, name in parts)


def read_yaml(path: Path, *, spell: Callable[[str], str] = str) -> MarkedData:
    """Read a YAML file.

    Args:
        path: The file.
        spell: Turns each mapping key into its regular spelling.

    Returns:
        The document with marks.

    Raises:
        SceneError: The file is missing, unreadable, no regular file, too large, not UTF-8, or not YAML.
    """
    name = str(path)
    try:
        status = os.stat(path)
        if stat.S_ISDIR(status.st_mode):
            raise SceneError([f"{name}: found a directory, expected a scene file"])
        if not stat.S_ISREG(status.st_mode):
            raise SceneError([f"{name}: found no regular file, expected a scene file"])
        if status.st_size > SIZE_LIMIT:
            raise SceneError([_too_large(name, status.st_size)])
        with path.open("rb") as stream:
            content = stream.read(SIZE_LIMIT + 1)
    except (OSError, ValueError) as error:
        if isinstance(error, SceneError):
            raise
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise SceneError([f"{name}: cannot be read: {reason}; give the path of a scene file"]) from error
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        found = f"byte 0x{content[error.start]:02x}"
        raise SceneError([f"{name}:{line}: found {found}, expected text in UTF-8"]) from error
    return parse_yaml(text, name, spell=spell)


def parse_yaml(text: str, name: str, *, spell: Callable[[str], str] = str) -> MarkedData:
    """Turn YAML text into plain data with marks.

    Args:
        text: One YAML document.
        name: What messages call it.
        spell: Turns each mapping key into its regular spelling.

    Returns:
        The document with marks.

    Raises:
        SceneError: The text is not YAML, too large or too deep, or uses what scenes do without: several
            documents, tags, merge keys, keys that are lists, keys that come twice.
    """
    name = printable(name)  # also for what is told of a scene that is none of its faults
    if len(text) > SIZE_LIMIT:
        raise SceneError([_too_large(name, len(text))])
    builder = _Builder(name, spell)
    try:
        document = builder.build(yaml.parse(text, Loader=_Loader))
    except yaml.YAMLError as error:
        raise SceneError([*builder.faults, _syntax_problem(name, text, error)]) from error
    if builder.faults:
        raise SceneError(builder.faults)
    return document


@dataclass(slots=True)
class _Open:
    """A list or mapping whose end has not been read yet."""

    container: dict[str, Any] | list[Any]
    location: Location
    anchor: str | None
    weight_before: int
    key: str | None = None

    def next_location(self) -> Location:
        if isinstance(self.container, list):
            return (*self.location, len(self.container))
        return (*self.location, self.key or "")


class _Builder:
    """Builds plain data from parser events, one event at a time, without recursion."""

    def __init__(self, name: str, spell: Callable[[str], str]) -> None:
        self.name, self.spell = name, spell
        self.faults: list[str] = []
        self.document = MarkedData(name, None)
        self.stack: list[_Open] = []
        self.anchors: dict[str, tuple[Any, int]] = {}
        self.weight = 0
        self.documents = 0

    def build(self, events: Iterator[yaml.Event]) -> MarkedData:
        """Consume all events and return the document."""
        root: Any = None
        for event in events:
            if isinstance(event, yaml.DocumentStartEvent):
                self.documents += 1
                if self.documents > 1:
                    self._stop(event, "found a second document (---), expected one scene a file")
            elif isinstance(event, yaml.AliasEvent):
                root = self._alias(event, root)
            elif isinstance(event, yaml.ScalarEvent):
                root = self._scalar(event, root)
            elif isinstance(event, yaml.CollectionStartEvent):
                root = self._open(event, root)
            elif isinstance(event, yaml.CollectionEndEvent):
                closed = self.stack.pop()
                if closed.anchor:
                    self.anchors[closed.anchor] = (closed.container, self.weight - closed.weight_before)
        return MarkedData(self.name, root, self.document.values, self.document.keys)

    def _scalar(self, event: yaml.ScalarEvent, root: Any) -> Any:
        if self._awaits_key():
            self._key(event)
            return root
        self._refuse_tag(event)
        value = _resolve(event.value) if event.implicit[0] else event.value
        if event.anchor:
            self.anchors[event.anchor] = (value, 1)
        return self._place(event, value, 1, root)

    def _alias(self, event: yaml.AliasEvent, root: Any) -> Any:
        if self._awaits_key():
            self._stop(event, "found an alias as a key, expected the key written out")
        if event.anchor not in self.anchors:
            self._stop(event, f"found *{event.anchor}, expected the name of a complete anchor above")
        value, weight = self.anchors[event.anchor]
        return self._place(event, value, weight, root)

    def _open(self, event: yaml.CollectionStartEvent, root: Any) -> Any:
        if self._awaits_key():
            self._stop(event, "found a list or mapping as a key, expected text")
        if len(self.stack) >= DEPTH_LIMIT:
            self._stop(event, f"found more than {DEPTH_LIMIT} levels of nesting, expected a scene")
        self._refuse_tag(event)
        container: dict[str, Any] | list[Any] = [] if isinstance(event, yaml.SequenceStartEvent) else {}
        location = self.stack[-1].next_location() if self.stack else ()
        before = self.weight
        root = self._place(event, container, 1, root)
        self.stack.append(_Open(container, location, event.anchor, before))
        return root

    def _awaits_key(self) -> bool:
        return bool(self.stack) and isinstance(self.stack[-1].container, dict) and self.stack[-1].key is None

    def _key(self, event: yaml.ScalarEvent) -> None:
        self._refuse_tag(event)
        top = self.stack[-1]
        if event.implicit[0] and event.value == "<<":
            self._stop(event, "found a merge key (<<), which YAML 1.2 has not; write the keys out")
        key = self.spell(event.value)
        location = (*top.location, key)
        mark = _mark(event)
        if key in top.container:
            first = self.document.keys[location]
            self._fault(
                event,
                f"{path_text(location)}: found the key twice (first in line {first.line}), expected it once",
            )
        else:
            self.document.keys[location] = mark
        top.key = key

    def _place(self, event: yaml.Event, value: Any, weight: int, root: Any) -> Any:
        """Put a value where the open container wants it; return the root."""
        self.weight += weight
        if self.weight > NODE_LIMIT:
            self._stop(
                event, f"found more than {NODE_LIMIT} values, expected a scene; put long lists into a file"
            )
        mark = _mark(event)
        if not self.stack:
            self.document.values[()] = mark
            return value
        top = self.stack[-1]
        location = top.next_location()
        self.document.values.setdefault(location, mark)
        if isinstance(top.container, list):
            top.container.append(value)
        else:
            top.container.setdefault(top.key or "", value)
            top.key = None
        return root

    def _refuse_tag(self, event: yaml.ScalarEvent | yaml.CollectionStartEvent) -> None:
        if event.tag not in _TEXT_TAGS:
            self._fault(event, f"found the tag {event.tag}, expected a plain value")

    def _line(self, event: yaml.Event, problem: str) -> str:
        mark = _mark(event)
        return f"{self.name}:{mark.line}:{mark.column}: {problem}"

    def _fault(self, event: yaml.Event, problem: str) -> None:
        self.faults.append(self._line(event, problem))
        if len(self.faults) >= FAULT_LIMIT:
            raise SceneError(self.faults)

    def _stop(self, event: yaml.Event, problem: str) -> NoReturn:
        raise SceneError([*self.faults, self._line(event, problem)])


def _mark(event: yaml.Event) -> Mark:
    """Return where an event starts."""
    start: Any = event.start_mark
    return Mark(start.line + 1, start.column + 1)


def _resolve(text: str) -> Any:
    """Return the value of a plain scalar by YAML 1.2's core schema."""
    if text in _WORDS:
        return _WORDS[text]
    if _INTEGER.fullmatch(text):
        return int(text)
    if _FLOAT.fullmatch(text):
        return float(text)
    return text


def _syntax_problem(name: str, text: str, error: yaml.YAMLError) -> str:
    """Say in one line where the parser gave up, and why."""
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    if mark is not None:
        reasons = [getattr(error, part, None) for part in ("context", "problem")]
        reason = ", ".join(each for each in reasons if each) or "not YAML"
        place = f"{name}:{mark.line + 1}:{mark.column + 1}"
        return f"{place}: found no valid YAML ({reason}), expected a scene"
    position = getattr(error, "position", None)
    if isinstance(position, int):
        line = text.count("\n", 0, position) + 1
        return f"{name}:{line}: found a control character that YAML does not allow, expected plain text"
    return f"{name}: found no valid YAML ({error}), expected a scene"


def _too_large(name: str, size: int) -> str:
    return (
        f"{name}: found {size} bytes, expected a scene of at most {SIZE_LIMIT}; "
        "long lists of radii belong into a file (radius_distribution: file)"
    )
