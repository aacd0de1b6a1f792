"""What is found of a bed in pieces is what is found of the bed: the check to the last digit."""

from __future__ import annotations

from dataclasses import asdict, fields, replace
from importlib import import_module

import numpy as np
import pytest

import exporters
from packgen.check import check_bed
from packgen.geometry import Cone, Mesh, Polyhedron
from packgen.pieces import PieceBed, in_pieces
from packgen.pieces.measure import LEFT_OUT
from packgen.pieces.survey import RadiusClasses
from packgen.report import Measures, measure_bed
from packgen.report_in_pieces import check_pieces, measure_pieces
from tests.beds import box_container, cubic_lattice, fcc_lattice, make_bed, make_container, revolved_surface
from tests.pieces.beds import shaken


def split(bed, folder, spheres=100):
    folder.mkdir(exist_ok=True)
    pieces = in_pieces(bed, folder, spheres=spheres)
    return pieces, pieces.gathered()


@pytest.mark.parametrize("seed", range(3))
def test_the_check_is_that_of_the_gathered_bed_to_the_last_digit(tmp_path, seed):
    pieces, gathered = split(shaken(seed=seed), tmp_path)
    found = check_pieces(pieces)
    assert found == check_bed(gathered)
    assert found.overlap_count > 100
    assert found.wall_overlap_max > 0.0


def test_of_equal_overlaps_the_same_one_is_named(tmp_path):
    spheres = cubic_lattice(8, 1.0) * 0.99
    bed = make_bed(spheres, 1.0, box_container(np.full(3, -1.0), np.full(3, 17.0)))
    pieces, gathered = split(bed, tmp_path, 30)
    assert check_pieces(pieces) == check_bed(gathered)


@pytest.mark.parametrize("broad", [False, True])
def test_a_fault_planted_across_a_seam_is_found_there(tmp_path, broad):
    bed = make_bed(cubic_lattice(8, 1.0), 0.999, box_container(np.zeros(3), np.full(3, 16.0)))
    position, radius = bed.position.copy(), bed.radius.copy()
    one, other = (int(np.flatnonzero((position == each).all(axis=1))[0]) for each in ([7, 7, 7], [9, 7, 7]))
    position[one, 0], position[other, 0] = 7.9, 8.1
    if broad:
        radius[::3] = 0.05
        radius[[one, other]] = 0.999
    pieces, gathered = split(replace(bed, position=position, radius=radius), tmp_path, 64)
    found = check_pieces(pieces)
    assert found == check_bed(gathered)
    assert found.overlap_max > 1.0
    owners = {
        next(
            place
            for place, each in enumerate(pieces.pieces)
            if each.offset <= number < each.offset + each.count
        )
        for number in found.worst_pair
    }
    assert len(owners) == 2


def test_a_sphere_that_is_no_number_is_counted_and_one_outside_is_named(tmp_path):
    bed = shaken()
    position = bed.position.copy()
    position[5], position[9] = np.nan, [-30.0, 1.0, 1.0]
    pieces, gathered = split(replace(bed, position=position), tmp_path)
    found = check_pieces(pieces)
    assert found == check_bed(gathered)
    assert (found.invalid_count, found.outside_count > 0) == (1, True)


def in_a_tube(bed, *, polygonal):
    """The spheres of a bed that are inside a cylinder in its box."""
    size = float(bed.container.bounds[1, 0])
    middle, reach = 0.5 * size, 0.5 * size
    profile = [(0.0, reach), (size, reach)]
    surface = revolved_surface(profile, 24)
    surface = replace(surface, vertices=surface.vertices + np.array([middle, middle, 0.0]))
    if polygonal:
        angle = 2.0 * np.pi * (np.arange(24) + 0.5) / 24
        normal = np.stack([np.cos(angle), np.sin(angle), np.zeros(24)], axis=1)
        normal = np.concatenate([normal, [[0, 0, 1.0], [0, 0, -1.0]]])
        offset = np.append(normal[:24] @ [middle, middle, 0.0] + reach * np.cos(np.pi / 24), [size, 0.0])
        shape = Polyhedron(normal, offset, surface)
        volume = size * reach**2 * 12.0 * np.sin(2.0 * np.pi / 24)
    else:
        shape = Cone(np.array([middle, middle, 0.0]), np.array([0.0, 0.0, 1.0]), size, reach, reach)
        volume = size * np.pi * reach**2
    inside = np.hypot(*(bed.position[:, :2] - middle).T) < 0.95 * reach
    arrays = {name: getattr(bed, name)[inside] for name in ("set_index", "zone_index", "batch_index")}
    return replace(
        bed, position=bed.position[inside], radius=bed.radius[inside], **arrays,
        container=make_container(shape, surface, volume),
    )  # fmt: skip


def test_walls_of_a_mesh_are_checked_to_the_last_digit_too(tmp_path):
    bed = in_a_tube(shaken(), polygonal=True)
    vessel = bed.container
    mesh = replace(vessel, shape=Mesh(vessel.surface))
    pieces, gathered = split(replace(bed, container=mesh), tmp_path, 200)
    assert check_pieces(pieces) == check_bed(gathered)


