"""Every command and snippet of the documentation runs, and its reference and links are those of today."""

from __future__ import annotations

import importlib
import importlib.util
import re
import shutil
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from packgen.arrange.collective.plan import LayerPlan
from packgen.arrange.projection.recipe import Recipe
from packgen.scene import load_scene
from tests.snippets import ROOT, Reader, blocks_of, commands_of, pages

EXAMPLES = ROOT / "examples"
SOLVERS = ("liggghts", "lammps", "yade")


def solvers_of(page):
    """The solvers that a page's commands need."""
    fences = re.findall(r"^```bash\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    text = "\n".join(fences)
    named = {solver for solver in SOLVERS if re.search(rf"{solver} -|--(solver|settle) \S*{solver}", text)}
    return named | ({"liggghts"} if "--validate" in text else set())


def page_cases():
    for page in pages():
        needed = solvers_of(page)
        programs = ["lmp" if each == "lammps" else each for each in needed]
        marks = [pytest.mark.slow]
        if needed:
            absent = [each for each in programs if shutil.which(each) is None]
            marks += [pytest.mark.solver, pytest.mark.skipif(bool(absent), reason=f"not installed: {absent}")]
        yield pytest.param(page, id=page.relative_to(ROOT).as_posix(), marks=marks)


@pytest.mark.parametrize("page", list(page_cases()))
def test_a_reader_who_follows_the_page_gets_what_it_says(page, tmp_path):
    reader = Reader(tmp_path)
    for block in blocks_of(page):
        reader.follow(block)


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.relative_to(ROOT).as_posix())
def test_every_block_of_a_page_is_of_a_kind_that_is_run(page):
    for block in blocks_of(page):
        assert block.language != "bash" or commands_of(block.text), f"{block}: no command"


def test_scenes_in_the_pages_load(tmp_path, monkeypatch):
    # The guide to plug-ins brings its own algorithm.
    lattice = EntryPoint("LATTICE", "my_plugin.lattice", "packgen.algorithms")
    monkeypatch.setattr("packgen.arrange.registry.entry_points", lambda group: [lattice])
    monkeypatch.syspath_prepend(tmp_path / "my_plugin")
    for path in EXAMPLES.iterdir():
        if path.suffix in {".stl", ".csv"}:
            shutil.copy(path, tmp_path)
    # The guide to beds from elsewhere goes on from the result of an earlier command.
    (tmp_path / "lower").mkdir()
    (tmp_path / "lower" / "bed.npz").touch()
    count = 0
    for page in pages():
        for block in blocks_of(page):
            if block.name and block.language not in {"yaml", "bash"}:
                (tmp_path / block.name).parent.mkdir(parents=True, exist_ok=True)
                (tmp_path / block.name).write_text(block.text, encoding="utf-8")
            elif block.language == "yaml":
                path = tmp_path / (block.name or "snippet.yaml")
                path.write_text(block.text, encoding="utf-8")
                # A scene before may have had Python look for the plug-in's folder when it was not there yet.
                importlib.invalidate_caches()
                load_scene(path)
                count += 1
            elif block.language == "bash":
                for copied in re.findall(r"^cp examples/(\S+) (\S+)$", block.text, re.MULTILINE):
                    shutil.copy(EXAMPLES / copied[0], tmp_path / copied[1])
    assert count > 5


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(page):
    text = page.read_text(encoding="utf-8")
    targets = re.findall(r"\]\(([^)\s]+)\)", text)
    gone = [each for each in targets if not re.match(r"https?:|#", each)]
    gone = [each for each in gone if not (page.parent / each.split("#")[0]).exists()]
    assert not gone


def test_the_tutorial_links_every_guide_and_every_scene():
    text = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    for page in (EXAMPLES / "guides").glob("*.md"):
        assert f"(guides/{page.name})" in text
    for scene in EXAMPLES.glob("*.yaml"):
        assert f"({scene.name})" in text


def script(path: Path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_reference_is_what_schema_docstrings_and_parser_say():
    module = script(EXAMPLES / "guides" / "make_reference.py")
    text = (EXAMPLES / "guides" / "reference.md").read_text(encoding="utf-8")
    assert text == module.reference(), "out of date: python examples/guides/make_reference.py"


def test_the_explanation_names_todays_constants():
    text = (EXAMPLES / "guides" / "how_it_works.md").read_text(encoding="utf-8")
    recipe, plan = Recipe(), LayerPlan()
    assert plan.first == 2.0
    for phrase in (
        f"**layers** {plan.thickness:g} diameters thick, the first one on a floor twice as much",
        f"**topmost {plan.reopened:g} diameter of the bed moves again**",
        f"In each of {recipe.sink_sweeps} sweeps", f"from {100 * recipe.sink_first:g} % of a radius",
        f"A share of {recipe.momentum:g} of a sphere's",
        f"During the first {recipe.grain_sweeps} sweeps", f"up to {recipe.grain:g} of its radius",
        f"radii larger by {100 * recipe.gap:g} %",
        f"The default is {recipe.tolerance:.0e}".replace("e-0", "e-"),
    ):  # fmt: skip
        assert phrase in " ".join(text.split())


def test_an_unknown_kind_of_block_is_refused(tmp_path):
    page = tmp_path / "page.md"
    for text in (
        "```\nls\n```\n",
        "```json\n{}\n```\n",
        "```csv\na,b\n```\n",
        "~~~\nls\n~~~\n",
        "words\n\n    ls\n",
    ):
        page.write_text(text)
        with pytest.raises(ValueError, match=r"page\.md:\d"):
            blocks_of(page)
