"""Laws of given sizes: a few classes, or a file of spheres."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from typing_extensions import override

from packgen.arrays import Float64Array
from packgen.distributions.base import Fault, ParameterError, StepLaw
from packgen.filefaults import FAULTS_MAX
from packgen.portable import cube

__all__ = ["Discrete", "Listed"]

SUM_SLACK = 2.0e-3  # lets thirds be written as 0.333
FILE_LIMIT = 500_000_000  # bytes


class Discrete(StepLaw):
    """A few sizes, and the fraction of the spheres or of the mass that has each."""

    def __init__(
        self, radii: Sequence[float], fractions: Sequence[float], by: Literal["number", "mass"] = "number"
    ) -> None:
        """Check the classes.

        Args:
            radii: Sizes [m], each once.
            fractions: Fraction of each, adding up to 1.
            by: What the fractions are fractions of.

        Raises:
            ParameterError: The lists differ in length, a size comes twice, or the fractions do not add up.
        """
        radius, fraction = np.array(radii, dtype=np.float64), np.array(fractions, dtype=np.float64)
        if len(radius) != len(fraction):
            expected = f"{len(radius)} fractions, one a radius"
            raise ParameterError((("fractions",), f"{len(fraction)} fractions", expected))
        total = math.fsum(fraction)
        if abs(total - 1.0) > SUM_SLACK:
            raise ParameterError(
                (("fractions",), list(fractions), f"fractions that add up to 1, not to {total:g}")
            )
        order = np.argsort(radius)
        radius = radius[order]
        if (np.diff(radius) == 0.0).any():
            twice = float(radius[np.flatnonzero(np.diff(radius) == 0.0)[0]])
            raise ParameterError((("radii",), twice, "each radius once"))
        # Ratios, not cubes of lengths: a cubed radius may leave float64's range.
        number = fraction[order] / cube(radius / radius[0]) if by == "mass" else fraction[order]
        self.radius = radius
        self.number = number / number.sum()


class Listed(StepLaw):
    """Exactly the spheres of a list: a draw of as many as it holds gives each of them once.

    Attributes:
        count: Number of spheres in the list.
    """

    def __init__(self, radii: Float64Array) -> None:
        """Take the spheres' radii [m], shape (M,), float64.

        Raises:
            ParameterError: The list is empty, or a radius is not finite and greater than 0.
        """
        radius = np.sort(np.asarray(radii, dtype=np.float64))
        if not len(radius) or not (np.isfinite(radius).all() and radius[0] > 0.0):
            raise ParameterError((("path",), "a list without radii", "finite radii greater than 0"))
        self.radius = radius
        self.number = np.full(len(radius), 1.0 / len(radius))
        self.count = len(radius)

    @classmethod
    def from_file(cls, path: Path) -> Listed:
        """Read the radii [m] of a file: one a line, or the column ``radius`` of a csv; # starts a comment.

        Raises:
            ParameterError: The file cannot be read, or lines hold no radius; the first 20 are named.
        """
        try:
            size = path.stat().st_size
            if size > FILE_LIMIT:
                raise ParameterError((("path",), f"{path} with {size} bytes", f"at most {FILE_LIMIT} bytes"))
            lines = path.read_text(encoding="utf-8-sig").splitlines()
        except UnicodeDecodeError as error:
            raise ParameterError((("path",), f"{path}, which is no text", "one radius a line")) from error
        except OSError as error:
            raise ParameterError(
                (("path",), str(path), f"a file that can be read ({error.strerror})")
            ) from error
        return cls(_parse(lines, path))

    @override
    def sample(self, rng: np.random.Generator, count: int) -> Float64Array:
        """Draw spheres in random order; each of the list comes once before any comes again."""
        whole, rest = divmod(count, self.count)
        part = rng.choice(self.radius, rest, replace=False) if rest else self.radius[:0]
        return rng.permutation(np.concatenate([np.tile(self.radius, whole), part]))


def _parse(lines: list[str], path: Path) -> Float64Array:
    """Return the radii [m] of a file's lines."""
    rows = [(index, line.split("#", 1)[0].strip()) for index, line in enumerate(lines, start=1)]
    rows = [(index, row) for index, row in rows if row]
    if not rows:
        raise ParameterError((("path",), f"{path} without a radius", "one radius a line"))
    separator = next((each for each in (";", ",", "\t") if each in rows[0][1]), None)
    header = (
        [each.strip().strip("\"'").lower() for each in rows[0][1].split(separator)]
        if separator
        else [rows[0][1]]
    )
    column = 0
    if "radius" in (name.strip("\"'").lower() for name in header):
        column = [name.strip("\"'").lower() for name in header].index("radius")
        rows = rows[1:]
    elif separator:
        found = f"{path}:{rows[0][0]} with the columns {', '.join(header)[:60]}"
        raise ParameterError((("path",), found, "a column called radius, or one radius a line"))
    cells = [row.split(separator) if separator else [row] for _, row in rows]
    texts = [each[column].strip() if column < len(each) else "" for each in cells]
    radii = np.array([_number(text) for text in texts])
    wrong = np.flatnonzero(~(np.isfinite(radii) & (radii > 0.0)))
    expected = "a finite radius greater than 0, in metres"
    faults: list[Fault] = [
        (("path",), f"{texts[k][:40]!r} in {path}:{rows[k][0]}", expected) for k in wrong[:FAULTS_MAX]
    ]
    if len(wrong) > FAULTS_MAX:
        faults.append((("path",), f"{len(wrong) - FAULTS_MAX:,} such lines more in {path}", expected))
    if faults:
        raise ParameterError(*faults)
    return radii


def _number(text: str) -> float:
    """Return the number that a text is, nan where it is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan
