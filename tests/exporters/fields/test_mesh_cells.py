"""Spheres in the cells of a mesh: closed forms against the library, which has the other cells."""

from __future__ import annotations

import numpy as np
import overlap
import pytest

from exporters.fields import ball_cuts as cuts
from exporters.fields.ball_kernels import BALL, ball_in_cell
from exporters.fields.mesh_cells import FACES, fan_planes, fans, mesh_volumes, planes_of

BOX = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float
)
WEDGE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]], float)
TETRA = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
TURN = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
TURN *= np.sign(np.linalg.det(TURN))
SHEAR = np.array([[1.0, 0.3, 0.1], [0.0, 1.2, -0.2], [0.0, 0.0, 0.8]])
CELLS = {
    "box": ("hexahedron", BOX),
    "turned box": ("hexahedron", BOX @ TURN + 7.0),
    "sheared box": ("hexahedron", BOX @ SHEAR),
    "wedge": ("wedge", WEDGE @ TURN),
    "tetrahedron": ("tetra", TETRA @ SHEAR),
}
ELEMENT = {"hexahedron": overlap.Hexahedron, "wedge": overlap.Wedge, "tetra": overlap.Tetrahedron}


def spheres(corners, count=3000):
    """Spheres of many sizes in and around a cell."""
    rng = np.random.default_rng(0)
    position = rng.uniform(corners.min(axis=0) - 0.3, corners.max(axis=0) + 0.3, (count, 3))
    return position, 0.7 * rng.random(count) ** 2


def in_cell(kind, corners, center, radius):
    """Volume of a sphere in a cell by the closed form."""
    planes = planes_of(kind, corners[None])
    middle = planes.middle[0]
    cells = planes.polyhedra(corners[None], np.array(FACES[kind]))
    return ball_in_cell(*(center - middle), radius, 0, cells) * radius**3


@pytest.mark.parametrize("name", CELLS)
def test_a_ball_in_a_convex_cell_is_what_the_library_finds(name):
    kind, corners = CELLS[name]
    body = ELEMENT[kind](corners)
    for center, radius in zip(*spheres(corners), strict=True):
        expected = overlap.overlap_volume(overlap.Sphere(center, radius), body)
        assert in_cell(kind, corners, center, radius) == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("shift", [0.0, 1e-17, 1e-14, 1e-9, 2e-6, 3.1e-6, 1e-4])
@pytest.mark.parametrize("center", [(0.5, 0.5, 0), (0.5, 0, 0), (0, 0, 0), (0.3, 1, 1), (0.1, 0, 1)], ids=str)
@pytest.mark.parametrize("turned", [False, True])
def test_balls_at_faces_edges_and_corners_have_the_right_volume_inside(center, shift, turned):
    frame = TURN if turned else np.eye(3)
    for radius in (0.02, 0.09, 0.3, 0.7):
        inward = np.sign(0.5 - np.array(center)) * np.array([1.0, 0.7, 0.4])
        at = np.array(center) + shift * radius * inward
        # The library rounds as badly there: octants of the box, which closed forms of their own know.
        below = [np.clip(np.array([-each, 1.0 - each]) / radius, -1.0, 1.0)[None] for each in at]
        expected = np.diff(np.diff(np.diff(cuts.below(*below), axis=1), axis=2), axis=3)[0, 1, 1, 1]
        assert in_cell("hexahedron", BOX @ frame, at @ frame, radius) == pytest.approx(
            expected * radius**3, abs=1e-9 * radius**3
        )


def test_the_cells_of_a_mesh_share_a_bed_out_without_a_rest():
    rng = np.random.default_rng(2)
    # Boxes of very different widths, each cut into six tetrahedra.
    ticks = [np.concatenate([[0.0], np.cumsum(rng.uniform(0.01, 1.0, 6))]) for _ in range(3)]
    ticks = [each / each[-1] for each in ticks]
    grid = np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1)
    boxes = [
        np.array([grid[i + a, j + b, k + c] for a, b, c in BOX.astype(int)])
        for i in range(6) for j in range(6) for k in range(6)
    ]  # fmt: skip
    six = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
    corners = np.array([box[each] for box in boxes for each in six]) @ TURN.T
    radius = 0.2 * rng.random(500) ** 4
    position = rng.uniform(radius[:, None], 1.0 - radius[:, None], (500, 3))
    solid = BALL * (radius**3).sum()
    volume, of_cell = mesh_volumes(position @ TURN.T, radius, "tetra", corners)
    assert volume.sum() == pytest.approx(solid, rel=1e-12)
    assert of_cell.sum() == pytest.approx(1.0)
    assert (volume <= of_cell * (1.0 + 1e-9) * 500).all()
    body = [overlap.Tetrahedron(each) for each in corners[::50]]
    balls = [overlap.Sphere(*each) for each in zip(position @ TURN.T, radius, strict=True)]
    expected = [sum(overlap.overlap_volume(ball, cell) for ball in balls) for cell in body]
    np.testing.assert_allclose(volume[::50], expected, rtol=0, atol=1e-13)


def by_fans(kind, corners, position, radius):
    """Volumes of spheres in a cell, one after the other, by triangles, and the cell's."""
    split, faces = fans(kind, corners[None])
    planes = fan_planes(split, faces)
    middle = planes.middle[0]
    cells = planes.polyhedra(split, faces)
    found = [ball_in_cell(*(at - middle), r, 0, cells) * r**3 for at, r in zip(position, radius, strict=True)]
    return np.array(found), planes.volume[0]


