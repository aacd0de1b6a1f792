from __future__ import annotations

import pytest

import exporters
from packgen.cli.exports import export_settings
from packgen.errors import ExportError

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
