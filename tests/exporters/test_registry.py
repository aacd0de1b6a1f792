from __future__ import annotations

from importlib.metadata import EntryPoint
from types import SimpleNamespace

import pytest

import exporters
from packgen.errors import ExportError


def test_every_name_leads_to_an_exporter_of_that_name():
    assert "liggghts" in exporters.names()
    for name in exporters.BUILTIN:
        exporter = exporters.get(name)
        assert name == exporter.NAME
        exporter.Options()


def test_an_unknown_name_is_refused_with_the_choices():
    with pytest.raises(ExportError, match="'ligghts'; there are liggghts, lammps, yade"):
        exporters.get("ligghts")


def test_a_plug_in_is_found_by_its_entry_point(monkeypatch):
    points = [EntryPoint("abc", "json:decoder", exporters.ENTRY_POINT_GROUP)]
    points += [EntryPoint("lost", "no_such_module", exporters.ENTRY_POINT_GROUP)]
    monkeypatch.setattr(exporters, "entry_points", lambda group: points)
    assert exporters.names()[-2:] == ("abc", "lost")
    with pytest.raises(ExportError, match="has no NAME, Options, write"):
        exporters.get("abc")
    with pytest.raises(ExportError, match="does not load: No module named 'no_such_module'"):
        exporters.get("lost")


def test_a_plug_in_cannot_replace_one_of_ours(monkeypatch):
    plugin = SimpleNamespace(name="liggghts", value="x", load=lambda: None)
    monkeypatch.setattr(exporters, "entry_points", lambda group: [plugin])
    assert exporters.get("liggghts").NAME == "liggghts"


def test_the_head_of_a_deck_names_what_the_core_writes_as_provenance():
    from exporters.shared import deck
    from tests.exporters.beds import lattice

    bed = lattice(provenance={"packgen": "1.2.3", "scene": "dir/furnace.yaml", "seed": 7, "settings": {}})
    assert deck.provenance_values(bed) == {"version": "1.2.3", "scene": "furnace.yaml", "seed": "7"}


def test_what_formats_need_of_a_bed_is_known_and_all_where_they_do_not_say(monkeypatch):
    needs = {name: exporters.get(name).NEEDS for name in exporters.BUILTIN}
    assert {need for each in needs.values() for need in each} == {"density", "materials", "walls"}
    assert all(len(needs[name]) == 3 for name in needs if exporters.get(name).IS_DECK)
    silent = SimpleNamespace(NAME="silent", Options=dict, write=print)
    plugin = SimpleNamespace(name="silent", value="x", load=lambda: silent)
    monkeypatch.setattr(exporters, "entry_points", lambda group: [plugin])
    assert exporters.get("silent").NEEDS == ("density", "materials", "walls")
