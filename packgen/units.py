"""Numbers with units, as a scene may write them, into SI: ``"12 mm"`` is 0.012.

A short table instead of a unit library: within packgen every number is SI already, and only a scene's
values and a mesh's coordinates ever carry another unit.

Example: ``to_si("12 mm", "length")`` gives 0.012.
"""

from __future__ import annotations

import re
from types import MappingProxyType

__all__ = ["LENGTHS", "UNITS", "to_si"]

LENGTHS = MappingProxyType({"m": 1.0, "cm": 1.0e-2, "mm": 1.0e-3, "um": 1.0e-6, "in": 0.0254, "ft": 0.3048})
"""Metres in each unit of length (inch and foot: international, exact)."""

UNITS = MappingProxyType(
    {
        "length": LENGTHS,
        "volume": MappingProxyType({"m3": 1.0, "l": 1.0e-3, "cm3": 1.0e-6, "mm3": 1.0e-9}),
        "mass": MappingProxyType({"kg": 1.0, "t": 1.0e3, "g": 1.0e-3, "mg": 1.0e-6}),
        "density": MappingProxyType({"kg/m3": 1.0, "g/cm3": 1.0e3, "t/m3": 1.0e3}),
        "pressure": MappingProxyType({"Pa": 1.0, "kPa": 1.0e3, "MPa": 1.0e6, "GPa": 1.0e9}),
        "time": MappingProxyType({"s": 1.0, "ms": 1.0e-3, "us": 1.0e-6, "min": 60.0, "h": 3600.0}),
        "velocity": MappingProxyType({"m/s": 1.0, "cm/s": 1.0e-2, "mm/s": 1.0e-3}),
        "frequency": MappingProxyType({"Hz": 1.0}),
        "acceleration": MappingProxyType({"m/s2": 1.0}),
        "number": MappingProxyType({}),
    }
)
"""Units of each quantity, and how many SI units one of them is; the SI unit comes first."""

_QUANTITY = re.compile(r"([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*([^\s0-9.+\-eE][^\s]*)?")
_SPELLINGS = MappingProxyType({"µm": "um", "μm": "um", "³": "3", "²": "2", "^": ""})


def to_si(text: str, quantity: str) -> float:
    """Return the SI value of a number with or without a unit.

    Args:
        text: Such as ``"12 mm"``, ``"12mm"`` or ``"0.012"``.
        quantity: A key of ``UNITS``.

    Returns:
        The value in SI units; infinite where the number is too large for float64.

    Raises:
        ValueError: No number, or a unit that the quantity has not; the message says what was expected.
    """
    units = UNITS[quantity]
    names = ", ".join(units)
    expected = f"a number, or a number with a unit ({names})" if units else "a number"
    match = _QUANTITY.fullmatch(text.strip())
    if match is None:
        raise ValueError(expected)
    value, unit = float(match[1]), match[2]
    if unit is None:
        return value
    for spelling, regular in _SPELLINGS.items():
        unit = unit.replace(spelling, regular)
    if unit not in units:
        raise ValueError(expected)
    # Division by a whole number rounds once where multiplication by 0.001 would round twice.
    factor = units[unit]
    inverse = 1.0 / factor
    return (
        value / round(inverse)
        if factor < 1.0 and abs(inverse - round(inverse)) < 1e-9 * inverse
        else value * factor
    )
