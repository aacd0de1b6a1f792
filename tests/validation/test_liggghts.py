from __future__ import annotations

import json
import shutil

import numpy as np
import pytest

from exporters import liggghts
from packgen.errors import SolverError
from packgen.geometry import Cone, Mesh, Polyhedron
from packgen.validation import Limits, predicted_forces, validate, validation_dict
from packgen.validation.lammps_family import SPHERES_LEAST
from tests import container_meshes as meshes
from tests.beds import box_container, make_bed, make_container, revolved_surface
from tests.exporters.beds import RADIUS, lattice
from tests.scenes import constant, read_scene

pytestmark = [
    pytest.mark.solver,
    pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed"),
]
SHORT = Limits(free_fall_times=0.5)


def judge(bed, folder, limits=SHORT, **options):
    folder.mkdir(exist_ok=True)
    liggghts.write(bed, folder, liggghts.Options(**options))
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    report = validate(bed, folder, limits=limits)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    json.dumps(validation_dict({"liggghts": report}), allow_nan=False)
    return report


def cylinder_bed(shape_of, overlap):
    """Two spheres in a drum: one at the side and one at the bottom, both ``overlap`` radii in the wall."""
    surface = revolved_surface([(0, 4), (4, 4)], 64)
    depth = 1 - overlap
    apothem = 4 * np.cos(np.pi / 64)
    distance = 4 if isinstance(shape_of(surface), Cone) else apothem
    angle = np.pi / 64  # the middle of a facet
    side = (distance - depth) * np.array([np.cos(angle), np.sin(angle), 0]) + [0, 0, 2]
    container = make_container(shape_of(surface), surface, 1.0)
    return make_bed([side, [0.1, -0.9, depth]], 1.0, container)


def drum(_surface):
    return Cone(np.zeros(3), np.array([0.0, 0.0, 1.0]), 4.0, 4.0, 4.0)


def test_touching_spheres_pass(tmp_path):
    report = judge(lattice(), tmp_path / "deck", Limits(still_speed=0.0))
    assert report.missed == ()
    assert report.gravity_run.free_fall_times == pytest.approx(20, rel=1e-3)
    assert report.gravity_run.timestep_rayleigh == pytest.approx(0.1)
    assert report.gravity_run.sinking < 1e-3
    assert "3.8" in report.version


@pytest.mark.parametrize("walls", ["auto", "mesh"])
def test_a_planted_overlap_is_measured_and_its_force_predicted(tmp_path, walls):
    bed = lattice(overlap=0.01)
    report = judge(bed, tmp_path / "deck", walls=walls)
    zero, predicted = report.step_zero, predicted_forces(bed)
    assert zero.pair_overlap_max == pytest.approx(0.01, rel=1e-9)
    assert zero.wall_overlap_max == pytest.approx(0.01, rel=1e-9)
    assert zero.pair_force_max == pytest.approx(predicted.pair_force_max, rel=1e-9)
    assert zero.wall_force_max == pytest.approx(predicted.wall_force_max, rel=1e-9)
    assert zero.pair_count == predicted.pair_count
    assert zero.wall_count == 2 * (4 * 4 + 2 * 4 * 5)
    assert zero.law_error < 1e-9
    assert any("largest step-0 force" in line and "and the wall" in line for line in report.missed)


def test_contacts_of_a_wide_range_of_sizes_are_all_seen(tmp_path):
    position = [[2, 2, 2], [2, 2, 3.199], [4, 2, 2.05], [2, 3.049, 2]]
    bed = make_bed(position, [1.0, 0.2, 0.05, 0.05], box_container((0, 0, 0), (5, 5, 5)))
    zero = judge(bed, tmp_path / "deck").step_zero
    assert zero.pair_count == predicted_forces(bed).pair_count == 2
    assert zero.pair_force_max == pytest.approx(predicted_forces(bed).pair_force_max, rel=1e-9)


@pytest.mark.parametrize(
    "shape_of", [drum, Mesh, lambda s: Polyhedron(*_planes(s), s)], ids=["cylinder", "mesh", "planes"]
)
def test_overlap_with_a_curved_wall_is_measured(tmp_path, shape_of):
    report = judge(cylinder_bed(shape_of, 1e-3), tmp_path / "deck")
    zero = report.step_zero
    assert zero.wall_overlap_max == pytest.approx(1e-3, rel=1e-6)
    assert zero.wall_count == 2
    assert zero.law_error < 1e-6
    assert zero.wall_force_max == pytest.approx(zero.predicted_force_max, rel=1e-6)


def test_a_sphere_at_the_side_of_a_cone_with_a_narrow_tip_has_one_contact(tmp_path):
    surface = revolved_surface([(0, 0.02), (1.8, 0.812)], 96)
    angle, slope, depth = np.pi / 96, 0.44 * np.cos(np.pi / 96), 0.1 * (1 - 1e-3)
    across = 0.02 * np.cos(angle) + slope * 0.6 - depth * np.hypot(1, slope)
    position = [across * np.cos(angle), across * np.sin(angle), 0.6]
    bed = make_bed([position], 0.1, make_container(Mesh(surface), surface, 1.0))
    zero = judge(bed, tmp_path / "deck", Limits(free_fall_times=0.01)).step_zero
    assert zero.wall_count == 1
    assert zero.wall_overlap_max == pytest.approx(1e-3, rel=1e-6)
    assert zero.law_error < 1e-6


