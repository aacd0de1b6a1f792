"""What a sweep goes over."""

from __future__ import annotations

import pytest

from packgen.errors import PackgenError
from packgen.sweep.over import parse_over, runs_over


def values(text):
    return list(parse_over(text).values)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("seed=0:3", ["0", "1", "2", "3"]),
        ("seed=4:4", ["4"]),
        ("seed=0:10:4", ["0", "4", "8"]),
        ("gravity=0.1:0.3:0.1", ["0.1", "0.2", "0.3"]),
        ("gravity=-1:1:0.5", ["-1", "-0.5", "0", "0.5", "1"]),
        ("seed=0:1e1:5", ["0", "5", "10"]),
        ("materials.glass.friction=0.1, 0.3", ["0.1", "0.3"]),
        ("seed=3,1,3", ["3", "1"]),
        ("particle_sets[0].radius=5 mm,6 mm", ["5 mm", "6 mm"]),
        ("container.box.max=[1, 1, 1],[1, 1, 2]", ["[1, 1, 1]", "[1, 1, 2]"]),
        ("zones[0]={n_particles: 3},{mass: 1}", ["{n_particles: 3}", "{mass: 1}"]),
        ('container.path="a,b.stl",c.stl', ['"a,b.stl"', "c.stl"]),
    ],
)
def test_values_are_a_list_or_a_range_with_both_ends(text, found):
    assert values(text) == found


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("seed", "--over: found 'seed', expected KEY=VALUES"),
        ("seed=", "--over: found 'seed=', expected KEY=VALUES"),
        ("=1", "--over: found '=1', expected KEY=VALUES"),
        ("seed=9:0", "--over seed: found 9:0, expected the lower end first, 0:9"),
        ("seed=0:9:0", "--over seed: found 0:9:0, expected a step greater than 0"),
        ("seed=0:x", "--over seed: found '0:x', expected a range of numbers"),
        ("gravity=0.5:1", "--over gravity: found 0.5:1, expected a step as well"),
        ("seed=0:1000000", "expected at most 10,000 values, not 1,000,001"),
        ("seed=1,,2", "--over seed: found '1,,2', expected a value between the commas"),
        ("zones[0=1", "--over: found 'zones[0=1', expected KEY=VALUE"),
        ("zones=[1,2", "--over zones: found '[1,2', expected a value as YAML has it"),
    ],
)
def test_what_is_none_is_told_in_a_line(text, said):
    with pytest.raises(PackgenError) as caught:
        parse_over(text)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_combinations_are_named_by_the_ends_of_their_keys():
    runs = runs_over([parse_over("seed=0:1"), parse_over("materials.glass.friction=0.1,0.3")])
    assert [each.name for each in runs] == [
        "seed=0_friction=0.1", "seed=0_friction=0.3", "seed=1_friction=0.1", "seed=1_friction=0.3",
    ]  # fmt: skip
    assert runs[1].values == {"seed": "0", "materials.glass.friction": "0.3"}
    assert runs[1].label() == "seed=0 materials.glass.friction=0.3"


def test_names_of_keys_and_values_that_look_alike_differ():
    runs = runs_over([parse_over("particle_sets[0].radius=1,2"), parse_over("particle_sets[1].radius=1,2")])
    assert len({each.name for each in runs}) == 4
    runs = runs_over([parse_over("container.path=a/b.stl,a b.stl")])
    assert [each.name for each in runs] == ["0_path=a-b.stl", "1_path=a-b.stl"]


def test_a_key_comes_once_and_there_are_not_too_many_runs():
    with pytest.raises(PackgenError, match="--over seed: found the key twice"):
        runs_over([parse_over("seed=1"), parse_over("seed=2")])
    with pytest.raises(PackgenError, match="found 40,000 combinations, expected at most 10,000"):
        runs_over([parse_over("seed=1:200"), parse_over("gravity=1:200")])
