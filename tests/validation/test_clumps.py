"""Validation and settling judge clumps as bodies."""

from __future__ import annotations

import shutil

import numpy as np
import pytest

import exporters
from packgen.bodies import Bodies
from packgen.check import check_bed
from packgen.filling.pack import pack
from packgen.settling import settle
from packgen.validation import validate
from packgen.validation.measure import Trajectory, gravity_run
from tests.beds import box_container
from tests.clump_beds import bed_of, lattice_of_clumps, pair

PROGRAMS = {"liggghts": "liggghts", "lammps": "lmp", "yade": "yade"}


def pile(gap=0.0):
    """Pairs that lie flat on each other and on the floor, in rows, held by walls a little beside them."""
    grid = np.stack(np.meshgrid(np.arange(2), np.arange(3), np.arange(3), indexing="ij"), axis=-1).reshape(
        -1, 3
    )
    place = grid * [0.0181, 0.0101, 0.01 - gap] + [0.00905, 0.00505, 0.005 - gap]
    turn = np.tile([1.0, 0, 0, 0], (len(place), 1))
    bodies = Bodies((pair(),), np.zeros(len(place), np.int32), np.ones(len(place)), place, turn)
    return bed_of(bodies, box_container([0, 0, 0], [0.0362, 0.0303, 0.05]))


def solvers():
    for name, program in PROGRAMS.items():
        missing = shutil.which(program) is None
        yield pytest.param(name, marks=pytest.mark.skipif(missing, reason=f"{name} is not installed"))


@pytest.mark.solver
@pytest.mark.parametrize("solver", list(solvers()))
def test_a_pile_of_clumps_stands_in_the_solver_and_overlaps_are_judged_in_weights_of_bodies(tmp_path, solver):
    exporter = exporters.get(solver)
    for gap, folder in ((0.0, tmp_path / "good"), (3.0e-5, tmp_path / "pressed")):
        bed = pile(gap)
        folder.mkdir()
        exporter.write(bed, folder, exporter.Options())
        report = validate(bed, folder, solver=solver)
        assert (report.sphere_count, report.body_count) == (36, 18)
        assert report.gravity_run.lost == ()
        assert report.step_zero.law_error < 1e-6
        assert ("largest step-0 force" in " ".join(report.missed)) == (gap > 0)
        # Hertz at 0.6 % of a radius: (4/3 Y sqrt(r/2) d^1.5) over the weight of one pair.
        if gap > 0:
            stiff = 4 / 3 * 1.0e7 / (2 * (1 - 0.3**2)) * np.sqrt(0.005 / 2)
            weight = 2500 * bed.bodies.volume[0] * 9.81
            assert report.step_zero.pair_force_max == pytest.approx(stiff * gap**1.5 / weight, rel=1e-3)
        else:
            assert report.passed, report.missed


@pytest.mark.solver
@pytest.mark.parametrize("solver", list(solvers()))
def test_settled_clumps_are_where_the_solver_left_their_spheres(tmp_path, solver):
    bed = pile()
    exporter = exporters.get(solver)
    exporter.write(bed, tmp_path, exporter.Options())
    settled = settle(bed, tmp_path, solver=solver, time=0.02).bed
    assert settled.bodies.position[:, 2].mean() < bed.bodies.position[:, 2].mean()
    assert check_bed(settled).bodies.misplaced_count == 0


@pytest.mark.slow
@pytest.mark.physics
@pytest.mark.solver
@pytest.mark.skipif(shutil.which("lmp") is None, reason="lmp is not installed")
def test_tetrapods_hardly_move_in_the_solver(tmp_path):
    tetrapods = {"radius_distribution": "constant", "radius": 0.005, "density": 2500}
    tetrapods["shape"] = {"tetrapod": {"radius": 0.003, "arm": 0.008}, "spheres": 5}
    cylinder = {"cylinder": {"radius": 0.03, "height": 0.3}}
    bed = pack({"container": cylinder, "particle_sets": [tetrapods], "zones": [{"n_particles": 200}]}).bed
    exporter = exporters.get("lammps")
    exporter.write(bed, tmp_path, exporter.Options())
    report = validate(bed, tmp_path, solver="lammps")
    assert report.passed, report.missed
    assert report.gravity_run.sinking < 0.015


def test_ways_are_those_of_bodies_and_a_body_that_loses_a_sphere_is_lost():
    bed = lattice_of_clumps((2, 2, 2), singles=True)
    moved = bed.position + np.array([0.0, 0.0, -0.001])
    kept = np.arange(1, bed.count)
    run = Trajectory(1e-5, 10, 10, kept, moved[kept], np.zeros(2))
    found = gravity_run(bed, bed.position, run)
    assert found.lost == (0,)
    assert found.displacement_mean == pytest.approx(0.001 / bed.bodies.equivalent_radius.mean())