@pytest.mark.parametrize("polygonal", [False, True])
def test_round_walls_are_checked_to_the_last_digit_too(tmp_path, polygonal):
    pieces, gathered = split(in_a_tube(shaken(), polygonal=polygonal), tmp_path)
    assert check_pieces(pieces) == check_bed(gathered)


def compared(found, wanted, path=""):
    """Hold nested values against each other: counts exactly, other numbers to rounding."""
    if path.lstrip(".") in LEFT_OUT:
        assert found is None
    elif isinstance(wanted, dict):
        assert found.keys() == wanted.keys(), path
        for key in wanted:
            compared(found[key], wanted[key], f"{path}.{key}")
    elif isinstance(wanted, (tuple, list)):
        assert len(found) == len(wanted), path
        for one, other in zip(found, wanted, strict=True):
            compared(one, other, path)
    elif isinstance(wanted, float):
        assert found == pytest.approx(wanted, rel=1e-9, abs=1e-12), path
    else:
        assert found == wanted, path


@pytest.mark.parametrize("kind", ["box", "tube", "prism"])
def test_the_measures_are_those_of_the_gathered_bed_to_rounding(tmp_path, kind):
    bed = shaken(14, seed=1)
    bed = bed if kind == "box" else in_a_tube(bed, polygonal=kind == "prism")
    pieces, gathered = split(bed, tmp_path, 150)
    zones = [Zone(bed.count + 5, bed.count)]
    wanted = measure_bed(gathered, zones=zones, threads=1)
    found = measure_pieces(pieces, check_pieces(pieces), zones=zones)
    for each in fields(Measures):
        one, other = ({each.name: getattr(of, each.name)} for of in (found, wanted))
        compared(plain(one), plain(other))
    assert found.faults() == wanted.faults()
    assert sum(found.order.bonds[2:]) > 100
    assert (found.radial is None) == (kind == "box")
    assert found.stands_at_friction.blocks > 0


def test_crystals_are_found_across_the_seams(tmp_path):
    position = fcc_lattice(6, 1.0)
    shift = np.random.default_rng(0).random(position.shape) * np.where(position[:, [0]] > 8.0, 0.5, 0.1)
    size = 6 * 2.0 * np.sqrt(2.0)
    bed = make_bed(position + shift, 0.8, box_container(np.full(3, -1.0), np.full(3, size + 1.0)))
    pieces, gathered = split(bed, tmp_path, 60)
    found = measure_pieces(pieces, check_pieces(pieces)).order
    assert found == measure_bed(gathered, threads=1).order
    assert 0.2 < found.crystal < 0.9


def plain(values):
    return {
        name: asdict(value) if hasattr(value, "__dataclass_fields__") else
        [asdict(each) for each in value] if isinstance(value, tuple) else value
        for name, value in values.items()
    }  # fmt: skip


class Zone:
    def __init__(self, asked, placed):
        self.asked, self.placed = asked, placed


def test_of_very_many_radii_classes_are_kept_that_hold_the_steps_of_a_law():
    radius = np.sort(1.0 + np.random.default_rng(0).random(5000) * 1e-4)
    radius[4000:] = radius[-1]
    found = RadiusClasses.of(radius[::2]).join(RadiusClasses.of(radius[1::2]), most=1000)
    assert len(found.radius) < 20
    assert found.number.sum() == 5000
    assert found.radius[-1] == radius[-1]
    assert found.number[-1] >= 1000
    below = np.searchsorted(radius, found.radius, side="right")
    assert np.array_equal(np.cumsum(found.number), below)


@pytest.mark.parametrize("step", ["check", "measure", "csv", "liggghts", "lammps", "yade", "extxyz", "vtk"])
def test_what_a_step_holds_does_not_grow_with_the_number_of_pieces(tmp_path, step, monkeypatch):
    # Samples are as large for each bed; here they are small beside a piece.
    monkeypatch.setattr(import_module("packgen.measure.standing"), "SAMPLE", 100)
    monkeypatch.setattr("packgen.pieces.measure.BLOCK_SIZE", 20)
    monkeypatch.setattr("packgen.pieces.measure.center_step", lambda count: count // 100)
    held = []
    bed_of = PieceBed.bed_of
    monkeypatch.setattr(
        PieceBed,
        "bed_of",
        lambda self, parts, *chosen: held.append(sum(map(len_of, parts))) or bed_of(self, parts, *chosen),
    )
    most = []
    for length in (5, 10):
        box = box_container(np.zeros(3), np.array([16.0, 16.0, 16.0 * length]))
        cube = cubic_lattice(8, 1.0)
        shifts = [np.array([0.0, 0.0, 16.0 * each]) for each in range(length)]
        position = np.concatenate([cube + shift for shift in shifts])
        pieces, _ = split(make_bed(position, 0.999, box), tmp_path / str(length), 500)
        assert len(pieces.pieces) == length
        held.clear()
        if step == "check":
            check_pieces(pieces)
        elif step == "measure":
            measure_pieces(pieces, replace(check_pieces(pieces), overlap_count=1))
        else:
            exporter = exporters.get(step)
            (tmp_path / f"{step}_{length}").mkdir()
            exporter.write(pieces, tmp_path / f"{step}_{length}", exporter.Options())
        most.append(max(held))
    assert most[1] <= 1.05 * most[0] < 0.6 * 8**3 * 5


def len_of(columns):
    return len(columns.radius)
