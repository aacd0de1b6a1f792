"""The benchmarks' measures against closed forms."""

from __future__ import annotations

import importlib
import sys
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest
import trimesh

from exporters.fields.mesh_cells import planes_of
from packgen.check import check_bed
from tests.beds import box_container, make_bed

# The scripts' own helpers, as the scripts themselves find them.
sys.path.append(str(Path(__file__).resolve().parent / "benchmarks"))
homogeneity = importlib.import_module("homogeneity")
pour = importlib.import_module("pour")
settled = importlib.import_module("settled")


def test_a_mixtures_mean_sphere_and_number_are_those_of_its_masses():
    script = importlib.import_module("mixtures")
    half = script.Mixture("", (0.002, 0.001), (0.5, 0.5))
    # One large sphere to eight small ones: two volumes of the large one in nine spheres.
    assert half.radius_mean == pytest.approx(0.002 * (2.0 / 9.0) ** (1.0 / 3.0))
    assert half.share_large == 0.5
    equal = script.Mixture("", (script.LARGE,), (1.0,))
    solid = equal.count(10.0) * 4.0 / 3.0 * np.pi * script.LARGE**3
    room = 10.0 * script.ACROSS**2 * script.LARGE**3
    assert solid / room == pytest.approx(script.FRACTION, abs=0.005)


@pytest.mark.parametrize("waist", [0.0, 0.02])
def test_the_vessels_of_facets_are_closed_and_about_as_large_as_the_cylinder(tmp_path, waist):
    script = importlib.import_module("facets")
    count = script.write_mesh(tmp_path / "vessel.stl", 20_000, waist)
    mesh = trimesh.load(tmp_path / "vessel.stl")
    assert count == len(mesh.faces) == pytest.approx(20_000, rel=0.02)
    assert mesh.is_watertight
    assert mesh.is_convex == (waist == 0.0)
    assert mesh.volume == pytest.approx(np.pi * script.RADIUS**2 * script.HEIGHT, rel=0.005)


@pytest.mark.parametrize("kind", ["hexahedron", "tetra"])
def test_the_cells_of_export_speeds_meshes_fill_the_box(tmp_path, kind):
    script = importlib.import_module("export_speed")
    bed = script.lattice(1000, seed=0)
    mesh = meshio.read(script.cfd_mesh(bed, kind, tmp_path / "mesh.vtu"))
    corners = mesh.points[mesh.cells[0].data]
    volume = planes_of(kind, corners).volume
    assert volume.min() > 0.0
    assert volume.sum() == pytest.approx(np.prod(bed.container.bounds[1] - bed.container.bounds[0]))


def test_slices_cut_circles_of_the_exact_area():
    bed = make_bed([[1, 1, 1.3], [3, 1, 1.9]], [1.0, 0.5], box_container((0, 0, 0), (4, 2, 4)))
    height = np.linspace(0.0, 4.0, 4001)
    fraction = homogeneity.slice_fractions(bed, height)
    at = {level: fraction[round(1000 * level)] for level in (1.3, 1.9, 0.7, 2.5)}
    assert at[1.3] == pytest.approx(np.pi / 8)
    assert at[1.9] == pytest.approx(np.pi * (1 - 0.36 + 0.25) / 8)
    assert at[0.7] == pytest.approx(np.pi * 0.64 / 8)
    assert at[2.5] == 0.0
    volume = 8.0 * fraction.sum() * 1e-3
    assert volume == pytest.approx(4 / 3 * np.pi * 1.125, rel=1e-5)


def test_a_planted_wave_is_found_at_its_period_and_nowhere_else():
    height = np.linspace(0.0, 10.0, 5000)
    fraction = 0.6 + 0.001 * height + 0.007 * np.cos(2 * np.pi * height / 0.4 + 1.0)
    found = homogeneity.amplitude_at(height, fraction, np.array([0.4, 0.5, 0.3]))
    assert found[0] == pytest.approx(0.007, rel=1e-3)
    assert found[1:].max() < 1e-4


def test_the_layer_period_is_the_rise_of_the_layers():
    rng = np.random.default_rng(0)
    layer = np.repeat(np.arange(30), 200)
    position = np.column_stack([*rng.random((2, 6000)), 0.1 * layer + 0.1 * rng.random(6000)])
    bed = make_bed(position, 0.01, box_container((0, 0, 0), (1, 1, 4)), batch_index=layer.astype(np.int32))
    assert homogeneity.layer_period(bed) == pytest.approx(0.1, rel=1e-2)


def test_dense_crystals_count_as_crystal_up_to_their_walls_and_random_points_do_not():
    steps = np.arange(8)
    cubic = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    dense = cubic[cubic.sum(axis=1) % 2 == 0] / np.sqrt(2.0)  # face-centred cubic, spheres of diameter 1
    crystal = homogeneity.crystalline(dense, 1.0)
    inner = ((dense > 0.5) & (dense < 4.5)).all(axis=1)
    face = (np.abs(dense[:, 2]) < 0.1) & ((dense[:, :2] > 1.2) & (dense[:, :2] < 3.8)).all(axis=1)
    assert inner.sum() > 50
    assert face.sum() > 4
    assert crystal[inner].all()
    assert crystal[face].all() or not crystal[face].any()  # a square face has eight neighbours, all alike
    assert homogeneity.crystalline(np.random.default_rng(1).random((3000, 3)) * 13, 1.0).mean() < 0.02
    turned = dense @ np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    assert np.array_equal(homogeneity.crystalline(turned, 1.0), crystal)


def test_a_trimmed_bed_touches_without_overlap_and_shrinks_by_its_overlaps_at_most():
    rng = np.random.default_rng(3)
    bed = make_bed(1.0 + 4.0 * rng.random((60, 3)), 0.6, box_container((0.5, 0.5, 0.5), (5.5, 5.5, 5.5)))
    smaller = settled.trimmed(bed)
    before, after = check_bed(bed), check_bed(replace(smaller, tolerance=0.0))
    assert before.overlap_max > 0.1
    assert after.overlap_max == after.wall_overlap_max == 0.0
    assert (smaller.radius > 0).all()
    assert (smaller.radius <= bed.radius).all()
    free = np.setdiff1d(np.arange(60), np.concatenate(settled._contacts(bed)[:2]))
    inside = ((bed.position > 1.1) & (bed.position < 4.9)).all(axis=1)
    assert smaller.radius[free[inside[free]]] == pytest.approx(0.6, rel=1e-9)


def test_the_seeds_that_liggghts_takes_are_different_primes():
    found = pour.primes_above(10_000, 3)
    assert found == [10007, 10009, 10037]
