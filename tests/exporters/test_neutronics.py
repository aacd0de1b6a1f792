"""Serpent's and OpenMC's files, read back by readers written from their manuals."""

from __future__ import annotations

import runpy
import sys
from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest
from pydantic import ValidationError

from exporters import openmc, serpent
from packgen.bed import with_images
from tests.beds import box_container, make_bed
from tests.exporters.test_vtk import mixed_bed


def read_pbed(folder):
    """Return the card's words, and centres, radii [cm] and universes of the file that it names."""
    lines = (folder / "bed.serpent").read_text().splitlines()
    (card,) = [line.split() for line in lines if not line.startswith("%")]
    assert card[0] == "pbed"
    rows = [line.split("\t") for line in (folder / card[3].strip('"')).read_text().splitlines()]
    assert {len(row) for row in rows} == {5}
    numbers = np.array([row[:4] for row in rows], dtype=float)
    return card, numbers[:, :3], numbers[:, 3], np.array([row[4] for row in rows])


def test_serpent_gets_centimetres_and_a_universe_a_set(tmp_path):
    bed = mixed_bed()
    serpent.write(bed, tmp_path, serpent.Options(universe="u_core", background="flibe"))
    card, centre, radius, universe = read_pbed(tmp_path)
    assert card[1:3] == ["u_core", "flibe"]
    assert np.allclose(centre / 100, bed.position, rtol=1e-15, atol=0)
    assert np.allclose(radius / 100, bed.radius, rtol=1e-15, atol=0)
    assert np.array_equal(universe, np.array(["u_a", "u_b"])[bed.set_index])
    told = (tmp_path / "bed.serpent").read_text()
    assert "% to be defined: u_a, u_b, flibe, and a cell with fill u_core" in told


def test_universes_are_words_that_differ():
    assert serpent.universes(["a b", "a.b", "0"]) == ["u_a_b", "u_a_b_1", "u_0"]
    with pytest.raises(ValidationError):
        serpent.Options(universe="0")


def test_a_set_called_bed_is_not_filled_with_the_bed_itself(tmp_path):
    sets = mixed_bed().particle_sets
    named = (replace(sets[0], name="bed"), replace(sets[1], name="background"))
    serpent.write(replace(mixed_bed(), particle_sets=named), tmp_path, serpent.Options())
    card, _, _, universe = read_pbed(tmp_path)
    assert card[1:3] == ["u_bed", "u_background"]
    assert set(universe) == {"u_bed_0", "u_background_1"}


def test_no_two_universes_are_one_though_a_name_has_a_number_already():
    assert len(set(serpent.universes(["a_b_2", "a_b", "a.b", "a-b"]))) == 4


def periodic_bed():
    box = box_container((0, 0, 0), (4, 4, 4), (True, True, False))
    return make_bed(
        [[0.2, 0.1, 2], [3.9, 2, 2], [2, 2, 2]],
        0.5,
        box,
        set_index=[1, 0, 1],
        particle_sets=mixed_bed(2).particle_sets,
    )


@pytest.mark.parametrize("module", [serpent, openmc])
def test_spheres_across_a_seam_are_there_on_both_sides(tmp_path, module):
    bed = periodic_bed()
    module.write(bed, tmp_path, module.Options())
    if module is serpent:
        _, centre, _, universe = read_pbed(tmp_path)
        second = universe == "u_b"
    else:
        rows = np.loadtxt(tmp_path / "spheres.csv", delimiter=",", skiprows=1)
        centre, second = rows[:, :3], rows[:, 4] == 1
    position, _ = with_images(bed)
    assert len(centre) == len(position) == 3 + 3 + 1
    assert np.allclose(np.sort(centre, axis=0) / 100, np.sort(position, axis=0))
    assert second.sum() == 5


def test_openmcs_module_makes_a_lattice_of_all_spheres(tmp_path, monkeypatch):
    """A recorder in the place of openmc has the signatures of its manual."""
    bed = mixed_bed(300)
    calls = []
    model = ModuleType("openmc.model")

    class TRISO:
        def __init__(self, outer_radius, fill, center=(0.0, 0.0, 0.0)):
            calls.append((outer_radius, fill, *center))

    def create_triso_lattice(trisos, lower_left, pitch, shape, background):
        return trisos, lower_left, pitch, shape, background

    model.TRISO, model.create_triso_lattice = TRISO, create_triso_lattice
    package = ModuleType("openmc")
    package.model = model
    monkeypatch.setitem(sys.modules, "openmc", package)
    monkeypatch.setitem(sys.modules, "openmc.model", model)
    openmc.write(bed, tmp_path, openmc.Options())
    made = runpy.run_path(str(tmp_path / "bed.py"))
    trisos, lower_left, pitch, shape, background = made["lattice"]({"a": "fuel", "b": "graphite"}, "salt")
    assert (len(trisos), background) == (300, "salt")
    assert np.allclose([call[2:] for call in calls], 100 * bed.position)
    assert np.allclose([call[0] for call in calls], 100 * bed.radius)
    assert [call[1] for call in calls] == np.array(["fuel", "graphite"])[bed.set_index].tolist()
    assert np.allclose(np.array(lower_left) + np.array(pitch) * shape, 300.0)
    assert min(pitch) >= 3 * 200 * bed.radius.max()
