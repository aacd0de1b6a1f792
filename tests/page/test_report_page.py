from __future__ import annotations

import base64
import json
import re
from dataclasses import dataclass, replace
from html.parser import HTMLParser

import numpy as np
import pytest

from packgen.bedfile import save_bed
from packgen.errors import PackgenError
from packgen.geometry import Cone
from packgen.page import report_folder
from packgen.page.figures import key_figures
from packgen.page.spheres import read_spheres, spheres_of, view_data
from packgen.report import build_report
from packgen.search import Search
from tests.beds import box_container, cubic_lattice, make_bed, make_container, revolved_surface
from tests.cells import close_packing

PAGE_MAX = 5_000_000


@dataclass
class Zone:
    asked: int | None
    placed: int


class Page(HTMLParser):
    """What the tests look at in a page."""

    def __init__(self, text):
        super().__init__()
        self.values, self.tags, self.loaded, self.scripts, self._inside = {}, [], [], {}, None
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        self.tags.append((tag, found))
        if tag == "data":
            self.values[found["data-key"]] = float(found["value"])
        if tag == "script":
            self._inside = found.get("id", "code")
        self.loaded += [found[name] for name in ("src", "href", "srcset", "action") if name in found]

    def handle_endtag(self, tag):
        self._inside = None

    def handle_data(self, data):
        if self._inside:
            self.scripts[self._inside] = self.scripts.get(self._inside, "") + data


def result_folder(folder, bed, zones=()):
    save_bed(bed, folder / "bed.npz")
    report = replace(
        build_report(bed, zones=zones), timings={"arrange": 1.5}, files=("bed.npz", "report.json")
    )
    report.write(folder / "report.json")
    return folder


def lattice_folder(folder, **changes):
    bed = make_bed(cubic_lattice(5, 0.1), 0.1, box_container([0, 0, 0], [1, 1, 1]), **changes)
    return result_folder(folder, bed, [Zone(125, 125)])


def read(folder):
    report = json.loads((folder / "report.json").read_text())
    return Page(report_folder(folder).read_text(encoding="utf-8")), report


def test_every_figure_has_the_exact_value_of_report_json(tmp_path):
    page, report = read(lattice_folder(tmp_path))
    known = {"sphere_count", "solid_fraction.filled", "overlap.overlap_max", "contacts.2.mean"}
    known |= {"close_packing.reached"}
    known |= {"contacts.2.rattlers", "order.crystal", "order.crystal_wall", "step_zero.force_max"}
    known |= {"coordination.plateau", "coordination.rattlers"}
    known |= {"stands_at_friction.friction_least", "stands_at_friction.not_carried"}
    assert known <= set(page.values)
    for key, value in page.values.items():
        found = report
        for step in key.split("."):
            found = found[int(step)] if step.isdigit() else found[step]
        assert value == found, key


def test_the_page_holds_report_json_itself(tmp_path):
    folder = lattice_folder(tmp_path)
    page, _ = read(folder)
    assert json.loads(page.scripts["report-data"]) == json.loads((folder / "report.json").read_text())


def test_the_page_loads_nothing(tmp_path):
    page, _ = read(lattice_folder(tmp_path))
    assert set(page.loaded) <= {"data:,"}
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    text = re.sub(r'"(place|size)":"[^"]*"', "", text)  # base64 may spell anything
    assert (
        re.search(
            r"https?:|//[a-z]|@import|url\(|fetch\(|import\(", re.sub(r"^ *//.*$", "", text, flags=re.M)
        )
        is None
    )


@pytest.mark.parametrize(
    ("tile", "said"), [(None, "optimiser projection<"), ("auto", "projection, in tiles<")]
)
def test_the_page_says_whether_a_bed_was_made_in_tiles(tmp_path, tile, said):
    params = {"optimizer": "projection", "tile": tile}
    lattice_folder(
        tmp_path, provenance={"algorithm": "COLLECTIVE_ARRANGEMENT", "settings": {"params": params}}
    )
    assert said in report_folder(tmp_path).read_text(encoding="utf-8")


