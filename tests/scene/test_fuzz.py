# ruff: noqa: E501 (the scene that is changed is easier to read as a table)
"""Whatever text comes in, a valid scene or a clean message comes out."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

from packgen.errors import SceneError
from packgen.scene import Scene, load_scene
from packgen.supply.supply import Supply

VALID: dict[str, Any] = {
    "container": {"box": {"min": [0, 0, 0], "max": [1, 1, "2 m"]}, "periodic": ["x"]},
    "gravity_axis": "z", "gravity": 9.81, "seed": 3, "algorithm": "COLLECTIVE_ARRANGEMENT",
    "params": {"optimizer": "adam", "batch_size": 500, "lr": 0.01, "tolerance": None},
    "particle_sets": [
        {"name": "a", "radius_distribution": "uniform", "radius_min": 0.1, "radius_max": 0.2, "material": "ore"},
        {"radius_distribution": "lognormal", "radius_median": "1 cm", "sigma": 0.2, "density": "3 g/cm3"},
        {"radius_distribution": "rosin_rammler", "radius_63": 0.02, "exponent": 2, "radius_min": 0.01, "radius_max": 1},
        {"radius_distribution": "sieve", "diameters": [0.1, 0.2, 0.4], "passing": [0.1, 0.5, 1]},
        {"radius_distribution": "discrete", "radii": [0.1, 0.2], "fractions": [0.5, 0.5], "by": "mass"},
        {"radius_distribution": "normal", "radius_mean": 0.1, "radius_std_dev": 0.01},
    ],
    "materials": {"ore": {"youngs_modulus": 1e8, "friction": 0.5}},
    "zones": [
        {"n_particles": 20, "set_proportions": [0.5, 0, 0.1, 0.1, 0.1, 0.2], "proportions_by": "mass"},
        {"volume": 0.5, "location": {"slice": {"axis": 2, "min_bound": 0, "max_bound": 1}}},
        {"location": {"cone": {"radius_bottom": 1, "radius_top": 0, "height": 1}}},
    ],
    "validation": {"lost_limit": 1},
}  # fmt: skip

WORDS = [
    "container",
    "path",
    "box",
    "min",
    "radius_distribution",
    "uniform",
    "file",
    "zones",
    "- ",
    ": ",
    "\n",
    "  ",
]
SCALARS = (
    st.none()
    | st.booleans()
    | st.integers(-5, 5)
    | st.sampled_from([10**400, -(2**70), 1e-320, 1e308, -0.0])
    | st.floats()
    | st.text(max_size=12)
    | st.sampled_from(["12 mm", "0 m", "x", "z", ".", "mass", "'", '"', "\n", "${x}", "1e5 km", "uniform"])
)
ANYTHING = st.recursive(SCALARS, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=3), max_leaves=5)  # fmt: skip
QUICK = hypothesis.settings(
    max_examples=150,
    deadline=None,
    derandomize=True,
    suppress_health_check=[hypothesis.HealthCheck.function_scoped_fixture],
)


def load(folder: Path, content: bytes) -> Scene | None:
    """Return the scene, or None for a clean message; anything else fails."""
    path = folder / "scene.yaml"
    path.write_bytes(content)
    try:
        return load_scene(path)
    except SceneError as error:
        problems = error.problems
    assert problems
    for problem in problems:
        assert problem.isprintable()
        assert problem.startswith(str(path))
        assert "expected" in problem
        assert len(problem) < 1200
    return None


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the paths of everything in plain data."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(place for key, inner in items for place in places(inner, (*path, key)))]


@QUICK
@hypothesis.given(
    st.binary(max_size=200) | st.text(max_size=200).map(lambda text: text.encode("utf-8", "replace"))
)
def test_any_bytes_end_in_a_clean_message(tmp_path: Path, content: bytes) -> None:
    assert load(tmp_path, content) is None


@QUICK
@hypothesis.given(st.lists(st.sampled_from([*WORDS, "{", "}", "[", "]", ",", "&a ", "*a", "!!x ", "|", ">", "'", "0"]), max_size=40))  # fmt: skip
def test_any_heap_of_yaml_tokens_ends_in_a_clean_message(tmp_path: Path, tokens: list[str]) -> None:
    assert load(tmp_path, "".join(tokens).encode()) is None


@hypothesis.settings(QUICK, max_examples=400)
@hypothesis.given(
    st.sampled_from(places(VALID)[1:]), st.sampled_from(["replace", "drop", "rename"]), ANYTHING
)
def test_a_scene_with_one_thing_changed_is_valid_or_refused(
    tmp_path: Path, place: tuple[Any, ...], change: str, value: Any
) -> None:
    data = copy.deepcopy(VALID)
    parent = data
    for part in place[:-1]:
        parent = parent[part]
    if change == "replace":
        parent[place[-1]] = value
    elif change == "drop" or not isinstance(parent, dict):
        del parent[place[-1]]
    else:
        parent[json.dumps(value)[:20]] = parent.pop(place[-1])
    scene = load(tmp_path, json.dumps(data).encode())
    if scene is not None:
        json.dumps(scene.model_dump(), allow_nan=False)
        for each in scene.particle_sets:
            low, high = each.distribution.radius_bounds
            assert 0.0 < low <= high < np.inf


def test_the_scene_that_is_changed_is_valid(tmp_path: Path) -> None:
    scene = load(tmp_path, json.dumps(VALID).encode())
    assert scene is not None
    supplies = [Supply(zone, scene.particle_sets, np.random.default_rng(0)) for zone in scene.zones]
    assert supplies[0].asked == 20
    assert supplies[2].asked is None


@pytest.mark.parametrize("cut", range(20, 600, 29))
def test_a_scene_cut_short_is_refused(tmp_path: Path, cut: int) -> None:
    assert load(tmp_path, json.dumps(VALID).encode()[:cut]) is None
