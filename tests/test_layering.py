"""The import rules and sizes that keep the project's parts apart."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest

import packgen

ROOT = Path(__file__).resolve().parent.parent
HEAVY = {
    "torch", "trimesh", "pyvista", "meshio", "matplotlib", "overlap", "numba", "scipy", "rich", "numpy",
    "dask", "distributed",
}  # fmt: skip
SLOW_TO_LOAD = HEAVY - {"scipy", "rich", "numpy"}
MODULES = sorted([*ROOT.glob("packgen/**/*.py"), *ROOT.glob("exporters/**/*.py")])
LINES_MAX = 400
ARGUMENTS_MAX = 10


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def imports(path: Path, *, top_only: bool) -> tuple[str, ...]:
    """Dotted names that a module imports; ``from a import b`` gives a.b too."""
    names: list[str] = []
    for node in _top_level(parsed(path)) if top_only else ast.walk(parsed(path)):
        if isinstance(node, ast.Import):
            names += [each.name for each in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names += [f"{node.module}.{each.name}" for each in node.names]
    return tuple(names)


def _top_level(tree: ast.Module) -> Iterator[ast.stmt]:
    """Statements that run when the module is loaded, but for type checking."""
    for node in tree.body:
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            continue
        yield node


def in_package(name: str, package: str) -> bool:
    return name == package or name.startswith(package + ".")


def named(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


@pytest.mark.parametrize("path", sorted(ROOT.glob("exporters/**/*.py")), ids=named)
def test_exporters_know_bed_shapes_arrays_and_errors_and_nothing_else_of_packgen(path):
    of_packgen = {name for name in imports(path, top_only=False) if in_package(name, "packgen")}
    allowed = ("packgen.arrays", "packgen.bed", "packgen.errors", "packgen.geometry")
    assert {name for name in of_packgen if not any(in_package(name, each) for each in allowed)} == set()


@pytest.mark.parametrize("path", sorted(ROOT.glob("packgen/**/*.py")), ids=named)
def test_only_the_command_line_knows_the_exporters(path):
    knows = any(in_package(name, "exporters") for name in imports(path, top_only=False))
    assert not knows or path.is_relative_to(ROOT / "packgen" / "cli")


CHECKS = sorted(ROOT.glob("packgen/check/*.py"))


@pytest.mark.parametrize("path", CHECKS, ids=named)
def test_the_check_shares_no_code_with_the_core(path):
    core = ("packgen.arrange", "packgen.container")
    assert not [
        name for name in imports(path, top_only=False) if any(in_package(name, each) for each in core)
    ]


def known_to(path: Path) -> set[str]:
    """What a module imports of the project, at any place in it."""
    return {name for name in imports(path, top_only=False) if name.split(".")[0] in ("packgen", "exporters")}


def breaches(place: str, *forbidden: str) -> list[tuple[str, str]]:
    """The imports of a package from others that it must not know."""
    return [
        (named(path), name)
        for path in sorted(ROOT.glob(f"packgen/{place}/**/*.py"))
        for name in known_to(path)
        if any(in_package(name, each) for each in forbidden)
    ]


ALGORITHMS = sorted(path.parent.name for path in ROOT.glob("packgen/arrange/*/arrange.py"))
CORE = ("packgen.scene", "packgen.arrange")
UPPER = (
    "packgen.filling",
    "packgen.forecast",
    "packgen.sweep",
    "packgen.report",
    "packgen.validation",
    "packgen.settling",
    "packgen.page",
    "packgen.workers",
    "packgen.cli",
)


def test_there_are_algorithms_with_rooms_of_their_own():
    assert ALGORITHMS == [
        "adam", "advancing_front", "collective", "dispersed", "jammed", "optimal", "shrinking_cell",
        "void_filling",
    ]  # fmt: skip
    assert all((ROOT / "packgen/arrange" / name / "params.py").is_file() for name in ALGORITHMS)


@pytest.mark.parametrize("name", ALGORITHMS)
def test_an_algorithm_knows_no_other_one(name):
    others = [f"packgen.arrange.{other}" for other in ALGORITHMS if other != name]
    assert breaches(f"arrange/{name}", *others) == []


@pytest.mark.parametrize("place", ["space", "neighbors", "projection"])
def test_what_algorithms_share_knows_none_of_them(place):
    assert breaches(f"arrange/{place}", *(f"packgen.arrange.{name}" for name in ALGORITHMS)) == []


@pytest.mark.parametrize(
    ("place", "above"),
    [
        (
            "geometry",
            ("packgen.bed", "packgen.container", "packgen.supply", "packgen.scene", "packgen.arrange"),
        ),
        ("distributions", ("packgen.bed", "packgen.supply", *CORE)),
        ("container", ("packgen.arrange", "packgen.supply", *UPPER)),
        ("supply", ("packgen.container", "packgen.arrange", *UPPER)),
        (
            "programmes",
            ("packgen.bed", "packgen.geometry", "packgen.container", "packgen.supply", *CORE, *UPPER),
        ),
        ("arrange", ("packgen.container", "packgen.scene", "packgen.check", "packgen.measure", *UPPER)),
        (
            "programmes",
            ("packgen.bed", "packgen.container", "packgen.measure", "packgen.check", *CORE, *UPPER),
        ),
        ("measure", ("packgen.arrange", "packgen.container", "packgen.scene", *UPPER)),
        ("reading", ("packgen.arrange", "packgen.supply", "packgen.check", "packgen.measure", *UPPER)),
        ("check", ("packgen.measure", "packgen.scene", *UPPER)),
        (
            "pieces",
            ("packgen.arrange", "packgen.container", "packgen.scene", "packgen.reading", *UPPER),
        ),
        (
            "filling",
            (
                "packgen.forecast",
                "packgen.report",
                "packgen.validation",
                "packgen.page",
                "packgen.workers",
                "packgen.cli",
            ),
        ),
        (
            "forecast",
            (
                "packgen.sweep",
                "packgen.report",
                "packgen.validation",
                "packgen.page",
                "packgen.workers",
                "packgen.cli",
            ),
        ),
        (
            "clumps",
            ("packgen.bed", "packgen.supply", "packgen.scene", "packgen.check", "packgen.measure", *UPPER),
        ),
        ("sweep", ("packgen.arrange", "packgen.filling", "packgen.page", "packgen.cli")),
        (
            "workers",
            ("packgen.filling", "packgen.report", "packgen.validation", "packgen.page", "packgen.cli"),
        ),
    ],
)
def test_no_floor_knows_one_above_it(place, above):
    assert breaches(place, *above) == []


def test_a_scene_knows_of_the_arrangement_only_what_settings_algorithms_have():
    known = {name for path in ROOT.glob("packgen/scene/*.py") for name in known_to(path)}
    assert {".".join(name.split(".")[:3]) for name in known if in_package(name, "packgen.arrange")} == {
        "packgen.arrange.registry"
    }


def test_no_module_imports_itself_by_others_when_it_is_loaded():
    names = {
        ".".join(path.with_suffix("").relative_to(ROOT).parts).removesuffix(".__init__"): path
        for path in MODULES
    }
    needs = {
        name: {
            next((full for full in (each, each.rpartition(".")[0]) if full in names), name)
            for each in imports(path, top_only=True)
            if each.split(".")[0] in ("packgen", "exporters")
        }
        - {name}
        for name, path in names.items()
    }
    left = dict(needs)
    while ready := [name for name, each in left.items() if not each & left.keys()]:
        for name in ready:
            del left[name]
    assert left == {}


LIGHT = [
    path
    for path in MODULES
    if named(path) in {"packgen/__init__.py", "packgen/__main__.py", "packgen/errors.py", "packgen/scene.py"}
    or named(path).startswith(("packgen/cli/", "packgen/scene/"))
]


@pytest.mark.parametrize("path", LIGHT, ids=named)
def test_command_line_and_scene_load_nothing_slow(path):
    loaded = {name.split(".")[0] for name in imports(path, top_only=True)}
    assert loaded & SLOW_TO_LOAD == set()


@pytest.mark.parametrize("path", MODULES, ids=named)
def test_no_module_is_too_long(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= LINES_MAX


def arguments(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """How many arguments a function takes; ``*args`` and ``**kwargs`` count as one each."""
    taken = function.args
    named = [*taken.posonlyargs, *taken.args, *taken.kwonlyargs]
    return len(named) + (taken.vararg is not None) + (taken.kwarg is not None)


@pytest.mark.parametrize("path", MODULES, ids=named)
def test_no_function_takes_too_many_arguments(path):
    nodes = ast.walk(parsed(path))
    functions = [node for node in nodes if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    assert [each.name for each in functions if arguments(each) > ARGUMENTS_MAX] == []


def loaded_by(*arguments: str) -> set[str]:
    """Top-level modules that a run of the command line loads."""
    code = (
        "import sys\n"
        "from packgen.cli import main\n"
        "try:\n"
        f"    main({list(arguments)!r})\n"
        "except SystemExit:\n"
        "    pass\n"
        "print(*sorted({name.split('.')[0] for name in sys.modules}), sep='\\n', file=sys.stderr)\n"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    return set(run.stderr.split())


def test_help_loads_no_heavy_library():
    assert loaded_by("--help") & (HEAVY | {"pydantic", "jinja2", "yaml"}) == set()


def fresh(code: str) -> list[str]:
    """What Python prints in a process of its own."""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    return run.stdout.split()


def test_packgen_alone_loads_no_library_and_nothing_of_itself_but_its_version():
    loaded = set(fresh("import sys, packgen; packgen.__all__; print(*sys.modules)"))
    assert loaded & (HEAVY | {"pydantic", "jinja2", "yaml"}) == set()
    assert {name for name in loaded if name.startswith("packgen")} == {"packgen", "packgen.version"}


@pytest.mark.parametrize("name", [each for each in packgen.__all__ if each != "__version__"])
def test_each_name_of_packgen_is_that_of_its_module(name):
    place = packgen._PLACES[name]
    assert getattr(packgen, name) is getattr(import_module(place), name)
    assert name in dir(packgen)


def test_names_that_packgen_has_not_are_no_attributes():
    assert not hasattr(packgen, "unpack")
    with pytest.raises(ImportError, match="unpack"):
        exec("from packgen import unpack", {})


def test_packgen_offers_what_the_guide_imports():
    assert fresh("from packgen import pack, load_scene; print(pack.__module__, load_scene.__module__)") == [
        "packgen.filling.pack",
        "packgen.scene.load",
    ]


def test_a_scene_error_loads_no_slow_library(tmp_path):
    scene = tmp_path / "wrong.yaml"
    scene.write_text("container: 3\n")
    loaded = loaded_by(str(scene))
    assert "pydantic" in loaded  # it came as far as the scene
    assert loaded & SLOW_TO_LOAD == set()


CLI = sorted(ROOT.glob("packgen/cli/*.py"))
ARGUMENTS_MAX = 10
SCREEN = 60  # lines


@pytest.mark.parametrize("path", CLI, ids=named)
def test_functions_of_the_command_line_take_few_arguments_and_fit_a_screen(path):
    for node in ast.walk(parsed(path)):
        if isinstance(node, ast.FunctionDef):
            given = node.args
            count = len(given.posonlyargs) + len(given.args) + len(given.kwonlyargs)
            assert count <= ARGUMENTS_MAX, node.name
            assert (node.end_lineno or 0) - node.lineno < SCREEN, node.name


@pytest.mark.parametrize("path", CLI, ids=named)
def test_only_one_place_reads_what_the_parser_of_a_run_gives(path):
    taken = [
        ast.unparse(each.annotation)
        for node in ast.walk(parsed(path))
        if isinstance(node, ast.FunctionDef)
        for each in (*node.args.args, *node.args.kwonlyargs)
        if each.annotation is not None
    ]
    wanted = ["argparse.Namespace"] if named(path) == "packgen/cli/options.py" else []
    assert [each for each in taken if "Namespace" in each] == wanted


def test_no_file_names_a_place_on_a_developers_machine():
    places = ("/" + "work/", "/" + "root/", "/" + "tmp/")
    suffixes = {".py", ".md", ".yaml", ".toml", ".j2", ""}
    listed = subprocess.run(["git", "ls-files"], capture_output=True, text=True, check=False, cwd=ROOT).stdout
    paths = [ROOT / name for name in listed.splitlines() if Path(name).suffix in suffixes]
    found = [
        (named(path), place)
        for path in paths
        if path.is_file()
        for place in places
        if place in path.read_text(encoding="utf-8")
    ]
    assert found == []


def test_a_plug_in_finds_the_bed_and_its_shapes_in_one_module():
    import packgen.bed
    import packgen.geometry

    shapes = ("Ball", "Box", "Cone", "Container", "Mesh", "Polyhedron", "Shape", "Surface")
    assert set(packgen.bed.__all__) >= {"Bed", "Material", "ParticleSet", "with_images", *shapes}
    assert all(getattr(packgen.bed, name) is getattr(packgen.geometry, name) for name in shapes)
