# ruff: noqa: E501 (tables of values, a row a kind)
"""Claims on numbers with units."""

from __future__ import annotations

import pytest

from packgen.units import UNITS, to_si


@pytest.mark.parametrize(
    ("text", "quantity", "value"),
    [
        ("12 mm", "length", 0.012), ("12mm", "length", 0.012), (" 1.5e2 cm ", "length", 1.5), ("0.3", "length", 0.3),
        ("1 in", "length", 0.0254), ("2 ft", "length", 0.6096), ("5 µm", "length", 5e-6), ("-3 um", "length", -3e-6),
        ("2 l", "volume", 2e-3), ("1 m^3", "volume", 1.0), ("3 t", "mass", 3000.0), ("2.5 g/cm3", "density", 2500.0),
        ("210 GPa", "pressure", 2.1e11), ("9.81 m/s²", "acceleration", 9.81),
    ],
)  # fmt: skip
def test_numbers_with_units_become_si(text: str, quantity: str, value: float) -> None:
    assert to_si(text, quantity) == value


@pytest.mark.parametrize(
    "text", ["", "mm", "12 parsec", "1 2 mm", "12 kg", "nan", "inf m", "1e", "0x10 m", "12 MM"]
)
def test_anything_else_says_which_units_there_are(text: str) -> None:
    with pytest.raises(ValueError, match=r"m, cm, mm, um, in, ft"):
        to_si(text, "length")


def test_the_si_unit_of_each_quantity_is_one() -> None:
    for quantity, units in UNITS.items():
        for unit in list(units)[:1]:
            assert to_si(f"1 {unit}", quantity) == 1.0
