"""Does a file's unit of length look right? A factor of a thousand is the most common mistake of all."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from packgen.filefaults import fault, shown
from packgen.geometry import Container
from packgen.reading.spheres import SphereFile
from packgen.units import LENGTHS

COUNT_MIN = 10  # fewer spheres may be anywhere
SOLID_MAX = 10.0  # of the box around the spheres; beyond it radii and positions differ in unit
SOLID_MIN = 2.0e-9
WIDER_MAX = 100.0  # extent of the spheres over that of the container
NARROWER_MAX = 300.0  # the other way round
DIGITS_MIN, DIGITS_MAX = 5, 9  # fewer are exact numbers of a person, more no rounding to speak of
RADIUS_MAX = 1.0  # m; larger spheres are worth a word where no container tells


def refuse_named_units(path: Path, named: Mapping[str, str], units: str | None, line: int) -> None:
    """Refuse a file that names another unit of length than the one that is read.

    Args:
        path: The file.
        named: What the file says, and the unit that this means, a key of `packgen.units.LENGTHS`.
        units: The unit that is read; None: metres.
        line: Number of the line that names them.

    Raises:
        ReadError: It does, or it names several.
    """
    wanted, there = units or "m", list(dict.fromkeys(named.values()))
    if len(there) > 1:
        raise fault(
            path, f"lengths in {' and '.join(there)}", "one unit", place=line,
            remedy="convert columns, and name their unit anew",
        )  # fmt: skip
    for said, unit in named.items():
        if unit != wanted:
            raise fault(
                path, f"lengths in {unit} ({shown(said)})", wanted, place=line, remedy=f"give --units {unit}"
            )


def refuse_other_units(spheres: SphereFile, container: Container | None) -> None:
    """Refuse spheres whose lengths are in another unit than metres, as far as that is sure.

    Args:
        spheres: The spheres, taken for metres.
        container: The vessel that they should be in; None: it is not known.

    Raises:
        ReadError: Positions and radii do not fit each other, or the spheres not the container.
    """
    low = (spheres.position - spheres.radius[:, None]).min(axis=0)
    high = (spheres.position + spheres.radius[:, None]).max(axis=0)
    span = float((high - low).max())
    if spheres.count >= COUNT_MIN:
        reach = float(np.ptp(spheres.position, axis=0).max())
        # Ratios first: cubes of lengths may leave float64's range.
        solid = float(4.0 / 3.0 * np.pi * np.sum((spheres.radius / span) ** 3) / np.prod((high - low) / span))
        if not SOLID_MIN < solid < SOLID_MAX:
            raise fault(
                spheres.path, f"radii up to {spheres.radius.max():g} m among centres over {reach:g} m",
                "radii and positions in one unit",
                remedy="convert one of them; or give --units, such as --units m, if that is right",
            )  # fmt: skip
    if container is not None:
        _refuse_beside(spheres, span, float(np.ptp(container.bounds, axis=0).max()))


def rounding_remark(spheres: SphereFile, tolerance: float | None) -> str | None:
    """Return a line on positions with so few digits that overlaps beyond the tolerance may be rounding."""
    if spheres.digits is None or not DIGITS_MIN <= spheres.digits <= DIGITS_MAX:
        return None
    largest = float(np.abs(spheres.position).max(initial=1e-300))
    rounding = 0.5 * 10.0 ** (np.floor(np.log10(largest)) + 1 - spheres.digits)
    # Both spheres of a pair are off along each axis.
    share = float(2.0 * np.sqrt(3.0) * rounding / spheres.radius.min())
    if tolerance is None or share <= tolerance:
        return None
    return (
        f"{spheres.path}: positions have {spheres.digits} digits: overlaps up to {share:.2g} of the smallest "
        "radius may be rounding"
    )


def _refuse_beside(spheres: SphereFile, span: float, size: float) -> None:
    ratio = span / size
    found = f"spheres over {span:g} m, with a container of {size:g} m"
    if ratio > WIDER_MAX:
        fitting = [unit for unit in ("cm", "mm", "um") if ratio * LENGTHS[unit] <= 1.05]
        unit = fitting[0] if fitting else "mm"
        raise fault(
            spheres.path, found, "spheres that are inside",
            remedy=f"if the file is in {unit}, give --units {unit}",
        )  # fmt: skip
    if ratio < 1.0 / NARROWER_MAX and spheres.count >= COUNT_MIN:
        raise fault(
            spheres.path, found, "lengths of one unit",
            remedy="if the container's mesh is in mm, say so (--container-units mm); if not, give --units m",
        )  # fmt: skip


def size_remark(spheres: SphereFile) -> str | None:
    """Return a line on spheres that are large for spheres in metres; None where they are not."""
    largest = float(spheres.radius.max())
    if largest <= RADIUS_MAX:
        return None
    return f"{spheres.path}: radii up to {largest:g} m; if the file is in millimetres, give --units mm"