@pytest.mark.parametrize("name", CELLS)
def test_fans_of_triangles_are_what_planes_are(name):
    kind, corners = CELLS[name]
    position, radius = spheres(corners, 1000)
    # Centres on corners, edges and faces, and balls that touch those.
    position = np.concatenate(
        [position, corners, corners[:1] + np.linspace(0, 1, 9)[:, None] * (corners[1] - corners[0])]
    )
    radius = np.concatenate([radius, np.full(len(position) - len(radius), 0.3)])
    found, volume = by_fans(kind, corners, position, radius)
    expected = [in_cell(kind, corners, *each) for each in zip(position, radius, strict=True)]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10)
    assert volume == pytest.approx(ELEMENT[kind](corners).volume, rel=1e-12)


def monte_carlo(inside, center, radius, count=400_000):
    rng = np.random.default_rng(5)
    points = center + radius * rng.uniform(-1, 1, (count, 3))
    hit = (np.linalg.norm(points - center, axis=1) < radius) & inside(points)
    return hit.mean() * 8 * radius**3


def test_a_hollow_cell_is_filled_as_far_as_it_goes():
    # A prism on a dart: the corner at (0.3, 0.3) is reflex.
    base = np.array([[0, 0], [1, 0], [0.3, 0.3], [0, 1]], float)
    dart = np.concatenate([np.column_stack([base, np.full(4, z)]) for z in (0.0, 1.0)])

    def inside(points):
        x, y, z = points.T
        within = np.where(y <= x, 3 * x + 7 * y < 3, 7 * x + 3 * y < 3)
        return (x > 0) & (y > 0) & (z > 0) & (z < 1) & within

    volume, of_cell = mesh_volumes(np.array([[0.3, 0.35, 0.4]]), np.array([0.3]), "hexahedron", dart[None])
    assert of_cell[0] == pytest.approx(0.3)
    assert volume[0] == pytest.approx(monte_carlo(inside, [0.3, 0.35, 0.4], 0.3), abs=3e-4)


def test_cells_with_warped_faces_share_a_bed_out_without_a_rest():
    rng = np.random.default_rng(3)
    number = np.arange(125).reshape(5, 5, 5)
    points = np.stack(np.meshgrid(*[np.linspace(0, 1, 5)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    inner = ((points > 0.01) & (points < 0.99)).all(axis=1)
    points[inner] += rng.uniform(-0.07, 0.07, (int(inner.sum()), 3))
    low = number[:4, :4, :4].ravel()
    corners = points[low[:, None] + np.array([0, 25, 30, 5, 1, 26, 31, 6])]
    radius = rng.uniform(0.02, 0.2, 100)
    position = rng.uniform(radius[:, None], 1 - radius[:, None], (100, 3))
    volume, of_cell = mesh_volumes(position, radius, "hexahedron", corners)
    assert of_cell.sum() == pytest.approx(1.0, rel=1e-12)
    assert volume.sum() == pytest.approx(BALL * (radius**3).sum(), rel=1e-11)
    assert volume.min() > 0.0


@pytest.mark.parametrize("digits", [np.float32, np.float64])
def test_a_mesh_turned_and_rounded_is_a_mesh(digits):
    box = BOX @ TURN
    corners = np.array([(0.25 * box + shift).astype(digits) for shift in 0.25 * (BOX @ TURN)], float)
    bed = spheres(box, 300)
    volume, _ = mesh_volumes(*bed, "hexahedron", corners)
    whole = sum(
        overlap.overlap_volume(overlap.Sphere(*each), overlap.Hexahedron(0.5 * box))
        for each in zip(*bed, strict=True)
    )
    assert volume.sum() == pytest.approx(whole, rel=1e-5)


def test_a_hexahedron_with_corners_that_coincide_is_the_wedge_that_it_looks_like():
    position, radius = spheres(WEDGE, 200)
    wedge, of_wedge = mesh_volumes(position, radius, "wedge", WEDGE[None])
    box, of_box = mesh_volumes(position, radius, "hexahedron", WEDGE[[0, 1, 2, 2, 3, 4, 5, 5]][None])
    assert of_box == pytest.approx(of_wedge)
    assert box == pytest.approx(wedge, rel=1e-9)


def test_a_cell_without_volume_or_one_that_crosses_itself_is_named():
    position, radius = spheres(BOX, 100)
    flat = np.stack([TETRA, TETRA * [1, 1, 0]])
    with pytest.raises(ValueError, match="tetra 1 has no volume, the only one"):
        mesh_volumes(position, radius, "tetra", flat)
    bowtie = BOX[[0, 1, 3, 2, 4, 5, 7, 6]] + 0.2 * np.arange(8)[:, None] * [0.1, 0.0, 0.0]
    with pytest.raises(ValueError, match=r"hexahedron 0 (has no volume|crosses itself)"):
        mesh_volumes(position, radius, "hexahedron", bowtie[None])


@pytest.mark.parametrize("name", CELLS)
def test_the_volume_of_a_cell_is_the_librarys(name):
    kind, corners = CELLS[name]
    _, volume = mesh_volumes(*spheres(corners, 3), kind, corners[None])
    assert volume[0] == pytest.approx(ELEMENT[kind](corners).volume, rel=1e-12)
