"""The case for particle-resolved CFD, its STL files and dictionaries read back by readers of their own."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from exporters import surface
from packgen.bed import ParticleSet
from packgen.errors import ExportError
from tests.beds import box_container, box_surface, make_bed, make_container
from tests.exporters.resolved_cases import (
    RADIUS,
    box_bed,
    enclosed,
    pair_bed,
    read_dictionary,
    read_stl,
    ring_bed,
    shells,
    tube_container,
)

BALL = 4 / 3 * np.pi


def written(bed, folder, **options):
    """What ``surface.json`` says of a case that is written."""
    surface.write(bed, folder, surface.Options(**options))
    return json.loads((folder / "surface.json").read_text())


def solid_stl(folder, name="spheres"):
    return read_stl(folder / "constant" / "triSurface" / f"{name}.stl")


def snappy(folder):
    return read_dictionary(folder / "system" / "snappyHexMeshDict")


def test_spheres_are_one_solid_a_set_within_the_chord_error(tmp_path):
    bed = pair_bed(gap=0.1)
    sets = (ParticleSet("glass beads", 2500.0, "ore"), ParticleSet("glass_beads", 2500.0, "ore"))
    bed = replace(bed, particle_sets=sets, set_index=np.array([0, 1], np.int32))
    told = written(bed, tmp_path, contacts="none", chord_error=0.01)
    solids = solid_stl(tmp_path)
    assert list(solids) == ["glass_beads", "glass_beads_1"]
    for triangles, centre, radius in zip(solids.values(), bed.position, bed.radius, strict=True):
        assert np.allclose(np.linalg.norm(triangles - centre, axis=2), radius, rtol=1e-9)
        normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        depth = radius - np.einsum("fi,fi->f", normal, triangles[:, 0] - centre)
        assert 0 < depth.max() <= 0.01 * radius
    volume = sum(enclosed(each) for each in solids.values())
    assert told["spheres_volume_of_stl"] == pytest.approx(volume, rel=1e-9)
    assert 0.98 < volume / (BALL * (bed.radius**3).sum()) < 1


def test_caps_leave_the_gap_between_closed_bodies_and_at_walls(tmp_path):
    written(box_bed(2), tmp_path, gap=0.04, chord_error=0.05)
    bodies = shells(solid_stl(tmp_path)["pellets"])
    assert len(bodies) == 8
    ends = np.array([[each.min(axis=(0, 1)), each.max(axis=(0, 1))] for each in bodies])
    low, high = ends[:, 0], ends[:, 1]
    # Along x and y half the gap at a neighbour and the whole at a wall; along z open ends.
    for axis in (0, 1):
        assert set(np.round(low[:, axis], 9)) == {0.004, 0.202}
        assert set(np.round(high[:, axis], 9)) == {0.198, 0.396}
    assert low[:, 2].min() < 0.002
    assert set(np.round(high[low[:, 2] < 0.1, 2], 9)) == {0.198}


def test_the_volume_of_caps_is_the_closed_form_and_that_of_fine_facets(tmp_path):
    bed = pair_bed()
    told = written(bed, tmp_path, gap=0.1, chord_error=0.005)
    height = 0.05 * 0.06  # half the gap, of the smaller radius
    caps = sum(np.pi / 3 * height**2 * (3 * radius - height) for radius in bed.radius)
    assert told["pairs_cut"] == 1
    assert told["solid_volume_before"] == pytest.approx(BALL * (bed.radius**3).sum(), rel=1e-12)
    assert told["solid_volume_before"] - told["solid_volume_after"] == pytest.approx(caps, rel=1e-9)
    assert told["volume"] == pytest.approx(np.pi * 0.32, rel=1e-12)
    assert told["porosity_change"] == pytest.approx(caps / (np.pi * 0.32), rel=1e-9)
    assert told["porosity_after"] == pytest.approx(1 - told["solid_volume_after"] / told["volume"], rel=1e-12)
    assert told["spheres_volume_of_stl"] == pytest.approx(told["solid_volume_after"], rel=1e-2)


def test_a_cap_at_a_hollow_wall_leaves_the_gap_at_its_rim_too(tmp_path):
    told = written(ring_bed(), tmp_path, gap=0.05, chord_error=0.005)
    assert told["cuts_at_walls"] == 6
    corner = solid_stl(tmp_path)["pellets"].reshape(-1, 3)
    assert np.hypot(corner[:, 0], corner[:, 1]).max() == pytest.approx(0.31 - 0.05 * RADIUS, rel=1e-6)


def test_shrunk_spheres_have_smaller_radii_and_their_volume(tmp_path):
    told = written(box_bed(2), tmp_path, contacts="shrink", shrink=0.97, spheres="analytic")
    entries = read_dictionary(tmp_path / "system" / "spheres")
    assert [float(each["radius"]) for each in entries.values()] == [RADIUS * 0.97] * 8
    centres = [[float(word) for word in each["centre"]] for each in entries.values()]
    assert np.array_equal(centres, box_bed(2).position)
    assert told["solid_volume_after"] == pytest.approx(0.97**3 * told["solid_volume_before"], rel=1e-12)
    assert told["pairs_still_overlapping"] == 0
    assert not (tmp_path / "constant" / "triSurface" / "spheres.stl").exists()
    assert '#include "spheres"' in (tmp_path / "system" / "snappyHexMeshDict").read_text()


@pytest.mark.parametrize("gap", [0.0, 0.001, -0.0002])
def test_a_bridge_adds_a_cylinder_less_two_caps(tmp_path, gap):
    bed = pair_bed(gap)
    told = written(bed, tmp_path, contacts="bridges", gap=0.05, bridge_radius=0.25)
    thick = 0.25 * 0.06
    rims = np.sqrt(bed.radius**2 - thick**2)
    heights = bed.radius - rims
    added = np.pi * thick**2 * (0.16 + gap - rims.sum())
    added -= (np.pi / 3 * heights**2 * (3 * bed.radius - heights)).sum()
    balls = BALL * (bed.radius**3).sum()
    assert told["bridges_between_spheres"] == 1
    assert told["solid_volume_after"] == pytest.approx(balls + added, rel=1e-12)
    assert told["solid_volume_before"] == pytest.approx(balls, rel=1e-4)
    assert (told["solid_volume_before"] < balls * (1 - 1e-9)) == (gap < 0)
    (rod,) = shells(solid_stl(tmp_path, "bridges")["bridges"])
    assert np.hypot(rod[..., 0], rod[..., 1]).max() == pytest.approx(thick, rel=1e-9)
    assert rod[..., 2].min() == pytest.approx(0.15, rel=1e-9)
    assert rod[..., 2].max() == pytest.approx(0.2 + gap + 0.03, rel=1e-9)


def test_bridges_to_walls_end_beyond_them_as_triangles_and_as_cylinders(tmp_path):
    (tmp_path / "stl").mkdir()
    (tmp_path / "own").mkdir()
    options = {"contacts": "bridges", "bridge_radius": 0.3}
    told = written(ring_bed(), tmp_path / "stl", **options)
    assert told["bridges_to_walls"] == 6
    assert told == written(ring_bed(), tmp_path / "own", spheres="analytic", **options) | {
        "spheres_volume_of_stl": told["spheres_volume_of_stl"]
    }
    for rod in shells(solid_stl(tmp_path / "stl", "bridges")["bridges"]):
        far = np.hypot(rod[..., 0], rod[..., 1])
        assert (far > 0.31).sum() > 0
        assert (np.sort(far.ravel())[-24:] > 0.31).all()
    entries = read_dictionary(tmp_path / "own" / "system" / "spheres")
    rods = [each for each in entries.values() if each["type"] == "searchableCylinder"]
    assert len(rods) == 6
    assert all(float(each["radius"]) == pytest.approx(0.03) for each in rods)


def test_a_tube_reaches_inlet_and_outlet_length_beyond_the_spheres(tmp_path):
    bed = pair_bed()
    told = written(bed, tmp_path, inlet_length=0.5, outlet_length=0.7, inlet="top", chord_error=0.05)
    walls = solid_stl(tmp_path, "walls")
    assert list(walls) == ["wall", "inlet", "outlet"]
    assert np.allclose(walls["inlet"][..., 2], 0.32 + 0.5)
    assert np.allclose(walls["outlet"][..., 2], -0.7)
    assert told["tube_length"] == pytest.approx(1.52)
    (closed,) = shells(np.concatenate(list(walls.values())))
    assert 1 <= enclosed(closed) / (np.pi * 1.52) < 1.02
    assert snappy(tmp_path)["castellatedMeshControls"]["refinementSurfaces"]["walls"]["regions"].keys() == {
        "inlet",
        "outlet",
    }


def test_a_box_is_the_background_mesh_with_patches(tmp_path):
    bed = box_bed(3, (False, True, False))
    written(bed, tmp_path, contacts="shrink", axis="x", inlet_length=0.3, outlet_length=0.1, cell_size=0.05)
    mesh = read_dictionary(tmp_path / "system" / "blockMeshDict")
    corner = np.array(mesh["vertices"], float)
    assert np.allclose(corner.min(axis=0), [-0.3, 0, 0])
    assert np.allclose(corner.max(axis=0), [0.7, 0.6, 0.6])
    assert mesh["blocks"][2] == ["20", "12", "12"]
    patches = dict(zip(mesh["boundary"][::2], mesh["boundary"][1::2], strict=True))
    assert {name: each["type"] for name, each in patches.items()} == {
        "inlet": "patch", "outlet": "patch", "y_low": "patch", "y_high": "patch", "walls_wall": "wall",
    }  # fmt: skip
    for name, axis, value in (("inlet", 0, -0.3), ("outlet", 0, 0.7), ("y_low", 1, 0.0), ("y_high", 1, 0.6)):
        (face,) = patches[name]["faces"]
        assert np.allclose(corner[np.array(face, int), axis], value)
    assert not (tmp_path / "constant" / "triSurface" / "walls.stl").exists()


def test_spheres_and_bridges_across_a_seam_are_on_both_sides(tmp_path):
    box = box_container((0, 0, 0), (1, 1, 1), (True, False, False))
    bed = make_bed([[0.05, 0.5, 0.5], [0.85, 0.5, 0.5]], 0.1, box)
    told = written(bed, tmp_path, contacts="bridges", spheres="analytic")
    entries = read_dictionary(tmp_path / "system" / "spheres")
    centres = sorted(float(each["centre"][0]) for each in entries.values() if "centre" in each)
    assert np.allclose(centres, [0.05, 0.85, 1.05])
    rods = [
        (float(each["point1"][0]), float(each["point2"][0])) for each in entries.values() if "point1" in each
    ]
    assert np.allclose(np.sort(np.sort(rods, axis=1), axis=0), [[-0.1, 0.0], [0.9, 1.0]])
    assert told["bridges_between_spheres"] == 1


@pytest.mark.parametrize("options", [{}, {"contacts": "bridges"}, {"contacts": "none"}])
@pytest.mark.parametrize("make", [box_bed, ring_bed, pair_bed])
def test_the_location_in_the_mesh_is_in_the_fluid(tmp_path, make, options):
    bed = make()
    told = written(bed, tmp_path, chord_error=0.1, **options)
    point = np.array(snappy(tmp_path)["castellatedMeshControls"]["locationInMesh"], float)
    clear = told["distance_of_location_from_walls_and_spheres"]
    assert clear > RADIUS  # in the inlet or outlet length there is room for more
    assert (np.linalg.norm(bed.position - point, axis=1) - bed.radius).min() >= clear - 1e-12
    if bed.container.surface.faces.shape[0] == 12:
        assert (point[:2] - clear > -1e-12).all()
        assert (point[:2] + clear < 0.4 + 1e-12).all()
    else:
        assert np.hypot(*point[:2]) + clear <= bed.container.shape.radius_bottom + 1e-12


def test_any_other_vessel_is_meshed_as_it_is(tmp_path):
    cube = box_surface((0, 0, 0), (0.4, 0.4, 0.4))
    from packgen.geometry import Mesh

    bed = make_bed(box_bed(2).position, RADIUS, make_container(Mesh(cube), cube, 0.064))
    told = written(bed, tmp_path, gap=0.04, chord_error=0.1)
    assert told["cuts_at_walls"] == 24
    assert told["volume"] == 0.064
    assert told["tube_length"] is None
    assert list(solid_stl(tmp_path, "walls")) == ["wall"]
    point = np.array(told["location_in_mesh"])
    assert 0.03 < told["distance_of_location_from_walls_and_spheres"] <= min(point.min(), (0.4 - point).min())
    assert "walls taken for flat" in written(bed, tmp_path, contacts="bridges")["volume_found_by"]
    with pytest.raises(ExportError, match=r"surface: inlet_length and outlet_length are of a cylinder"):
        written(bed, tmp_path, inlet_length=0.1)
    with pytest.raises(ExportError, match=r"surface: axis=x is of a box"):
        written(bed, tmp_path, axis="x")


def test_flats_that_meet_are_integrated_and_said(tmp_path):
    bed = make_bed([[0.1, 0.1, 0.1]], RADIUS, box_container((0, 0, 0), (0.2, 0.2, 1)))
    bed = replace(bed, radius=np.array([0.0999]), position=np.array([[0.0999, 0.0999, 0.1]]))
    told = written(bed, tmp_path, gap=0.2, chord_error=0.005)
    assert "closed form" in told["volume_found_by"]
    bed = make_bed([[0.0, 0.0, 0.0], [0.199, 0, 0], [0.196, 0.034, 0]], [0.1, 0.1, 0.099],
                   tube_container(1.0, 1.0))  # fmt: skip
    bed = replace(bed, body_index=np.array([0, 1, 1], np.int32))
    told = written(bed, tmp_path, gap=0.2, chord_error=0.005)
    assert "quadrature" in told["volume_found_by"]
    assert told["spheres_volume_of_stl"] == pytest.approx(told["solid_volume_after"], rel=1e-2)


def test_options_that_clash_are_refused():
    with pytest.raises(ValueError, match="spheres=analytic cannot be cut flat"):
        surface.Options(spheres="analytic")
    with pytest.raises(ValueError, match="shrink is of contacts=shrink, found contacts=caps"):
        surface.Options(shrink=0.9)
    with pytest.raises(ValueError, match="gap is of contacts=caps or bridges, found contacts=none"):
        surface.Options(contacts="none", gap=0.1)


def test_what_cannot_be_meshed_is_refused_before_a_file_is_there(tmp_path):
    with pytest.raises(ExportError, match=r"cuts sphere 2 at 0\.323 of its radius"):
        written(pair_bed(-0.08), tmp_path)
    with pytest.raises(ExportError, match=r"cells of 1e-06 m, expected at most 50,000,000"):
        written(box_bed(2), tmp_path, cell_size=1e-6)
    with pytest.raises(ExportError, match=r"surface: the box wraps around along x; choose another"):
        written(box_bed(4, (True, False, False)), tmp_path, axis="x")
    assert list(tmp_path.iterdir()) == []


def test_too_many_facets_are_refused_with_the_remedy(tmp_path, monkeypatch):
    monkeypatch.setattr(surface, "FACETS_MAX", 1000)
    with pytest.raises(ExportError, match=r"2.56e\+03 facets of 8 spheres, expected at most 1,000; enlarge"):
        written(box_bed(2), tmp_path)


@pytest.mark.solver
@pytest.mark.slow
@pytest.mark.skipif(shutil.which("snappyHexMesh") is None, reason="OpenFOAM is not installed")
@pytest.mark.parametrize(
    "options",
    [{}, {"contacts": "bridges", "spheres": "analytic"}],
    ids=["caps", "bridges"],
)
def test_openfoam_meshes_spheres_that_touch_and_finds_no_fault(tmp_path, options):
    bed = turned_layers(10)
    lengths = {"inlet_length": 2 * RADIUS, "outlet_length": 2 * RADIUS}
    written(bed, tmp_path, cell_size=0.6 * RADIUS, **lengths, **options)
    environment = {"WM_PROJECT_DIR": "/usr/share/openfoam", **os.environ}
    done = subprocess.run(
        [tmp_path / "Allrun"], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    logs = {path.name: path.read_text() for path in Path(tmp_path).glob("log.*")}
    assert "Mesh OK" in logs["log.checkMesh"]
    assert "Number of regions: 1 (OK)" in logs["log.checkMesh"]
    checks = [text for name, text in logs.items() if name.startswith("log.surfaceCheck")]
    assert checks
    assert all("Surface has no illegal triangles" in text for text in checks)
    assert all("Surface is closed" in text for text in checks)


def turned_layers(count):
    """Spheres in touching layers of a square lattice inside of a tube, each layer turned."""
    layer = lattice_layer(1) * 2 * RADIUS
    rows = []
    for level in range(-(-count // len(layer))):
        turn = 0.7 * level
        x = layer[:, 0] * np.cos(turn) - layer[:, 1] * np.sin(turn)
        y = layer[:, 0] * np.sin(turn) + layer[:, 1] * np.cos(turn)
        rows.append(np.stack([x, y, np.full(len(x), RADIUS * (1 + 2 * level))], axis=1))
    return make_bed(np.concatenate(rows)[:count], RADIUS, tube_container(3 * RADIUS, 1.0))


def lattice_layer(reach):
    """Points of a square lattice of step 1 within a circle."""
    x, y = np.meshgrid(np.arange(-reach, reach + 1), np.arange(-reach, reach + 1))
    inside = np.hypot(x, y) <= reach
    return np.stack([x[inside], y[inside]], axis=1).astype(float)
