"""Rolling friction in each solver: a ball on the floor under slanting gravity gets as fast as it should.

A ball of the moment of inertia 2/5 m r^2 that rolls without sliding and is held back by the torque mu r m g_z
accelerates by 5/7 (g_x - mu g_z). LIGGGHTS and LAMMPS have the radius of the ball in the torque; YADE has one
coefficient for walls and pairs, which is right for pairs: half as much at the floor.
"""

from __future__ import annotations

import shutil
import subprocess

import numpy as np
import pytest

import exporters
from packgen.bed import Material
from packgen.validation.process import SOLVERS
from tests.beds import box_container, make_bed

ROLLING, SECONDS = 0.1, 0.3
GRAVITY = np.array([3.0, 0.0, -9.81])
RUN = """\
include in.bed
variable speed equal vx[1]
variable count equal ceil({seconds}/dt)
run ${{count}}
print "speed ${{speed}}"
"""
RUN_YADE = """\
setup_only = True
exec(open("bed.py").read())
O.run(int({seconds} / O.dt) + 1, True)
print("speed", O.bodies[0].state.vel[0])
"""


def speed_of_a_ball(solver, folder, material):
    """The speed of a ball after `SECONDS` from rest [m/s]."""
    container = box_container((0, 0, 0), (2, 1, 1))
    bed = make_bed([[0.5, 0.5, 0.09999]], 0.1, container, materials=(material,), gravity=GRAVITY)
    exporter = exporters.get(solver)
    exporter.write(bed, folder, exporter.Options())
    name, text = ("run.py", RUN_YADE) if solver == "yade" else ("in.run", RUN)
    (folder / name).write_text(text.format(seconds=SECONDS))
    options = ["-in", name, "-log", "none", "-var", "setup_only", "1"]
    options = ["-n", "-x", "-j1", name] if solver == "yade" else options
    done = subprocess.run(
        ["stdbuf", "-oL", SOLVERS[solver][0], *options], cwd=folder, capture_output=True, text=True,
        timeout=60, errors="replace", check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-2000:]
    return float([line for line in done.stdout.splitlines() if line.startswith("speed")][-1].split()[1])


@pytest.mark.solver
@pytest.mark.parametrize("rolling", [0.0, ROLLING])
@pytest.mark.parametrize(("solver", "share"), [("liggghts", 1.0), ("lammps", 1.0), ("yade", 0.5)])
def test_a_rolling_ball_is_held_back_as_asked(tmp_path, solver, share, rolling):
    if shutil.which(SOLVERS[solver][0]) is None:
        pytest.skip(f"{solver} is not installed")
    expected = 5 / 7 * (GRAVITY[0] + share * rolling * GRAVITY[2]) * SECONDS
    found = speed_of_a_ball(solver, tmp_path, Material("ore", rolling_friction=rolling))
    assert found == pytest.approx(expected, rel=0.01)


def test_yade_s_one_coefficient_is_the_mean_over_pairs_of_spheres(tmp_path):
    from exporters import yade
    from exporters.shared import contact
    from tests.validation.beds import bed_in

    bed = bed_in("box")  # coke, ore, coke
    materials = tuple(
        Material(each.name, rolling_friction={"ore": 0.2, "coke": 0.1, "steel": 0.0}[each.name])
        for each in bed.materials
    )
    bed = make_bed(
        bed.position, bed.radius, bed.container, set_index=bed.set_index, particle_sets=bed.particle_sets,
        materials=materials, wall_material="steel",
    )  # fmt: skip
    found = yade.rolling(bed, contact.number_types(bed))
    harmonic = 2 * 0.1 * 0.2 / 0.3
    assert found["coefficient"] == pytest.approx(((2 / 3) ** 2 * 0.1 + 4 / 9 * harmonic + 0.2 / 9) / 2)
    assert np.isfinite(found["stiffness"])
