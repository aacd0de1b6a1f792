"""The part of a bed inside or outside a closed mesh."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import pyvista
import trimesh

from packgen.bedfile import save_bed
from packgen.check import check_bed
from packgen.container import closed_mesh
from packgen.errors import GeometryError
from packgen.geometry import Ball, Cone, Mesh
from packgen.reading import read_bed, unknowns
from packgen.reshape.carve import Cut, carve_bed
from tests.beds import box_container, box_surface, cubic_lattice, make_bed, make_container
from tests.clump_beds import lattice_of_clumps
from tests.container_meshes import saved


def loaded(folder, mesh, name="part.stl"):
    return closed_mesh(folder / saved(mesh, folder, name), "m", "--inside")


def torus():
    """A ring of radius 1 and thickness 0.8, coarse."""
    return trimesh.creation.torus(1.0, 0.4, major_sections=16, minor_sections=8)


def block(low, high):
    surface = box_surface(low, high)
    return trimesh.Trimesh(surface.vertices, surface.faces, process=False)


def scattered(count=400, radius=0.1):
    """Spheres of many sizes anywhere about a torus, for questions about sides alone."""
    rng = np.random.default_rng(1)
    position = rng.uniform((-1.6, -1.6, -0.6), (1.6, 1.6, 0.6), (count, 3))
    box = box_container((-2, -2, -1), (2, 2, 1))
    return make_bed(position, radius * rng.uniform(0.2, 1.0, count), box, tolerance=None)


def row(*places, radius=0.5, container=None, **changes):
    """Spheres along x at y = z = 2 in a box of 4."""
    position = [[x, 2.0, 2.0] for x in places]
    return make_bed(position, radius, container or box_container((0, 0, 0), (4, 4, 4)), **changes)


def test_whole_bodies_or_parts_of_them_are_told_by_exact_distances_to_a_mesh_that_is_not_convex(tmp_path):
    bed, mesh = scattered(), loaded(tmp_path, torus())
    faces = np.insert(mesh.surface.faces, 0, 3, axis=1)
    cloud = pyvista.PolyData(bed.position).compute_implicit_distance(
        pyvista.PolyData(mesh.surface.vertices, faces)
    )
    depth = -np.asarray(cloud["implicit_distance"])
    for inside in (True, False):
        signed = depth if inside else -depth
        for touching in (False, True):
            kept = carve_bed(bed, Cut(mesh, inside, touching)).source_index
            limit = -bed.radius if touching else bed.radius
            assert np.abs(signed - limit).min() > 1e-6  # no sphere is in doubt
            assert np.array_equal(kept, np.flatnonzero(signed > limit))


def test_each_sphere_is_in_one_of_two_parts(tmp_path):
    bed, mesh = scattered(), loaded(tmp_path, torus())
    for touching in (False, True):
        first = carve_bed(bed, Cut(mesh, True, touching)).source_index
        second = carve_bed(bed, Cut(mesh, False, not touching)).source_index
        assert np.array_equal(np.sort(np.concatenate([first, second])), np.arange(bed.count))


def test_a_sphere_that_only_touches_is_not_cut_and_rounding_does_not_count(tmp_path):
    mesh = loaded(tmp_path, block((1, 1, 1), (3, 3, 3)))
    bed = row(1.5 - 1e-8, 0.5 + 1e-8, 3.5, 2.5)
    assert carve_bed(bed, Cut(mesh, inside=True)).source_index.tolist() == [0, 3]
    assert carve_bed(bed, Cut(mesh, inside=False)).source_index.tolist() == [1, 2]
    assert carve_bed(bed, Cut(mesh, inside=True, touching=True)).source_index.tolist() == [0, 3]


def test_corners_are_round_for_spheres_outside(tmp_path):
    mesh = loaded(tmp_path, block((1, 1, 1), (3, 3, 3)))
    near = 3.0 + 0.9 * 0.5 / np.sqrt(3.0)
    away = 3.0 + 1.1 * 0.5 / np.sqrt(3.0)
    bed = make_bed([[near] * 3, [away] * 3], 0.5, box_container((0, 0, 0), (4, 4, 4)))
    assert carve_bed(bed, Cut(mesh, inside=False)).source_index.tolist() == [1]


def test_what_belongs_to_the_spheres_goes_with_them(tmp_path):
    bed = replace(
        row(0.5, 2.0, 3.5, container=box_container((0, 0, 0), (4, 4, 4))),
        zone_index=np.array([5, 6, 7], np.int32), batch_index=np.array([1, 2, 3], np.int32),
    )  # fmt: skip
    part = carve_bed(bed, Cut(loaded(tmp_path, block((1, 1, 1), (4, 3, 3))), inside=True)).bed
    assert (part.zone_index.tolist(), part.batch_index.tolist()) == ([6, 7], [2, 3])
    assert part.particle_sets == bed.particle_sets
    assert part.provenance["carved"] == {
        "mesh": "part", "side": "inside", "touching": False, "spheres_before": 3
    }  # fmt: skip


def test_a_clump_is_kept_or_left_as_a_whole(tmp_path):
    mesh = loaded(tmp_path, block((0, 0, 0), (2, 4, 4)))
    bed = row(0.5, 1.6, 2.6, 3.5, body_index=np.array([3, 8, 8, 9]))
    assert carve_bed(bed, Cut(mesh, inside=True)).source_index.tolist() == [0]
    assert carve_bed(bed, Cut(mesh, inside=True, touching=True)).source_index.tolist() == [0, 1, 2]
    assert carve_bed(bed, Cut(mesh, inside=False)).source_index.tolist() == [3]
    part = carve_bed(bed, Cut(mesh, inside=False, touching=True))
    assert part.source_index.tolist() == [1, 2, 3]
    assert part.bed.body_index.tolist() == [8, 8, 9]


def test_inside_a_mesh_the_mesh_is_the_container(tmp_path):
    bed = make_bed(cubic_lattice(8, 0.1), 0.1, box_container((0, 0, 0), (1.6, 1.6, 1.6)))
    core = trimesh.creation.cylinder(radius=0.5, height=1.2, sections=32)
    core.apply_translation((0.8, 0.8, 0.8))
    carved = carve_bed(bed, Cut(loaded(tmp_path, core), inside=True))
    assert carved.walls == "walls: part"
    assert carved.bed.container.volume == pytest.approx(core.volume)
    check = check_bed(carved.bed)
    assert check.within_tolerance
    assert check.outside_count == 0


@pytest.mark.parametrize("kind", ["box", "cylinder", "ball", "mesh"])
def test_outside_a_mesh_it_is_an_inner_wall_of_the_container(tmp_path, kind):
    radius, middle = 0.1, np.array([1.0, 1.0, 1.0])
    position = cubic_lattice(10, radius)
    vessels = {
        "box": box_container((0, 0, 0), (2, 2, 2)),
        "cylinder": round_container(Cone(np.array([1, 1, 0]), np.array([0, 0, 1]), 2.0, 1.0, 1.0), 2 * np.pi),
        "ball": round_container(Ball(middle, 1.0), 4 / 3 * np.pi),
        "mesh": make_container(
            Mesh(box_surface((0, 0, 0), (2, 2, 2))), box_surface((0, 0, 0), (2, 2, 2)), 8.0
        ),
    }
    bed = make_bed(position, radius, vessels[kind])
    bed = carve_bed(bed, Cut(loaded(tmp_path, fitted(vessels[kind])), inside=True)).bed
    bed = replace(bed, container=vessels[kind], provenance={})
    tunnel = torus()
    tunnel.apply_scale(0.5)
    tunnel.apply_translation(middle)
    mesh = loaded(tmp_path, tunnel)
    carved = carve_bed(bed, Cut(mesh, inside=False))
    assert 0 < carved.bed.count < bed.count
    assert carved.walls.startswith("walls: vessel, and part as an inner wall")
    assert carved.bed.container.volume == pytest.approx(vessels[kind].volume - mesh.volume)
    assert check_bed(carved.bed).within_tolerance
    inner = make_bed(middle + np.array([0.5, 0, 0]), radius, carved.bed.container)
    assert check_bed(inner).outside_count == 1
    across = make_bed(middle + np.array([0.5, 0, 0.23]), radius, carved.bed.container)
    assert check_bed(across).wall_overlap_max > 0.1
    beyond = make_bed([[2.2, 1.0, 1.0]], radius, carved.bed.container)
    assert check_bed(beyond).outside_count == 1


def round_container(shape, volume):
    from packgen.container.primitives import ball_surface, cone_surface

    surface = cone_surface(shape) if isinstance(shape, Cone) else ball_surface(shape)
    return make_container(shape, surface, volume)


def fitted(container):
    """A mesh a little within a container, so that a lattice is cut to it."""
    surface = container.surface
    middle = surface.vertices.mean(axis=0)
    return trimesh.Trimesh(middle + 0.97 * (surface.vertices - middle), surface.faces, process=False)


def test_a_borehole_may_reach_out_of_the_container(tmp_path):
    bed = make_bed(cubic_lattice(10, 0.1), 0.1, box_container((0, 0, 0), (2, 2, 2)))
    bore = block((0.8, 0.8, -1), (1.2, 1.2, 3))
    carved = carve_bed(bed, Cut(loaded(tmp_path, bore), inside=False))
    assert carved.bed.count == 1000 - 40
    assert carved.bed.container.volume == pytest.approx(8.0 - 2 * 0.16, rel=4e-3)
    assert "of whose volume 0.5" in carved.walls
    assert carved.bed.container.bounds[:, 2].tolist() == [-1, 3]  # solvers have to hold all of the walls
    assert check_bed(carved.bed).within_tolerance
    assert check_bed(make_bed([[1, 1, 1], [1, 1, 2.5]], 0.1, carved.bed.container)).outside_count == 2


def test_a_mesh_beside_the_container_is_no_wall(tmp_path):
    bed = row(1.0, 3.0)
    carved = carve_bed(bed, Cut(loaded(tmp_path, block((5, 5, 5), (6, 6, 6))), inside=False))
    assert carved.bed.container is bed.container
    assert carved.walls == "walls: vessel; part is beside it"
    assert carved.notes == ("--outside: all spheres are kept: each one lies wholly outside part",)


def test_walls_that_spheres_cross_are_no_walls(tmp_path):
    bed, mesh = row(1.0, 3.0), loaded(tmp_path, block((0, 0, 0), (1, 4, 4)))
    for inside in (True, False):
        carved = carve_bed(bed, Cut(mesh, inside, touching=True))
        assert carved.bed.container is bed.container
        assert carved.walls == "walls: those of the bed, for spheres cross part"


def test_images_across_a_seam_count_and_what_is_inside_is_moved_there(tmp_path):
    box = box_container((0, 0, 0), (4, 4, 4), (True, False, False))
    bed = row(0.5, 2.0, 3.5, container=box)
    mesh = loaded(tmp_path, block((-1, 1, 1), (1.1, 3, 3)))
    carved = carve_bed(bed, Cut(mesh, inside=True))
    assert carved.bed.position[:, 0].tolist() == [0.5, -0.5]
    assert carved.bed.container.periodic == (False, False, False)
    carved = carve_bed(bed, Cut(mesh, inside=False))
    assert carved.source_index.tolist() == [1]
    assert carved.bed.container is box
    assert "whose box wraps around; part is not made one" in carved.walls


def test_a_clump_across_a_seam_is_one_body(tmp_path):
    box = box_container((0, 0, 0), (4, 4, 4), (True, False, False))
    bed = row(3.8, 0.2, 2.0, container=box, radius=0.3, body_index=np.array([1, 1, 2]))
    carved = carve_bed(bed, Cut(loaded(tmp_path, block((3, 1, 1), (4.9, 3, 3))), inside=True))
    assert carved.bed.position[:, 0].tolist() == [3.8, 4.2]
    assert carve_bed(
        bed, Cut(loaded(tmp_path, block((3, 1, 1), (4, 3, 3))), inside=False)
    ).source_index.tolist() == [2]


def test_a_mesh_that_holds_a_sphere_and_its_image_is_refused(tmp_path):
    box = box_container((0, 0, 0), (4, 4, 4), (True, False, False))
    mesh = loaded(tmp_path, block((-1, 1, 1), (5, 3, 3)))
    with pytest.raises(GeometryError, match=r"holds sphere 0 and its image, .* repeat the bed first"):
        carve_bed(row(0.5, 2.0, container=box), Cut(mesh, inside=True))


def test_a_part_without_spheres_is_refused_with_both_places(tmp_path):
    mesh = loaded(tmp_path, block((5, 5, 5), (6, 6, 6)))
    with pytest.raises(
        GeometryError, match=r"--inside: no sphere lies wholly inside part, which goes from \(5, "
    ):
        carve_bed(row(1.0, 3.0), Cut(mesh, inside=True))


def test_an_open_mesh_is_refused_also_where_its_rim_is_level(tmp_path):
    opened = block((1, 1, 1), (3, 3, 3))
    opened.update_faces(~(opened.vertices[opened.faces][:, :, 2] == 3).all(axis=1))
    with pytest.raises(GeometryError, match=r"--inside: part.stl is open at 4 edges, around .*; close it"):
        loaded(tmp_path, opened)


def test_the_file_of_a_part_does_not_claim_the_walls_that_the_bed_had(tmp_path):
    settings = {
        "particle_sets": [{"name": "p", "density": 900, "material": "wax"}], "materials": [{"name": "wax"}],
        "gravity_direction": [0, 0, -1], "gravity": 9.81, "wall_material": "wax", "params": {},
        "container": {"box": {"min": [0, 0, 0], "max": [4, 4, 4]}},
    }  # fmt: skip
    bed = row(1.5, 3.5, provenance={"settings": settings})
    mesh = loaded(tmp_path, block((1, 1, 1), (3, 3, 3)))
    save_bed(carve_bed(bed, Cut(mesh, inside=True)).bed, tmp_path / "bed.npz")
    again = read_bed(tmp_path / "bed.npz")
    assert unknowns(again, ["density", "walls"]) == [
        "walls are not in the file: give --scene, or --container"
    ]
    assert again.provenance["carved"]["side"] == "inside"


@pytest.mark.parametrize("periodic", [(False,) * 3, (True, False, False)], ids=["box", "seam"])
@pytest.mark.parametrize(("inside", "touching"), [(True, False), (True, True), (False, False)])
def test_known_bodies_go_with_their_spheres(tmp_path, periodic, inside, touching):
    bed = lattice_of_clumps(singles=True, periodic=periodic)
    mesh = loaded(tmp_path, block([-0.02, -0.01, -0.01], [0.045, 0.09, 0.09]))
    found = carve_bed(bed, Cut(mesh, inside, touching)).bed
    assert 0 < len(found.bodies) < len(bed.bodies)
    assert check_bed(found).bodies.misplaced_count == 0
