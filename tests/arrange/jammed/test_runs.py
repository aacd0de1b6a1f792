"""Claims on whole runs of jammed scenes: exit codes, what is said, decks with the container as it became."""

from __future__ import annotations

import json

import pytest

from packgen.cli import main

SCENE = """\
container: {box: {min: [0, 0, 0], max: [1, 1, 1]}, periodic: [x, y, z]}
algorithm: JAMMED
params: {%s}
particle_sets: [{radius_distribution: constant, radius: 0.1}]
zones: [%s]
"""


def run(folder, params, zones, *options):
    (folder / "scene.yaml").write_text(SCENE % (params, zones), encoding="utf-8")
    return main([str(folder / "scene.yaml"), "-o", str(folder / "out"), *options])


def test_report_screen_page_and_decks_have_the_cell_that_was_reached(tmp_path, capsys):
    assert run(tmp_path, "", "{n_particles: 60}", "--export", "liggghts,lammps,yade,vtk") == 0
    said = capsys.readouterr().out
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    proof = report["jamming"]
    edge = proof["extent"][0]
    assert "proven by its forces; " in said
    assert f"{edge:.6g} x {edge:.6g} x {edge:.6g} m, {proof['factor']:.6g} times the 1 x 1 x 1 m" in said
    assert report["warnings"] == report["missed"] == []
    assert report["solid_fraction"]["filled"] == pytest.approx(60 * 4.0 / 3.0 * 3.14159265 * 1e-3 / edge**3)
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Jammed (programme), contacts beyond isostatic" in page
    for name in ("liggghts/bed.data", "lammps/bed.data"):
        assert f"{edge!r} xlo xhi" in (tmp_path / "out" / name).read_text()


def test_a_count_that_follows_is_told_with_its_slack(tmp_path, capsys):
    assert run(tmp_path, "adjust: count, certificate: false", "{}", "--no-report") == 0
    said = capsys.readouterr().out
    assert "1 x 1 x 1 m as asked for; all spheres could grow by " in said
    assert "by soft spheres at rest; " in said


@pytest.mark.parametrize(
    ("params", "zones", "message"),
    [
        ("", "{n_particles: 30}, {n_particles: 30}", "5:28: found 2 zones, expected one"),
        ("adjust: count", "{n_particles: 30}", "5:9: found 30 spheres asked for, expected no amount"),
        ("", "{n_particles: 2}", "m long along x, expected at least 0.4 m, two diameters"),
        ("adjust: height", "{n_particles: 30}", "adjust: found 'height', expected one of container, count"),
        ("certificate: maybe", "{n_particles: 30}", "found 'maybe', expected auto, true or false"),
        ("optimizer: adam", "{n_particles: 30}", "params.optimizer: found an unknown key"),
        ("", "{solid_fraction: 0.6}", "zones[0].solid_fraction: found 0.6, expected none: not supported yet"),
    ],
)  # fmt: skip
def test_what_cannot_be_jammed_ends_before_the_run(params, zones, message, tmp_path, capsys):
    assert run(tmp_path, params, zones, "--quiet") == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
