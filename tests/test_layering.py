"""The import rules and sizes that keep the project's parts apart."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
HEAVY = {"torch", "trimesh", "pyvista", "meshio", "matplotlib", "overlap", "numba", "scipy", "rich", "numpy"}
SLOW_TO_LOAD = HEAVY - {"scipy", "rich", "numpy"}
MODULES = sorted([*ROOT.glob("packgen/**/*.py"), *ROOT.glob("exporters/**/*.py")])
LINES_MAX = 400
ARGUMENTS_MAX = 10
CROWDED = {
    "packgen/arrange/adam/zone.py": {"pack_zone_adam"},
    "packgen/arrange/collective/layers.py": {"fill_in_layers"},
}
"""Functions that still take more arguments than they should, by module."""


def imports(path: Path, *, top_only: bool) -> Iterator[str]:
    """Dotted names that a module imports; ``from a import b`` gives a.b too."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    nodes = list(_top_level(tree)) if top_only else list(ast.walk(tree))
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (each.name for each in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield from (f"{node.module}.{each.name}" for each in node.names)


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
def test_exporters_know_bed_arrays_and_errors_and_nothing_else_of_packgen(path):
    of_packgen = {name for name in imports(path, top_only=False) if in_package(name, "packgen")}
    allowed = ("packgen.arrays", "packgen.bed", "packgen.errors")
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
    nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    functions = [node for node in nodes if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    crowded = {each.name for each in functions if arguments(each) > ARGUMENTS_MAX}
    assert crowded <= CROWDED.get(named(path), set())


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


def test_a_scene_error_loads_no_slow_library(tmp_path):
    scene = tmp_path / "wrong.yaml"
    scene.write_text("container: 3\n")
    loaded = loaded_by(str(scene))
    assert "pydantic" in loaded  # it came as far as the scene
    assert loaded & SLOW_TO_LOAD == set()


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