def test_a_complete_bed_and_a_missed_one_say_so_in_words(tmp_path):
    for name, placed, word in (("whole", 125, "Complete"), ("part", 120, "Missed")):
        folder = tmp_path / name
        folder.mkdir()
        bed = make_bed(cubic_lattice(5, 0.1)[:placed], 0.1, box_container([0, 0, 0], [1, 1, 1]))
        result_folder(folder, bed, [Zone(125, placed)])
        assert word in report_folder(folder).read_text(encoding="utf-8")


def test_names_of_sets_cannot_break_the_page(tmp_path):
    from packgen.bed import ParticleSet

    name = "</script><b>ore"
    page, _ = read(lattice_folder(tmp_path, particle_sets=(ParticleSet(name, 2500.0, "ore"),)))
    assert json.loads(page.scripts["view-data"])["sets"] == [name]
    assert "b" not in [tag for tag, _ in page.tags]


def test_a_bed_without_spheres_has_a_page(tmp_path):
    bed = make_bed(np.zeros((0, 3)), 0.1, box_container([0, 0, 0], [1, 1, 1]))
    page, _ = read(result_folder(tmp_path, bed))
    assert json.loads(page.scripts["view-data"])["shown"] == 0


def test_a_report_of_an_older_version_has_a_page_with_fewer_plots(tmp_path):
    folder = lattice_folder(tmp_path)
    page, report = read(folder)
    plots = sum(tag == "figure" for tag, _ in page.tags)
    for key in ("profile", "gaps", "order"):
        del report[key]
    del report["contacts"][2]["rattlers"]
    (folder / "report.json").write_text(json.dumps(report))
    page, _ = read(folder)
    assert sum(tag == "figure" for tag, _ in page.tags) == plots - 3


def test_what_a_screen_reader_needs_is_there(tmp_path):
    page, _ = read(lattice_folder(tmp_path))
    names = [tag for tag, _ in page.tags]
    assert {"main", "header", "h1", "caption", "noscript"} <= set(names)
    assert dict(page.tags[0][1]) == {"lang": "en"}
    assert all("aria-label" in found for tag, found in page.tags if tag in {"svg", "canvas"})
    assert next(found for tag, found in page.tags if tag == "canvas")["tabindex"] == "0"
    slider = next(found for tag, found in page.tags if found.get("type") == "range")
    assert "cut" in slider["aria-label"]
    assert next(found for tag, found in page.tags if tag == "output")["for"] == slider["id"]


@pytest.mark.parametrize(("name", "text"), [("report.json", "{"), ("report.json", "{}"), ("bed.npz", "x")])
def test_a_spoilt_folder_is_named(tmp_path, name, text):
    folder = lattice_folder(tmp_path)
    (folder / name).write_text(text)
    with pytest.raises(PackgenError, match=name):
        report_folder(folder)
    assert not (folder / "report.html").exists()


def test_a_validation_is_shown_with_its_verdict(tmp_path):
    from packgen.validation.results import GravityRun, Limits, SolverReport, StepZero, validation_dict

    folder = lattice_folder(tmp_path)
    zero = StepZero(0, 0, 0.0, 0.0, 7.0, 0.0, (1, 2), None, float("nan"), 0.0, 0, None)
    run = GravityRun(1e-4, 0.1, 10, 10, 20.0, (), 0.1, 0.0, 0.1, 0.2, 3, 0.05, 0.001, 0.001, 0.0)
    solver = SolverReport("liggghts", "LIGGGHTS 3.8", 125, zero, run, Limits())
    content = validation_dict({"liggghts": solver})
    (folder / "validation.json").write_text(json.dumps(content))
    text = report_folder(folder).read_text(encoding="utf-8")
    assert "LIGGGHTS 3.8: not confirmed" in text
    assert text.count("✘ missed") == 2  # the force, and the law that is no number
    assert "Solvers against their limits" in text
    assert "liggghts, force" in text


