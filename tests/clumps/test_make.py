from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest
import trimesh

from packgen.check.mesh import MeshWalls
from packgen.clumps import (
    Cube,
    Cylinder,
    Dumbbell,
    Ellipsoid,
    Ring,
    Rod,
    Tetrapod,
    Wanted,
    make_clump,
    shape_of,
)
from packgen.clumps.body import body_of
from packgen.clumps.fit import inertia_error
from packgen.clumps.points import surface_points
from packgen.clumps.properties import mesh_properties, union_properties
from packgen.clumps.tree import triangle_tree
from packgen.errors import GeometryError, PackgenError
from packgen.geometry import Surface

STONES = Path(__file__).resolve().parents[2] / "examples" / "stones"


def surface_of(mesh):
    return Surface(np.asarray(mesh.vertices), np.asarray(mesh.faces))


def ball():
    return surface_of(trimesh.creation.icosphere(3))


def torus():
    return surface_of(trimesh.creation.torus(1.0, 0.3, major_sections=32, minor_sections=16))


def plate():
    return surface_of(trimesh.creation.box((1.0, 1.0, 0.02)))


BODIES = {"ball": ball, "torus": torus, "box": lambda: surface_of(trimesh.creation.box()), "plate": plate}


def test_distances_are_those_of_the_check_which_shares_no_code():
    surface = torus()
    point = np.random.default_rng(0).uniform(-1.5, 1.5, (300, 3))
    tree = triangle_tree(surface.vertices[surface.faces])
    np.testing.assert_allclose(
        tree.distance(point), MeshWalls(surface).distance(point, np.full(300, 9.0)), atol=1e-12
    )


@pytest.mark.parametrize("count", [1, 3, 4, 5, 17, 100])
def test_a_tree_holds_every_triangle_whatever_their_number(count):
    corners = np.random.default_rng(count).normal(size=(count, 3, 3))
    held = {tuple(row) for row in triangle_tree(corners).corner}
    assert held == {tuple(row) for row in corners.reshape(count, 9)}


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("equal", [False, True])
def test_spheres_are_inside_of_any_body(name, equal):
    surface = BODIES[name]()
    clump = make_clump(surface, Wanted(spheres=15, equal=equal))
    spheres = clump.template.spheres + np.append(clump.template.place, 0.0)
    assert 1 <= len(spheres) <= 15
    walls = MeshWalls(surface)
    centre = np.ascontiguousarray(spheres[:, :3])
    away = walls.distance(centre, np.full(len(centre), 9.0))
    assert walls.contains(centre).all()
    assert (spheres[:, 3] <= away).all()
    assert np.all(np.diff(spheres[:, 3]) <= 0.0)
    if equal:
        assert np.ptp(spheres[:, 3]) <= 1e-12 * spheres[0, 3]


def test_more_spheres_fill_more():
    errors = [make_clump(torus(), Wanted(spheres=count)).fit.misplaced for count in (5, 15, 45)]
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 0.1


def test_a_ball_is_one_sphere():
    clump = make_clump(ball(), Wanted(spheres=1))
    assert clump.fit.misplaced < 0.03  # what the facets cut off a sphere
    assert clump.template.spheres[0, 3] == pytest.approx(0.99, abs=0.01)


def test_a_volume_error_is_reached_and_counted_exactly():
    clump = make_clump(torus(), Wanted(volume_error=0.12))
    assert clump.missed == ()
    body = mesh_properties(torus().vertices[torus().faces])
    union = union_properties(clump.template.spheres)
    assert clump.fit.misplaced == pytest.approx(1.0 - union.volume / body.volume, abs=1e-9)
    assert clump.fit.misplaced <= 0.12


def test_a_surface_error_is_reached_everywhere():
    clump = make_clump(torus(), Wanted(surface_error=0.05))
    assert clump.missed == ()
    corners = torus().vertices[torus().faces] - clump.template.place
    point = surface_points(corners, 3000)[0]
    spheres = clump.template.spheres
    gap = (np.linalg.norm(point[:, None] - spheres[None, :, :3], axis=2) - spheres[:, 3]).min(axis=1)
    assert gap.max() <= 0.05 * clump.template.equivalent_diameter


def test_limits_that_few_spheres_cannot_reach_are_named():
    clump = make_clump(torus(), Wanted(spheres=3, volume_error=0.01))
    assert clump.template.count == 3
    assert "volume error: found" in clump.missed[0]


@pytest.mark.parametrize("equal", [False, True])
def test_best_fitting_spheres_have_the_bodys_volume_and_centre(equal):
    wanted = Wanted(spheres=12, best_fit=True, equal=equal)
    clump, inside = (make_clump(torus(), each) for each in (wanted, Wanted(spheres=12, equal=equal)))
    assert clump.fit.volume_error == pytest.approx(0.0, abs=1e-8)
    assert clump.fit.centre_error == pytest.approx(0.0, abs=1e-8)
    assert clump.fit.inertia_error < inside.fit.inertia_error
    assert clump.fit.misplaced < inside.fit.misplaced


