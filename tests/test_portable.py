"""The portable functions against their definitions, and that nothing a bed depends on uses any others."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ndtr, ndtri

from packgen import portable

ROOT = Path(__file__).resolve().parent.parent
EXTENDED = np.longdouble  # 64 bits of mantissa where there are such numbers


def units_in_the_last_place(found: np.ndarray, wanted: np.ndarray) -> float:
    """Largest distance of float64 numbers from better ones, in units of their last place."""
    return float(np.max(np.abs(found.astype(EXTENDED) - wanted) / np.spacing(np.abs(wanted.astype(float)))))


@pytest.mark.parametrize(
    ("name", "low", "high", "units"),
    [
        ("exp", -700.0, 700.0, 2.0),
        ("exp", -1e-3, 1e-3, 2.0),
        ("log", 1e-300, 1e-3, 2.5),
        ("log", 0.5, 2.0, 2.5),
        ("expm1", -5.0, 5.0, 5.0),
        ("expm1", -745.0, -1.0, 5.0),
        ("expm1", -1e-9, 1e-9, 5.0),
        ("log1p", -0.9, 3.0, 5.0),
        ("log1p", -1e-9, 1e-9, 5.0),
    ],
)
def test_functions_are_right_to_a_few_units_in_the_last_place(name, low, high, units):
    value = np.random.default_rng(0).uniform(low, high, 20_000)
    value = np.concatenate([value, [low, high]])
    wanted = getattr(np, name)(value.astype(EXTENDED))
    assert units_in_the_last_place(getattr(portable, name)(value), wanted) <= units


@pytest.mark.parametrize(
    ("function", "value", "wanted"),
    [
        (portable.exp, 0.0, 1.0),
        (portable.exp, -1000.0, 0.0),
        (portable.exp, 1000.0, math.inf),
        (portable.log, 1.0, 0.0),
        (portable.log, 0.0, -math.inf),
        (portable.log, 5e-324, math.log(5e-324)),
        (portable.expm1, 0.0, 0.0),
        (portable.expm1, -1000.0, -1.0),
        (portable.expm1, 1000.0, math.inf),
        (portable.log1p, 0.0, 0.0),
        (portable.log1p, -1.0, -math.inf),
    ],
)
def test_functions_know_their_ends(function: Callable, value: float, wanted: float):
    assert float(function(np.array(value))) == wanted


@pytest.mark.parametrize("exponent", [1, 2, 3, 4, 7])
def test_whole_powers_are_correctly_rounded(exponent):
    base = np.exp(np.random.default_rng(1).uniform(-9.0, 3.0, 500))
    wanted = [float(Fraction(each) ** exponent) for each in base]
    assert portable.whole_power(base, exponent).tolist() == wanted
    assert portable.scalar_power(float(base[0]), exponent) == wanted[0]


def test_a_power_of_nothing_is_nothing():
    roots = portable.power(np.array([0.0, 1.0, 4.0]), 0.5).tolist()
    assert roots == pytest.approx([0.0, 1.0, 2.0], rel=1e-15)


@pytest.mark.parametrize("root", [1e-6, 0.03, 0.1, 1.0, 7.5, 1234.5])
def test_the_cube_root_of_a_cube_is_the_number(root):
    assert portable.cube_root(portable.scalar_power(root, 3)) == root


def test_the_normal_integral_and_its_inverse_are_those_of_scipy():
    score = np.linspace(-8.4, 8.4, 169)
    integral = np.array([portable.normal_integral(float(each)) for each in score])
    assert integral == pytest.approx(ndtr(score), rel=1e-12, abs=1e-16)
    tail = np.linspace(-37.0, -8.0, 59)
    assert [portable.normal_integral(each) for each in tail.tolist()] == pytest.approx(ndtr(tail), rel=2e-13)
    assert portable.normal_integral(-math.inf) == 0.0
    assert portable.normal_integral(math.inf) == 1.0
    share = np.concatenate([10.0 ** np.linspace(-300.0, -1.0, 500), np.linspace(0.001, 0.999, 999)])
    assert portable.normal_quantile(share) == pytest.approx(ndtri(share), rel=2e-15, abs=1e-15)
    assert portable.normal_quantile(np.array([0.0, 0.5, 1.0])).tolist() == [-math.inf, 0.0, math.inf]


@pytest.mark.parametrize(
    ("ratio", "wanted"), [(1.0, 0), (1.999, 0), (2.0, 1), (3.9999, 1), (4.0, 2), (2.0 - 1e-12, 1)]
)
def test_octaves_count_halvings(ratio, wanted):
    assert int(portable.octaves(np.array(ratio))) == wanted


@pytest.mark.parametrize("axis", [[0, 0, 0], [0, 0, 1], [0, -2, 0], [1, 0, 3]])
def test_components_along_an_axis_with_zeros_are_exact(axis):
    vectors = np.random.default_rng(2).normal(size=(50, 3))
    wanted = [float(sum(Fraction(a) * b for a, b in zip(row, axis, strict=True))) for row in vectors]
    assert portable.components(vectors, np.array(axis, float)) == pytest.approx(wanted, rel=1e-15, abs=0.0)


def test_components_are_those_of_the_matrix_product():
    rng = np.random.default_rng(2)
    vectors, axes = rng.normal(size=(50, 3)), rng.normal(size=(2, 3))
    assert portable.components(vectors, axes) == pytest.approx(vectors @ axes.T, rel=1e-14, abs=1e-14)
    assert portable.components(vectors, axes[0]) == pytest.approx(vectors @ axes[0], rel=1e-14, abs=1e-14)
    assert portable.length(axes[0]) == pytest.approx(float(np.linalg.norm(axes[0])), rel=1e-15)


# Functions whose last bit depends on the machine. A power with exponent 2 is a product.
UNPORTABLE = {
    "arccos", "arcsin", "arctan", "arctan2", "acos", "asin", "atan", "cbrt", "cos", "cosh", "dot", "einsum",
    "exp", "exp2", "expm1", "float_power", "hypot", "inner", "log", "log10", "log1p", "log2", "matmul", "pow",
    "power", "sin", "sinh", "tan", "tanh", "tensordot", "vdot",
}  # fmt: skip
LIBRARIES = {"np", "numpy", "math", "torch"}
TORCH_FORMS = ("arrange/adam/", "torch_")
"""What torch computes, whose sums differ by instruction set: the paper's algorithm, and the oracle."""

