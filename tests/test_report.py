from __future__ import annotations

import json
from dataclasses import dataclass, replace

import numpy as np
import pytest

from packgen.bedfile import save_bed
from packgen.geometry import Cone
from packgen.report import KEYS, build_report, compose_report, measure_bed
from packgen.validation import predicted_forces
from tests.beds import box_container, cubic_lattice, make_bed, make_container, revolved_surface


@dataclass
class Zone:
    asked: int | None
    placed: int


def lattice_bed(**changes):
    return make_bed(cubic_lattice(5, 0.1), 0.1, box_container([0, 0, 0], [1, 1, 1]), **changes)


def test_a_complete_bed_misses_nothing():
    report = build_report(lattice_bed(), zones=[Zone(100, 100), Zone(None, 25)])
    assert report.missed == ()
    assert report.sphere_count == 125
    assert report.sets[0].mass == pytest.approx(125 * 2500 * 4 / 3 * np.pi * 0.001)


def test_spheres_that_did_not_fit_are_said():
    (line,) = build_report(lattice_bed(), zones=[Zone(100, 100), Zone(30, 25)]).missed
    assert "zones[1]" in line
    assert "25 of 30" in line


def test_an_overlap_above_tolerance_is_said():
    position = cubic_lattice(5, 0.1)
    position[62] += [0, 0, 0.01]
    report = build_report(make_bed(position, 0.1, box_container([0, 0, 0], [1, 1, 1])))
    assert any("overlap" in line and "62" in line for line in report.missed)


def test_report_json_holds_the_numbers_under_their_names():
    bed = lattice_bed(provenance={"seed": 3, "scene": "a.yaml"})
    report = replace(build_report(bed, zones=[Zone(None, 125)]), timings={"arrange": 1.5}, files=("bed.npz",))
    read = json.loads(report.as_json())
    assert read["sphere_count"] == 125
    unasked = {"solid_fraction_asked": None, "solid_fraction": None, "slack": None}
    assert read["zones"] == [{"asked": None, "placed": 125} | unasked]
    assert read["overlap"]["within_tolerance"] is True
    assert read["solid_fraction"]["filled"] == pytest.approx(np.pi / 6)
    assert [entry["gap"] for entry in read["contacts"]] == [0.0, 0.001, 0.01, 0.05]
    assert read["radial"] is None
    assert read["pair_correlation"] is None  # five spheres across are no room for a core's own
    assert read["order"]["crystal"] == 0.0
    assert read["step_zero"]["force_max"] == pytest.approx(0.0, abs=1e-6)
    assert read["coordination"]["plateau"] == pytest.approx(6.0)  # 300 pairs, 150 contacts with walls
    stands = read["stands_at_friction"]
    assert (stands["friction_least"], stands["stands"], stands["falling"]) == (0.0, True, 0)
    assert read["sizes"][0]["by_number"]["reached"] == [0.1] * 7
    assert read["settings"] == {"seed": 3, "scene": "a.yaml"}
    assert read["timings"] == {"arrange": 1.5}
    assert read["files"] == ["bed.npz"]


def test_a_bed_in_a_tube_has_its_radial_profile_in_report_json():
    shape = Cone(np.zeros(3), np.array([0.0, 0, 1]), 9.0, 3.0, 3.0)
    surface = revolved_surface([(0, 3.0), (9, 3.0)], 48)
    position = np.random.default_rng(0).uniform([-2, -2, 0.2], [2, 2, 8.8], (400, 3))
    bed = make_bed(position, 0.2, make_container(shape, surface, 81 * np.pi))
    report = build_report(bed)
    read = json.loads(report.as_json())
    assert read["radial"]["porosity"] == list(report.radial.porosity)
    assert len(read["radial"]["mueller"]) == len(read["radial"]["wall_distance"]) - 1
    assert read["pair_correlation"]["g"] == list(report.pair_correlation.g)
    assert read["step_zero"]["force_max"] > 0.0