def test_a_clump_is_as_large_as_its_stone_and_the_same_each_time():
    small = Surface(ball().vertices * 1e-3 + 5.0, ball().faces)
    one, two, large = (make_clump(each, Wanted(spheres=8)) for each in (small, small, ball()))
    np.testing.assert_array_equal(one.template.spheres, two.template.spheres)
    assert one.template.volume == pytest.approx(large.template.volume * 1e-9, rel=1e-9)
    np.testing.assert_allclose(one.template.place, 5.0, atol=1e-9)


def test_no_sphere_is_smaller_than_the_least_radius():
    clump = make_clump(BODIES["box"](), Wanted(spheres=60, least_radius=0.2))
    assert clump.template.spheres[:, 3].min() >= 0.2 * (1.0 - 1e-9)
    with pytest.raises(GeometryError, match=r"the largest sphere inside has a radius of about 0\.\d+ m"):
        make_clump(BODIES["box"](), Wanted(spheres=60, least_radius=0.6))


def test_a_flat_mesh_and_parts_that_cut_each_other_are_refused():
    flat = Surface(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]), np.array([[0, 1, 2], [0, 2, 1]]))
    with pytest.raises(GeometryError, match="bounds no volume"):
        body_of(flat)
    one, two = ball(), Surface(ball().vertices + np.array([0.8, 0, 0]), ball().faces)
    both = Surface(
        np.concatenate([one.vertices, two.vertices]),
        np.concatenate([one.faces, two.faces + len(one.vertices)]),
    )
    with pytest.raises(GeometryError, match="parts that cut each other"):
        body_of(both)


def test_a_mesh_turned_inside_out_is_the_same_body():
    inside_out = Surface(ball().vertices, ball().faces[:, ::-1])
    assert body_of(inside_out).properties.volume == pytest.approx(body_of(ball()).properties.volume)


def test_errors_of_inertia_are_the_largest_of_any_axis():
    true = np.diag([1.0, 2.0, 3.0])
    assert inertia_error(true * 1.01, true) == pytest.approx(0.01)
    assert inertia_error(np.diag([1.0, 2.0, 3.3]), true) == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        (Cylinder(0.5, 2.0), np.pi * 0.5),
        (Ellipsoid(1.0, 2.0, 3.0), np.pi),
        (Cube(2.0, 1.0), 4.0 / 3.0 * np.pi),
        (Cube(1.0, 0.1), 0.512 + 6 * 0.064 + 3 * np.pi * 0.008 + 4.0 / 3.0 * np.pi * 1e-3),
        (Rod(0.5, 2.0), np.pi * 0.25 + np.pi / 6.0),
    ],
)
def test_solid_shapes_are_closed_and_have_their_volume(shape, volume):
    surface = shape.surface()
    mesh = trimesh.Trimesh(surface.vertices, surface.faces, process=False)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(volume, rel=1e-9)
    np.testing.assert_allclose(mesh.center_mass, 0.0, atol=1e-9)


def test_shapes_of_spheres_have_their_spheres():
    assert make_clump(Dumbbell(1.0, 1.0)).template.count == 2
    assert make_clump(Tetrapod(), Wanted(spheres=13)).template.count == 13
    ring = make_clump(Ring(1.0)).template
    assert ring.spheres[:, 3] == pytest.approx(np.sin(np.pi / 12))
    assert ring.spheres[:, 2] == pytest.approx(0.0, abs=1e-12)
    rod = make_clump(Rod(0.5, 3.0), Wanted(spheres=9))
    assert rod.template.spheres[:, 0].max() == pytest.approx(1.0)
    assert -0.02 < rod.fit.volume_error < 0.0


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: shape_of("ring", {"girth": 1.0}), "found size 'girth', expected radius or thickness"),
        (lambda: shape_of("rod", {"radius": -1.0}), "found radius=-1, expected a length above 0"),
        (lambda: make_clump(Rod(1.0, 1.0)), "found length=1, expected more than two radii"),
        (lambda: make_clump(Tetrapod(), Wanted(spheres=7)), "expected 5, 9, 13"),
        (lambda: make_clump(Ring(1.0, 0.1)), "at which 12 spheres touch"),
        (
            lambda: make_clump(Ring(1.0), Wanted(spheres=6, equal=True)),
            "expected the number of spheres alone",
        ),
    ],
)
def test_shapes_that_cannot_be_are_refused(make, said):
    with pytest.raises(PackgenError, match=said):
        make()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["crushed", "pebble", "shard"])
def test_the_stones_of_the_examples_are_met_by_sixty_spheres(name):
    fit = make_clump(STONES / f"{name}.stl", Wanted(spheres=60, best_fit=True)).fit
    assert abs(fit.volume_error) < 0.01
    assert fit.inertia_error < 0.02
    assert fit.misplaced < 0.05


def test_the_stones_are_those_that_their_script_makes(tmp_path):
    spec = importlib.util.spec_from_file_location("make_stones", STONES / "make_stones.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.__file__ = str(tmp_path / "make_stones.py")
    module.main()
    for path in STONES.glob("*.stl"):
        one, two = (trimesh.load(each / path.name) for each in (tmp_path, STONES))
        assert one.is_watertight
        assert one.volume == pytest.approx(two.volume, rel=1e-5)
