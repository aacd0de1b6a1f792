from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from packgen.bed import Material, ParticleSet
from packgen.measure.structure import friction_table, pair_contacts, structure_of
from packgen.programmes.forces import FIXED
from tests.beds import box_container, cubic_lattice, fcc_lattice, make_bed


def test_every_pair_and_wall_is_a_contact_with_its_direction():
    bed = make_bed([[1, 1, 1], [1, 1, 3]], 1.0, box_container([0, 0, 0], [4, 4, 9]))
    structure = structure_of(bed, 1e-6)
    assert list(zip(structure.first, structure.second, strict=True)) == [
        (0, 1), (0, FIXED), (1, FIXED), (0, FIXED), (1, FIXED), (0, FIXED),
    ]  # fmt: skip
    assert structure.normal[[0, 1, 3, 5]].tolist() == [[0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]]
    assert structure.weight[0] == pytest.approx([0, 0, -9.81 * 2500 * 4 / 3 * np.pi])


@pytest.mark.parametrize("shift", [0.0, 0.13, -7.7])
def test_contacts_across_seams_are_those_within(shift):
    container = box_container([0, 0, 0], [0.8] * 3, (True, True, True))
    bed = make_bed((cubic_lattice(4, 0.1) + shift) % 0.8, 0.1, container)
    structure = structure_of(bed, 1e-6)
    assert len(structure.first) == 3 * 64
    assert np.abs(structure.normal).max(axis=1) == pytest.approx(1.0)


@pytest.mark.parametrize(("cells", "pairs"), [(1, 3), (2, 24)])
def test_a_sphere_touches_both_images_of_its_neighbour_and_its_own(cells, pairs):
    edge = 0.2 * cells
    position = cubic_lattice(cells, 0.1)
    first, second, normal = pair_contacts(position, np.full(cells**3, 0.1), (edge, edge, edge), 1e-6)
    assert len(first) == pairs
    # Each sphere has one neighbour in each of the six directions.
    ends = np.concatenate([np.column_stack([first, normal]), np.column_stack([second, -normal])])
    assert len(np.unique(np.round(ends, 6) + 0.0, axis=0)) == 6 * cells**3


def test_spheres_around_chosen_ones_are_fixed():
    bed = make_bed(fcc_lattice(3, 0.1), 0.1, box_container([0, 0, 0], [1, 1, 1], (True, True, True)))
    inside = (np.abs(bed.position - 0.42) < 0.2).all(axis=1)
    structure = structure_of(bed, 1e-6, inside)
    assert structure.count == inside.sum()
    ends = np.bincount(structure.first, minlength=structure.count)
    ends += np.bincount(structure.second[structure.second != FIXED], minlength=structure.count)
    assert (ends == 12).all()


def test_frictions_of_two_materials_are_the_decks_means():
    bed = make_bed([[1, 1, 1], [1, 1, 3]], 1.0, box_container([0, 0, 0], [4, 4, 9]))
    bed = replace(
        bed,
        materials=(
            Material("ore", friction=0.6),
            Material("ice", friction=0.2),
            Material("oil", friction=0.0),
        ),
        particle_sets=(ParticleSet("one", 1.0, "ore"), ParticleSet("two", 1.0, "ice")),
        set_index=np.array([0, 1], np.int32),
        wall_material="oil",
    )
    assert friction_table(bed)[0] == pytest.approx([0.6, 0.3, 0.0])
    assert structure_of(bed, 1e-6).friction[:2] == pytest.approx([0.3, 0.0])
