"""Clumps in the solvers themselves: one falls as gravity has it, and turns by its true inertia."""

from __future__ import annotations

import shutil
import subprocess

import numpy as np
import pytest

import exporters
from packgen.bodies import member_shares, rotations
from tests.beds import box_container
from tests.clump_beds import bed_of, bent, bodies_at

SOLVERS = {"liggghts": "liggghts", "lammps": "lmp", "yade": "yade"}
SPIN = np.array([3.0, -2.0, 5.0])  # rad/s
PARTS, STEPS = 10, 2000

# Each look: centres and velocities of the spheres, in a file of its own.
OF_LAMMPS = """\
include in.bed
{start}dump looks all custom {steps} look_*.txt id x y z vx vy vz
dump_modify looks format {word}"%d %.17g %.17g %.17g %.17g %.17g %.17g"
run {total}
"""
# Velocities of a rigid turn about the clump's centre; the solver finds spin and momentum from them.
SPUN = """\
variable u atom {wy}*(z-{z})-{wz}*(y-{y})
variable v atom {wz}*(x-{x})-{wx}*(z-{z})
variable w atom {wx}*(y-{y})-{wy}*(x-{x})
velocity all set v_u v_v v_w
"""
OF_YADE = """\
import numpy as np
setup_only = True
exec(compile(open("bed.py").read(), "bed.py", "exec"))
clump = O.bodies[clumps[0]]
turn = clump.state.ori.toRotationMatrix()
local = turn.transpose() * Vector3({wx}, {wy}, {wz})
clump.state.angVel = Vector3({wx}, {wy}, {wz})
clump.state.angMom = turn * Vector3(*(local[k] * clump.state.inertia[k] for k in range(3)))
for part in range({parts} + 1):
    rows = [(index + 1, *O.bodies[index].state.pos, *O.bodies[index].state.vel) for index in range({count})]
    np.savetxt("look_%d.txt" % (part * {steps}), rows, fmt="%.17g")
    O.run({steps}, True)
"""


def falling(folder, solver, *, gravity, spin):
    """Centres and velocities of the spheres of a clump in the middle of nowhere, (looks, spheres, 6)."""
    bed = bed_of(
        bodies_at([[0.05, 0.05, 2.9]], [1]),
        box_container([0, 0, 0], [0.1, 0.1, 3.0]),
        gravity=np.array([0, 0, -gravity]),
    )
    exporter = exporters.get(solver)
    exporter.write(bed, folder, exporter.Options())
    wx, wy, wz = spin
    known = {"wx": wx, "wy": wy, "wz": wz, "steps": STEPS, "parts": PARTS, "count": bed.count}
    if solver == "yade":
        (folder / "fall.py").write_text(OF_YADE.format(**known))
        command = ["yade", "-n", "-x", "-j1", "fall.py"]
        deck = (folder / "bed.py").read_text()
        timestep = float(deck.split("O.dt = ")[1].split()[0])
    else:
        word = "" if solver == "liggghts" else "line "
        start = ""
        if any(spin) and solver == "liggghts":
            x, y, z = bed.bodies.position[0]
            start = SPUN.format(x=x, y=y, z=z, **known)
        elif any(spin):
            moment = 2500.0 * bed.bodies.inertia[0] @ spin
            infile = folder / "clumps.infile"
            words = infile.read_text().split("\n")[1].split(" ")
            words[14:17] = map(repr, moment.tolist())
            infile.write_text("1\n" + " ".join(words) + "\n")
        text = OF_LAMMPS.format(start=start, word=word, total=PARTS * STEPS, **known)
        (folder / "fall").write_text(text)
        command = [SOLVERS[solver], "-in", "fall", "-log", "none", "-var", "setup_only", "1"]
        timestep = float((folder / "in.bed").read_text().split("\ntimestep ")[1].split()[0])
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace", check=False)
    assert done.returncode == 0, done.stdout[-2000:]
    looks = []
    for part in range(PARTS + 1):
        lines = (folder / f"look_{part * STEPS}.txt").read_text().splitlines()[-bed.count :]
        rows = np.array([[float(word) for word in line.split()] for line in lines])
        looks.append(rows[np.argsort(rows[:, 0]), 1:])
    return bed, np.array(looks), STEPS * timestep


def needs(solver):
    missing = shutil.which(SOLVERS[solver]) is None
    return pytest.param(solver, marks=pytest.mark.skipif(missing, reason=f"{solver} is not installed"))


@pytest.mark.solver
@pytest.mark.parametrize("solver", [needs(each) for each in SOLVERS])
def test_a_clump_falls_with_all_digits_of_gravity_and_does_not_turn(tmp_path, solver):
    _, looks, time = falling(tmp_path, solver, gravity=9.81, spin=np.zeros(3))
    place = looks[:, :, :3]
    # Second differences: whatever the solver's first step does.
    found = (place[2:] - 2 * place[1:-1] + place[:-2]) / time**2
    assert np.abs(found[:, :, 2] + 9.81).max() < 5e-7 * 9.81
    assert np.abs(found[:, :, :2]).max() < 5e-6
    apart = place - place[:, :1]
    assert np.abs(apart - apart[0]).max() < 1e-12


@pytest.mark.solver
@pytest.mark.parametrize("solver", [needs(each) for each in SOLVERS])
def test_a_clump_that_spins_keeps_its_energy_and_its_moment_with_its_true_inertia(tmp_path, solver):
    bed, looks, _ = falling(tmp_path, solver, gravity=0.0, spin=SPIN)
    share = member_shares(bent())
    inertia = 2500.0 * bent().inertia
    energies, moments = [], []
    for look in looks[1:]:  # YADE's spheres have their speeds after the first step
        apart, speed = look[:, :3] - share @ look[:, :3], look[:, 3:] - share @ look[:, 3:]
        # v = w x r, solved for w; the turn of the template's spheres by Kabsch.
        rows = np.concatenate([[[0, z, -y], [-z, 0, x], [y, -x, 0]] for x, y, z in apart])
        spin = np.linalg.lstsq(rows, speed.ravel(), rcond=None)[0]
        left, _, right = np.linalg.svd(bent().spheres[:, :3].T @ apart)
        turn = right.T @ np.diag([1, 1, np.linalg.det(left @ right)]) @ left.T
        moment = turn @ inertia @ turn.T @ spin
        energies.append(0.5 * spin @ moment)
        moments.append(moment)
    turned = rotations(bed.bodies.orientation)[0]
    if solver != "liggghts":  # that one finds the spin by its own masses
        assert energies[0] == pytest.approx(0.5 * SPIN @ turned @ inertia @ turned.T @ SPIN, rel=1e-4)
    assert np.ptp(energies) < 1e-3 * energies[0]
    assert np.abs(np.array(moments) - moments[0]).max() < 2e-3 * np.linalg.norm(moments[0])
    # It tumbled: without that, nothing would have been asked of its axes.
    assert np.abs(looks[-1, :, :3] - looks[0, :, :3]).max() > 0.002
