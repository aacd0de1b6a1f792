# ruff: noqa: E501 (tables of values, a row a kind)
"""Claims on the YAML reader: YAML 1.2 scalars, marks, and refusals that come early."""

from __future__ import annotations

import math
import os
from pathlib import Path

import pytest

from packgen.errors import SceneError
from packgen.scene.yamlmarks import (
    NODE_LIMIT,
    SIZE_LIMIT,
    Mark,
    parse_yaml,
    path_location,
    path_text,
    read_yaml,
)


def problem(text: str) -> str:
    with pytest.raises(SceneError) as caught:
        parse_yaml(text, "s.yaml")
    assert "\n" not in caught.value.problems[0]
    return caught.value.problems[0]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 1e-3), ("1.0e+3", 1000.0), (".5", 0.5), ("5.", 5.0), ("010", 10), ("-7", -7), ("no", "no"),
        ("on", "on"), ("12:30:00", "12:30:00"), ("1_000", "1_000"), ("true", True), ("~", None), ("", None),
        ("'12'", "12"), ('"1e-3"', "1e-3"), ("12 mm", "12 mm"), ("0x10", "0x10"), ("2024-01-01", "2024-01-01"),
        (".inf", math.inf), ("1e999", math.inf), ("9" * 400, math.inf), ("=", "="),
    ],
)  # fmt: skip
def test_scalars_follow_yaml_1_2(text: str, value: object) -> None:
    found = parse_yaml(f"key: {text}\n", "s.yaml").data["key"]
    assert found == value
    assert type(found) is type(value)


def test_marks_give_line_and_column_of_values_and_keys() -> None:
    marked = parse_yaml("a: 1\nzones:\n  - b: [1, {c: 2}]\n", "s.yaml")
    assert marked.mark(("zones", 0, "b", 1, "c")) == Mark(3, 16)
    assert marked.mark(("zones", 0, "b"), key=True) == Mark(3, 5)
    assert marked.place(("zones", 0, "absent")) == "s.yaml:3:5"
    assert marked.place(("zones", "absent")) == "s.yaml:2:1"


def test_path_text_and_path_location_are_inverse() -> None:
    location = ("zones", 1, "location", "slice")
    assert path_text(location) == "zones[1].location.slice"
    assert path_location(path_text(location)) == location


def test_an_anchor_gives_the_same_value_again() -> None:
    assert parse_yaml("a: &x [1, 2]\nb: *x\n", "s").data == {"a": [1, 2], "b": [1, 2]}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a: 1\nb: 2\na: 3\n", "s.yaml:3:1: a: found the key twice (first in line 1)"),
        ("a:\n  <<: {b: 1}\n", "s.yaml:2:3: found a merge key"),
        ("a: !!python/object:os.system x\n", "s.yaml:1:4: found the tag"),
        ("? [1]\n: 2\n", "as a key"),
        ("a: 1\n---\nb: 2\n", "s.yaml:2:1: found a second document"),
        ("a: *b\n", "*b"),
        ("&a [*a]\n", "*a"),
        ("[" * 5000, "nesting"),
        ("- " * 5000, "nesting"),
        ("a: b: c\n", "s.yaml:1:5: found no valid YAML"),
        ("a:\n\tb: 1\n", "s.yaml:2:1: found no valid YAML"),
        ("a: 1\nb: \x07\n", "s.yaml:2: found a control character"),
        ("a: [1, 2\n", "no valid YAML"),
        ("[" + "1," * (NODE_LIMIT + 1) + "]", "values"),
    ],
)
def test_what_scenes_do_without_is_refused_with_its_place(text: str, words: str) -> None:
    assert words in problem(text)


def test_aliases_cannot_multiply() -> None:
    bomb = "a0: &a0 [1,1,1,1,1,1,1,1,1,1]\n"
    for level in range(1, 12):
        bomb += f"a{level}: &a{level} [{','.join([f'*a{level - 1}'] * 10)}]\n"
    assert f"more than {NODE_LIMIT} values" in problem(bomb)


def test_a_file_that_is_too_large_is_refused_unread(tmp_path: Path) -> None:
    path = tmp_path / "huge.yaml"
    with path.open("wb") as stream:
        stream.truncate(10**9)
    with pytest.raises(SceneError, match=f"found 1000000000 bytes, expected a scene of at most {SIZE_LIMIT}"):
        read_yaml(path)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"\x89PNG\r\n\x1a\n\x00", "scene.yaml:1: found byte 0x89, expected text in UTF-8"),
        ("a: 1\nb: é\n".encode("latin-1"), "scene.yaml:2: found byte 0xe9"),
        ("a: 1".encode("utf-16"), "found byte 0xff"),
    ],
)
def test_a_file_that_is_no_utf_8_gets_one_line(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "scene.yaml"
    path.write_bytes(content)
    with pytest.raises(SceneError) as caught:
        read_yaml(path)
    assert len(caught.value.problems) == 1
    assert words in caught.value.problems[0]


def test_missing_files_directories_and_pipes_are_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="No such file"):
        read_yaml(tmp_path / "absent.yaml")
    with pytest.raises(SceneError, match="found a directory"):
        read_yaml(tmp_path)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(SceneError, match="no regular file"):
        read_yaml(tmp_path / "pipe")


def test_a_byte_order_mark_is_no_part_of_the_first_key(tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_bytes(b"\xef\xbb\xbfa: 1\r\nb: 2\r\n")
    assert read_yaml(path).data == {"a": 1, "b": 2}
