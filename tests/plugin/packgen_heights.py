"""An exporter that packgen knows nothing of: ``heights.txt``, the height of each sphere's centre [m]."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from packgen.bed import Bed

NAME = "heights"


@dataclass(frozen=True)
class Options:
    """What a user may choose: the axis along which heights are counted, x, y or z."""

    axis: str = "z"


def write(bed: Bed, folder: Path, options: Options) -> list[Path]:
    """Write ``heights.txt`` into an existing folder and return its path."""
    path = folder / "heights.txt"
    heights = bed.position[:, "xyz".index(options.axis)]
    path.write_text("".join(f"{height!r}\n" for height in heights.tolist()), encoding="ascii")
    return [path]