@pytest.mark.parametrize(
    ("corner", "away"),
    [
        ([0.8, 0.0, 1.9], [-0.8, 0.5, 0.3]),
        ([0.0, -0.8, 1.9], [0.1, 0.2, 1.0]),
        ([-0.8, 0.0, 0.1], [0.3, 0.6, -0.7]),
    ],
)
def test_a_sphere_at_the_corner_of_a_baffle_of_long_facets_has_its_contact(tmp_path, corner, away):
    meshes.saved(meshes.tank(open_top=True), tmp_path)
    _, container = read_scene(tmp_path, {"path": "vessel.stl"}, constant(0.05))
    depth = 0.05 * (1.0 - 1e-3)
    position = np.array(corner) + depth * np.array(away) / np.linalg.norm(away)
    bed = make_bed([position], 0.05, container)
    zero = judge(bed, tmp_path / "deck", Limits(free_fall_times=0.01)).step_zero
    assert zero.wall_count == 1
    assert zero.wall_force_max == pytest.approx(predicted_forces(bed).wall_force_max, rel=1e-6)


def _planes(surface):
    corners = surface.vertices[surface.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return normal, np.einsum("ij,ij->i", normal, corners[:, 0])


@pytest.mark.parametrize("walls", ["auto", "mesh"])
def test_a_sphere_beyond_the_wall_is_found_and_named(tmp_path, walls):
    bed = lattice()
    position = bed.position.copy()
    position[7] = [-1.5 * RADIUS, RADIUS, RADIUS]
    report = judge(make_bed(position, RADIUS, bed.container), tmp_path / "deck", Limits(), walls=walls)
    assert report.step_zero.outside_count == 1
    assert report.step_zero.worst_outside == 7
    assert report.gravity_run.lost == (7,)
    assert any("spheres lost: 1" in line and "(sphere 7)" in line for line in report.missed)


def test_a_bed_that_ends_liggghts_is_told_with_the_sphere_to_blame(tmp_path):
    bed = lattice((2, 2, 2))
    position = bed.position.copy()
    position[3, 2] = 0.0  # the centre on the plane of the floor: LIGGGHTS divides by zero
    with pytest.raises(SolverError, match=r"at step 0: largest force nan W \(sphere 3 and the wall\)"):
        judge(make_bed(position, RADIUS, bed.container), tmp_path / "deck", walls="mesh")


def test_a_loose_bed_misses_the_displacement(tmp_path):
    rng = np.random.default_rng(2)
    grid = np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    position = (grid + 0.5 + rng.uniform(-0.1, 0.1, grid.shape)) * 3 * RADIUS
    report = judge(
        make_bed(position, RADIUS, box_container((0, 0, 0), [12 * RADIUS] * 3)), tmp_path / "deck", Limits()
    )
    assert report.step_zero.force_max == 0
    # 20 draws: 4.23 +- 0.09 and 0.690 +- 0.015
    assert report.gravity_run.displacement_mean > 3.8
    assert report.gravity_run.sinking > 0.62
    assert sum("mean displacement" in line or "centre of mass" in line for line in report.missed) == 2


def test_the_work_budget_ends_the_run_and_is_told(tmp_path):
    report = judge(lattice(), tmp_path / "deck", Limits(work_budget=SPHERES_LEAST * 50))
    assert report.gravity_run.steps == 50
    assert any("work budget reached" in row.value for row in report.rows())


def test_a_deck_of_another_bed_is_noticed(tmp_path):
    liggghts.write(lattice(overlap=1e-6), tmp_path, liggghts.Options())
    with pytest.raises(SolverError, match="the deck is not the bed's"):
        validate(lattice(), tmp_path, limits=SHORT)


def test_what_liggghts_refuses_is_quoted(tmp_path):
    liggghts.write(lattice(), tmp_path, liggghts.Options())
    text = (tmp_path / "in.bed").read_text()
    (tmp_path / "in.bed").write_text(text.replace("peratomtype 0.3", "peratomtype 0.6"))
    with pytest.raises(SolverError, match=r"poissonsRatio <= 0\.5 required") as caught:
        validate(lattice(), tmp_path, limits=SHORT)
    assert caught.value.exit_code == 1


def test_ids_lead_back_to_the_bed_whatever_the_order_of_the_dump(tmp_path):
    bed = lattice((3, 3, 3), overlap=1e-3)
    radius = bed.radius.copy()
    radius[20] *= 1.02
    report = judge(make_bed(bed.position, radius, bed.container), tmp_path / "deck")
    assert report.step_zero.worst_wall_sphere == 20
    assert 20 in report.step_zero.worst_pair
