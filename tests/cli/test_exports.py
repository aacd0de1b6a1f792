from __future__ import annotations

from dataclasses import replace

import pytest

import exporters
from packgen.cli.exports import Format, check_formats, export_settings, outlook_of, outlook_of_bed
from packgen.container import load_container
from packgen.errors import ExportError
from packgen.scene import load_scene
from tests.clump_beds import lattice_of_clumps

CHOSEN = {name: exporters.get(name) for name in ("liggghts", "fraction")}


def test_options_reach_their_exporter_as_its_own_types(tmp_path):
    given = ["fraction.cell_size=0.25", "liggghts.walls = mesh", "liggghts.steps=7"]
    settings = export_settings(CHOSEN, given, tmp_path)
    assert settings["fraction"].cell_size == 0.25
    assert (settings["liggghts"].walls, settings["liggghts"].steps) == ("mesh", 7)
    assert settings["liggghts"].templates == tmp_path.resolve()


def test_all_wrong_options_are_told_at_once():
    given = ["fraction.cell_size=-1", "liggghts.wals=mesh", "lammps.steps=3", "steps=3"]
    with pytest.raises(ExportError) as caught:
        export_settings(CHOSEN, given, None)
    lines = str(caught.value).splitlines()
    assert len(lines) == 4
    for part in (
        "fraction.cell_size: found '-1'",
        "liggghts.wals: ",
        "add --export lammps",
        "NAME.KEY=VALUE",
    ):
        assert any(part in line for line in lines), part


def test_formats_without_clumps_refuse_a_scene_of_clumps_before_the_run():
    formats = {name: Format(exporters.get(name), None) for name in ("mfix", "csv", "kratos")}
    bed = lattice_of_clumps((1, 1, 2))
    place = str
    with pytest.raises(ExportError) as caught:
        check_formats(formats, outlook_of_bed(bed, place))
    assert [line.split(":")[0] for line in str(caught.value).splitlines()] == ["mfix", "kratos"]
    check_formats(formats, outlook_of_bed(replace(bed, bodies=None), place))


def test_the_radii_of_a_scene_of_clumps_are_those_of_their_spheres():
    scene = load_scene(
        {
            "container": {"box": {"min": [0, 0, 0], "max": [1, 1, 1]}},
            "particle_sets": [
                {
                    "radius_distribution": "constant",
                    "radius": 0.01,
                    "shape": {"dumbbell": {"radius": 1, "distance": 2}},
                }
            ],
            "zones": [{"n_particles": 3}],
        }
    )
    outlook = outlook_of(scene, load_container(scene))
    assert outlook.clumps
    assert outlook.radius_max == pytest.approx(0.01 / 2 ** (1 / 3))
