from __future__ import annotations

import os
import shutil
import subprocess

import numpy as np
import pytest

from exporters import cfdem
from tests.exporters.beds import lattice, read_data_file

needs_liggghts = pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed")


def test_the_case_has_the_tutorials_layout(tmp_path):
    paths = cfdem.write(lattice(), tmp_path, cfdem.Options(couple_every=7, walls="mesh"))
    names = {path.relative_to(tmp_path).as_posix() for path in paths}
    assert names == {
        "DEM/in.bed", "DEM/bed.data", "DEM/wall.stl", "DEM/in.liggghts_init", "DEM/in.liggghts_run",
        "parDEMrun.sh",
    }  # fmt: skip
    _, rows = read_data_file(tmp_path / "DEM" / "bed.data")
    assert np.array_equal(rows[:, 4:], lattice().position)
    assert np.array_equal(rows[:, 2], 2 * lattice().radius)
    run = (tmp_path / "DEM" / "in.liggghts_run").read_text()
    assert "read_restart ../DEM/post/restart/liggghts.restart" in run
    assert "file ../DEM/wall.stl" in run
    assert "variable couple_every index 7" in run
    assert os.access(tmp_path / "parDEMrun.sh", os.X_OK)


@needs_liggghts
@pytest.mark.solver
@pytest.mark.parametrize("dumps", ["text", "vtk"])
def test_liggghts_makes_the_restart_and_starts_the_coupled_run_from_it(tmp_path, dumps):
    cfdem.write(lattice(overlap=1e-4), tmp_path, cfdem.Options(dumps=dumps))
    done = subprocess.run(
        ["sh", "parDEMrun.sh"], cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, done.stdout[-2000:]
    (tmp_path / "CFD").mkdir()
    done = subprocess.run(
        ["liggghts", "-in", "../DEM/in.liggghts_run", "-log", "none"], cwd=tmp_path / "CFD",
        capture_output=True, text=True, errors="replace", timeout=60, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-2000:]
    suffix = {"text": ".dump", "vtk": ".vtk"}[dumps]
    assert (tmp_path / "DEM" / "post" / f"bed_0{suffix}").is_file()
    assert "80 atoms" in done.stdout
