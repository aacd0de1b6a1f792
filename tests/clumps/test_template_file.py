from __future__ import annotations

import math
from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from packgen.bodies import Template
from packgen.clumps.template import template_of_spheres
from packgen.clumps.template_file import read_template, write_template
from packgen.errors import ReadError


def dumbbell() -> Template:
    return template_of_spheres("dumbbell", np.array([[1.0, 0.1, 0, 0.01], [1.02, 0.1, 0, 0.013]]))


def test_a_template_cannot_be_changed():
    template = dumbbell()
    with pytest.raises(ValueError, match="read-only"):
        template.spheres[0, 0] = 1.0
    with pytest.raises(FrozenInstanceError):
        template.volume = 1.0


def test_its_origin_is_the_centre_of_mass():
    template = dumbbell()
    x = template.spheres[:, 0]
    assert x[0] < 0.0 < x[1]
    np.testing.assert_allclose(template.place + template.spheres[0, :3], [1.0, 0.1, 0.0], atol=1e-15)
    assert template.reach == pytest.approx(max(-x[0] + 0.01, x[1] + 0.013))


def test_a_scaled_template_has_the_properties_of_its_larger_spheres():
    large = dumbbell().scaled(2.5)
    found = template_of_spheres("same", large.spheres)
    assert found.volume == pytest.approx(large.volume, rel=1e-9)
    np.testing.assert_allclose(found.inertia, large.inertia, atol=1e-9 * np.trace(large.inertia))


@pytest.mark.parametrize("name", ["dumbbell.csv", "dumbbell.txt"])
def test_a_file_gives_back_what_was_written_to_the_last_bit(name, tmp_path):
    template = dumbbell()
    write_template(tmp_path / name, template)
    found = read_template(tmp_path / name)
    for key in ("spheres", "inertia", "place"):
        np.testing.assert_array_equal(getattr(found, key), getattr(template, key))
    assert (found.volume, found.name) == (template.volume, "dumbbell")


def test_csv_has_chronos_line_on_top_and_other_files_liggghts_blanks(tmp_path):
    for name in ("a.csv", "a.txt"):
        write_template(tmp_path / name, dumbbell())
    assert (tmp_path / "a.csv").read_text().splitlines()[0] == "x,y,z,r"
    rows = [line for line in (tmp_path / "a.txt").read_text().splitlines() if not line.startswith("#")]
    assert [len(row.split(" ")) for row in rows] == [4, 4]
    assert all(math.isfinite(float(each)) for row in rows for each in row.split(" "))


def test_a_bare_list_gets_the_properties_of_the_union(tmp_path):
    path = tmp_path / "list.txt"
    path.write_text("# from elsewhere\n0 0 0 0.01\n\n0.02, 0, 0, 0.013 # second\n")
    found = read_template(path)
    assert found.volume == pytest.approx(dumbbell().volume, rel=1e-9)
    np.testing.assert_allclose(found.spheres, dumbbell().spheres, atol=1e-12)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "found no spheres"),
        ("1 2 3\n", r":1: found '1 2 3', expected four"),
        ("0 0 0 1\n1 2 3 x\n", r":2: found '1 2 3 x', expected four numbers"),
        ("0 0 0 nan\n", "four finite numbers"),
        ("0 0 0 -1\n", "found a radius of -1, expected one above 0"),
        ("# volume_m3: much\n0 0 0 1\n", r":1: found 'volume_m3: much'"),
        ("# volume_m3: 1\n# inertia_m5: 0 0 0 0 0 0\n0 0 0 1\n", "that no body has"),
    ],
)
def test_a_file_that_is_no_clump_is_refused_in_a_line(text, said, tmp_path):
    path = tmp_path / "wrong.txt"
    path.write_text(text)
    with pytest.raises(ReadError, match=said) as error:
        read_template(path)
    assert "\n" not in str(error.value)
    with pytest.raises(ReadError, match="no such file"):
        read_template(tmp_path / "none.txt")


def test_each_wrong_line_is_named_up_to_twenty_and_their_number(tmp_path):
    path = tmp_path / "wrong.txt"
    path.write_text("0 0 0 1\n" + "1 2 3 x\n" * 1000)
    with pytest.raises(ReadError) as error:
        read_template(path)
    lines = str(error.value).splitlines()
    assert [line.partition(": found")[0] for line in lines[:20]] == [f"{path}:{k}" for k in range(2, 22)]
    assert lines[20:] == [f"{path}: found 980 faults more, expected none"]