PLACES = ("arrange", "distributions", "geometry", "supply")
"""Packages whose digits a bed depends on."""


def of_a_bed() -> list[Path]:
    """Modules whose digits a bed depends on."""
    found = [path for place in PLACES for path in ROOT.glob(f"packgen/{place}/**/*.py")]
    found += [ROOT / "packgen" / each for each in ("portable.py", "container/convex.py")]
    return sorted(path for path in found if not any(each in path.as_posix() for each in TORCH_FORMS))


def unportable(path: Path) -> Iterator[str]:
    """Name the uses of what differs between machines, with their lines."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        name = ""
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            name = node.attr if node.value.id in LIBRARIES and node.attr in UNPORTABLE else ""
        elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
            name = "@"
        elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
            both = isinstance(node.left, ast.Constant), isinstance(node.right, ast.Constant)
            square = both[1] and node.right.value == 2  # type: ignore[attr-defined]
            name = "" if square or all(both) else "**"
        elif isinstance(node, ast.Call) and ast.unparse(node.func) == "np.linalg.norm":
            name = "" if any(each.arg == "axis" for each in node.keywords) else "np.linalg.norm"
        if name:
            yield f"{path.relative_to(ROOT)}:{node.lineno}: {name}"


ALLOWED = {
    # Starting points of searches in exact numbers, and bounds.
    "packgen/portable.py": {"cbrt", "**"},
    # Signs of whole turns, far from their rounding.
    "packgen/arrange/space/side_kernels.py": {"atan2"},
    # How far a run has come, for its progress.
    "packgen/arrange/jammed/jam.py": {"log"},
    # Angles of a cell for its report.
    "packgen/arrange/shrinking_cell/arrange.py": {"acos"},
    # How many spheres there may be, for a refusal.
    "packgen/arrange/void_filling/arrange.py": {"**"},
    # A whole power of two is exact.
    "packgen/arrange/collective/starts.py": {"**"},
}


@pytest.mark.parametrize("path", of_a_bed(), ids=lambda path: path.relative_to(ROOT).as_posix())
def test_a_bed_depends_on_no_function_whose_last_bit_differs_between_machines(path):
    allowed = ALLOWED.get(path.relative_to(ROOT).as_posix(), set())
    assert [each for each in unportable(path) if each.rsplit(" ", 1)[1] not in allowed] == []


def test_matrices_of_three_rows_are_multiplied_and_inverted_as_numpy_does_but_for_rounding():
    rng = np.random.default_rng(4)
    left, right = rng.normal(size=(7, 3)), rng.normal(size=(3, 3))
    assert np.abs(portable.matrix_product(left, right) - left @ right).max() < 1e-14
    assert np.abs(portable.matrix_product(left, right[0]) - left @ right[0]).max() < 1e-14
    assert np.abs(portable.matrix_product(left[0], right) - left[0] @ right).max() < 1e-14
    assert np.abs(portable.inverse(right) @ right - np.eye(3)).max() < 1e-13