@pytest.mark.parametrize("radius", [0.1 * (1 - 1e-9), 0.1 * (1 + 1e-4)])
def test_forces_are_those_of_the_prediction_whether_anything_overlaps_or_not(radius):
    bed = make_bed(cubic_lattice(5, 0.1), radius, box_container([0, 0, 0], [1, 1, 1]))
    assert build_report(bed).step_zero == predicted_forces(bed)


def test_a_bed_without_gravity_has_no_forces_and_does_not_stand():
    report = build_report(lattice_bed(gravity=np.zeros(3)))
    assert report.step_zero is None
    assert report.stands_at_friction is None


def test_a_bed_that_nothing_carries_has_no_friction_at_which_it_stands():
    report = build_report(replace(lattice_bed(), radius=np.full(125, 0.099)))
    said = dict(report.rows())["stands from a friction of"]
    assert said == "none (100.0% of the weight not carried at its own friction)"


def test_rows_name_count_density_and_overlap():
    rows = dict(build_report(lattice_bed(), zones=[Zone(125, 125)]).rows())
    assert rows["spheres"] == "125 of 125"
    assert rows["solid fraction, filled volume"] == "0.5236"
    assert "tolerance 1e-06" in rows["largest overlap"]


def test_a_bed_is_told_beside_the_random_close_packing_of_its_sizes():
    report = build_report(lattice_bed())
    packing = json.loads(report.as_json())["close_packing"]
    assert packing["fraction"] == pytest.approx(0.6435, abs=1e-4)
    assert packing["reached"] == pytest.approx(report.solid_fraction.core / packing["fraction"])
    assert packing["of"] == "core"
    rows = dict(report.rows())
    assert rows["solid fraction, core"].endswith(f", {packing['reached']:.2f} of its random close packing")


def test_an_empty_bed_has_a_report():
    empty = make_bed(np.empty((0, 3)), 0.1, box_container([0, 0, 0], [1, 1, 1]))
    report = json.loads(build_report(empty, zones=[Zone(5, 0)]).as_json())
    assert report["sphere_count"] == 0
    assert report["close_packing"] is None


def test_bed_file_holds_the_arrays_of_the_contract(tmp_path):
    bed = lattice_bed(provenance={"seed": 3, "params": {"lr": 0.01, "axis": (0.0, 1.0)}})
    save_bed(bed, tmp_path / "bed.npz")
    save_bed(lattice_bed(provenance=bed.provenance), tmp_path / "again.npz")
    with np.load(tmp_path / "bed.npz") as read:
        kinds = {
            name: (read[name].dtype.name, read[name].shape) for name in read.files if name != "provenance"
        }
        provenance = json.loads(str(read["provenance"]))
        np.testing.assert_array_equal(read["position"], bed.position)
    index = ("int32", (125,))
    assert kinds == {
        "position": ("float64", (125, 3)),
        "radius": ("float64", (125,)),
        "set_index": index,
        "zone_index": index,
        "batch_index": index,
    }
    assert provenance == {"seed": 3, "params": {"lr": 0.01, "axis": [0.0, 1.0]}}
    assert (tmp_path / "bed.npz").read_bytes() == (tmp_path / "again.npz").read_bytes()


def test_keys_are_in_their_order_and_what_the_run_missed_comes_after_the_bed():
    bed = lattice_bed(provenance={"seed": 3})
    measures = measure_bed(bed, zones=[Zone(130, 125)])
    report = compose_report(measures, bed.provenance, missed=["no csv deck"], warnings=["odd"])
    assert list(json.loads(report.as_json())) == list(KEYS)
    assert KEYS[:3] == ("packgen", "missed", "sphere_count")
    assert KEYS[-5:] == ("warnings", "timings", "peak_memory", "settings", "files")
    assert report.missed == (*measures.faults(), "no csv deck")
    assert report.warnings == ("odd",)
    assert compose_report(measures, bed.provenance) == build_report(bed, zones=[Zone(130, 125)])
