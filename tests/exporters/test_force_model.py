"""The two codes' contact models are one: a ball that bounces off the floor and one that slides agree."""

from __future__ import annotations

import shutil
import subprocess

import numpy as np
import pytest

from exporters import lammps, liggghts
from packgen.bed import Material
from tests.beds import box_container, make_bed

pytestmark = [
    pytest.mark.solver,
    pytest.mark.skipif(
        not (shutil.which("lmp") and shutil.which("liggghts")),
        reason="lammps and liggghts are not both there",
    ),
]


def test_a_pair_that_collides_with_spin_leaves_with_the_same_velocities_in_both(tmp_path):
    material = Material("ore", 1e8, 0.25, 0.6, 0.3)
    bed = make_bed(
        [[0.5, 0.5, 0.5], [0.5, 0.5, 0.7001]], 0.1, box_container((0, 0, 0), (1, 1, 1)),
        materials=(material,), gravity=np.zeros(3),
    )  # fmt: skip
    speeds = {}
    for exporter, program in ((lammps, "lmp"), (liggghts, "liggghts")):
        folder = tmp_path / exporter.NAME
        folder.mkdir()
        exporter.write(bed, folder, exporter.Options())
        line = "line " if program == "lmp" else ""
        (folder / "in.test").write_text(
            "include in.bed\ngroup second id 2\nvelocity second set 0.2 0.0 -0.5\n"
            "dump t all custom 1000 end.*.dump id vx vy vz omegax omegay omegaz\n"
            f'dump_modify t format {line}"%d %.15g %.15g %.15g %.15g %.15g %.15g"\nrun 1000\n'
        )
        subprocess.run(
            [program, "-in", "in.test", "-log", "none", "-var", "setup_only", "1"], cwd=folder, check=True,
            capture_output=True, timeout=60,
        )  # fmt: skip
        rows = (folder / "end.1000.dump").read_text().split("omegaz")[1]
        speeds[program] = np.array(sorted(row.split() for row in rows.strip().splitlines()), dtype=float)
    both = speeds["lmp"], speeds["liggghts"]
    assert both[0][0, 3] < -0.1  # they have met
    assert abs(both[0][0, 5]) > 0.1  # and spin
    assert np.allclose(both[0][:, 3], both[1][:, 3], rtol=1e-3)
    # Across the normal they differ in how a contact that slides is damped.
    assert np.allclose(both[0], both[1], rtol=0.05, atol=1e-3)
    apart = both[0][1, 3] - both[0][0, 3]
    assert apart == pytest.approx(0.6 * 0.5, rel=0.02)  # the restitution