def test_a_round_bed_shows_both_published_curves_and_its_pair_correlation(tmp_path):
    surface = revolved_surface([(0, 1.0), (4, 1.0)], 48)
    tube = Cone(np.zeros(3), np.array([0.0, 0, 1]), 4.0, 1.0, 1.0)
    position = np.random.default_rng(0).uniform([-0.6, -0.6, 0.1], [0.6, 0.6, 3.9], (600, 3))
    bed = make_bed(position, 0.08, make_container(tube, surface, 4 * np.pi))
    text = report_folder(result_folder(tmp_path, bed)).read_text(encoding="utf-8")
    for words in ("Porosity near the wall", "Mueller 1992", "de Klerk 2003", "Pair correlation g(r)"):
        assert words in text
    for line in re.findall(r'points="([^"]*)"', text):
        assert "nan" not in line


def test_what_looks_wrong_is_shown(tmp_path):
    folder = lattice_folder(tmp_path)
    report = json.loads((folder / "report.json").read_text())
    (folder / "report.json").write_text(json.dumps(report | {"warnings": ["the <mesh> was mended"]}))
    assert "the &lt;mesh&gt; was mended" in report_folder(folder).read_text(encoding="utf-8")


def test_a_page_is_titled_by_its_scene_and_its_folder_where_that_has_another_name(tmp_path):
    for folder, title in (("furnace", "furnace"), ("out", "furnace, out")):
        (tmp_path / folder).mkdir()
        lattice_folder(tmp_path / folder, provenance={"scene": "furnace.yaml", "settings": {}})
        text = report_folder(tmp_path / folder).read_text(encoding="utf-8")
        assert f"<title>{title}: complete - packgen</title>" in text
        assert f"<h1>Bed of {title}</h1>" in text


def test_a_page_made_again_has_the_outline_of_walls_that_are_a_form(tmp_path):
    from packgen.filling.pack import pack

    scene = {
        "container": {"cylinder": {"radius": 1, "height": 3}},
        "particle_sets": [{"radius_distribution": "constant", "radius": 0.3}],
        "zones": [{"n_particles": 20}],
    }
    result_folder(tmp_path, pack(scene).bed)
    view = json.loads(Page(report_folder(tmp_path).read_text(encoding="utf-8")).scripts["view-data"])
    assert view["outlines"][0]["name"] == "container"


def test_the_key_figures_of_a_search_are_value_bound_and_cell():
    cell = (1.0, 1.0, 2.0, 90.0, 90.0, 60.0)
    found = Search(
        "fraction", 0.74, 0.74, 0.7404, "no packing of equal spheres is denser", 0.0005, False, 50, 12, 500,
        2, 2, "done", cell,
    )  # fmt: skip
    report = build_report(close_packing(), search=found)
    figures = {each.label: each.value for each in key_figures(json.loads(report.as_json()))}
    assert figures["Largest fraction found, by 12 of 50 starts"] == "0.74"
    assert figures["Its bound: no packing of equal spheres is denser"] == "0.7404, 0.05% above"
    assert figures["Edges of the cell"] == "1 x 1 x 2 m"
    assert figures["Angles of the cell, degrees"] == "90, 90, 60"


def test_the_view_of_a_cell_has_its_twelve_edges_also_when_it_is_made_again(tmp_path):
    bed = close_packing()
    save_bed(bed, tmp_path / "bed.npz")
    for spheres in (spheres_of(bed), read_spheres(tmp_path / "bed.npz", None)):
        (lines,) = view_data(spheres)["outlines"]
        ends = np.frombuffer(base64.b64decode(lines["ends"]), "<f4").reshape(-1, 2, 3)
        assert len(ends) == 12
        assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) == pytest.approx(np.ones(12), rel=1e-6)
