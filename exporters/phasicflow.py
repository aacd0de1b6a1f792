"""phasicFlow: ``positions``, ``settings/particlesDict`` that reads it, and ``caseSetup/shapes``.

phasicFlow knows the size of a sphere by the name of its shape, so each radius of a material is a shape, and
beds of very many radii are refused; ``positions`` has the spheres shape by shape, ``x y z`` a line, and
``particlesDict`` names the shape of each range of them. The materials' properties are in the case's own
``caseSetup/interaction``, by the names in ``shapes``.

Reference: phasicFlow source, ``utilities/particlesPhasicFlow``, its README and ``positionFile.cpp``; the
tutorials' ``caseSetup/shapes``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from exporters.shared import deck, table
from packgen.bed import Bed
from packgen.errors import ExportError

NAME = "phasicflow"
NEEDS = ("materials",)
SHAPES_MAX = 1000


class Options(BaseModel):
    """Options of the files.

    Attributes:
        shapes_max: Most shapes, one for each radius of each material.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    shapes_max: int = Field(default=SHAPES_MAX, gt=0)


def write(bed: Bed, folder: Path, options: Options) -> list[Path]:
    """Write the files into an existing folder and return their paths.

    Raises:
        ExportError: The bed is empty, a number in it is not finite, or it has too many radii.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    kinds, kind = np.unique(np.stack([bed.type_index, bed.radius]), axis=1, return_inverse=True)
    if kinds.shape[1] > options.shapes_max:
        raise ExportError(
            f"{NAME}: {kinds.shape[1]:,} different radii, expected at most {options.shapes_max:,}: each is a "
            f"shape of its own; choose a law of few radii, such as discrete, or enlarge {NAME}.shapes_max"
        )
    order = np.argsort(kind.ravel(), kind="stable")
    names = [f"sphere{place}" for place in range(kinds.shape[1])]
    ends = np.cumsum(np.bincount(kind.ravel()))
    for sub in ("settings", "caseSetup"):
        (folder / sub).mkdir(exist_ok=True)
    return [
        table.write_rows(folder / "positions", list(bed.position[order].T)),
        deck.write_text(folder / "settings" / "particlesDict", _particles(names, ends)),
        deck.write_text(folder / "caseSetup" / "shapes", _shapes(bed, names, kinds)),
    ]


def _head(name: str) -> str:
    return f"objectName {name};\nobjectType dictionary;\nfileFormat ASCII;\n\n"


def _particles(names: list[str], ends: NDArray[np.int64]) -> str:
    """Return the dictionary that reads the positions and tells which of them have which shape."""
    selectors = "".join(
        f"        {name}\n        {{\n            selector stridedRange;\n"
        f"            stridedRangeInfo {{begin {begin}; end {end}; stride 1;}}\n"
        f"            fieldValue {{shapeName word {name};}}\n        }}\n"
        for name, begin, end in zip(names, [0, *ends.tolist()], ends.tolist(), strict=False)
    )
    # Ranges count the spheres in the order of the file: they must not be sorted.
    return (
        _head("particlesDict")
        + "positionParticles\n{\n    method file;\n    mortonSorting No;\n    fileInfo\n    {\n"
        "        name positions;\n        commaSeparated No;\n    }\n}\n\n"
        "setFields\n{\n    defaultValue\n    {\n        velocity realx3 (0 0 0);\n"
        "        acceleration realx3 (0 0 0);\n        rVelocity realx3 (0 0 0);\n"
        f"        shapeName word {names[0]};\n    }}\n    selectors\n    {{\n{selectors}    }}\n}}\n"
    )


def _shapes(bed: Bed, names: list[str], kinds: NDArray[np.float64]) -> str:
    materials = [_word(bed.materials[int(index)].name) for index in kinds[0]]
    rows = (
        ("names", names),
        ("diameters", [repr(2 * each) for each in kinds[1].tolist()]),
        ("materials", materials),
    )
    return _head("shapes") + "".join(f"{key} ({' '.join(values)});\n" for key, values in rows)


def _word(name: str) -> str:
    """Return a name as one word of a dictionary."""
    return "".join(each if each.isascii() and (each.isalnum() or each in "_.-") else "_" for each in name)
