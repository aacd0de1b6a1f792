"""Claims on classes and files of radii."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from packgen.distributions import Discrete, Listed, ParameterError


def test_classes_by_mass_hold_their_mass() -> None:
    radius = Discrete([0.1, 0.05, 0.02], [0.5, 0.3, 0.2], by="mass").sample(np.random.default_rng(0), 50_000)
    mass = [(radius[radius == each] ** 3).sum() / (radius**3).sum() for each in (0.1, 0.05, 0.02)]
    assert mass == pytest.approx([0.5, 0.3, 0.2], abs=2e-3)


def test_classes_by_number_are_rounded_up_or_down() -> None:
    radius = Discrete([0.1, 0.05, 0.02], [0.5, 0.3, 0.2]).sample(np.random.default_rng(0), 101)
    counts = [int((radius == each).sum()) for each in (0.1, 0.05, 0.02)]
    assert sum(counts) == 101
    assert np.abs(np.array(counts) - [50.5, 30.3, 20.2]).max() < 1.0


def test_a_class_without_spheres_is_never_drawn() -> None:
    law = Discrete([0.1, 0.05, 0.02], [0.0, 1.0, 0.0])
    assert set(law.sample(np.random.default_rng(0), 1000)) == {0.05}
    assert law.radius_bounds == (0.05, 0.05)


def test_a_list_gives_each_sphere_once_before_any_again() -> None:
    listed = Listed(np.array([0.3, 0.1, 0.2]))
    drawn = listed.sample(np.random.default_rng(0), 8)
    assert sorted(listed.sample(np.random.default_rng(0), 3)) == [0.1, 0.2, 0.3]
    assert {int((drawn == each).sum()) for each in (0.1, 0.2, 0.3)} == {2, 3}


@pytest.mark.parametrize(
    "text",
    [
        "0.1\n0.2\n\n",
        "# two spheres\r\n1e-1 # the first\r\n 0.2\r\n",
        "radius\n0.1\n0.2\n",
        "id,radius,density\n1,0.1,2500\n2,0.2,2500\n",
        '"Radius";"x"\n0.1;0\n0.2;0\n',
        "\ufeffx\tradius\n0\t0.1\n0\t0.2\n",
    ],
)
def test_radii_are_read_from_lines_or_from_a_column(tmp_path: Path, text: str) -> None:
    path = tmp_path / "radii.txt"
    path.write_text(text, encoding="utf-8", newline="")
    assert Listed.from_file(path).radius.tolist() == [0.1, 0.2]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "without a radius"),
        (b"# nothing\n", "without a radius"),
        (b"radius\n", "without radii"),
        (b"0.1\nabc\n", "'abc' in .*:2"),
        (b"0.1\n0\n", "'0' in .*:2"),
        (b"0.1\nnan\n", "'nan' in .*:2"),
        (b"inf\n", "'inf' in .*:1"),
        (b"a,b\n1,2\n", "columns a, b.*a column called radius"),
        (b"a,radius\n1\n", "'' in .*:2"),
        (b"\x89PNG\xff\n", "no text"),
    ],
)
def test_a_bad_line_is_named(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "radii.txt"
    path.write_bytes(content)
    with pytest.raises(ParameterError, match=words):
        Listed.from_file(path)
