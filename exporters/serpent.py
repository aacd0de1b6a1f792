"""Serpent: ``pebbles.txt`` for the card ``pbed``, and ``bed.serpent``, which has that card.

``pebbles.txt`` has ``x y z r universe`` a line, separated by tabs, in centimetres. The universe is that of
the particle set, ``u_`` and its name, with a number behind it where another universe has that name: what is
in a pebble is defined in the case's own input, as are the universe around the pebbles and the cell that is
filled with the bed. Of a bed that wraps around, spheres that cross a seam are there on both sides.

Reference: Serpent input manual, card "pbed".
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from exporters.shared import deck, table
from packgen.bed import Bed, with_owned_images

NAME = "serpent"
NEEDS: tuple[str, ...] = ()
CENTIMETRE = 0.01
WORD = r"^[A-Za-z][A-Za-z0-9_]*$"


class Options(BaseModel):
    """Options of the files.

    Attributes:
        universe: Name of the universe of the bed.
        background: Name of the universe around the pebbles.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    universe: str = Field(default="u_bed", pattern=WORD)
    background: str = Field(default="u_background", pattern=WORD)


def write(bed: Bed, folder: Path, options: Options) -> list[Path]:
    """Write the files into an existing folder and return their paths.

    Raises:
        ExportError: The bed is empty, or a number in it is not finite.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    position, radius, owner = with_owned_images(bed)
    names = universes([each.name for each in bed.particle_sets], (options.universe, options.background))
    columns = [*(position / CENTIMETRE).T, radius / CENTIMETRE, np.array(names)[bed.set_index[owner]]]
    return [
        table.write_rows(folder / "pebbles.txt", columns, separator="\t"),
        deck.write_text(folder / "bed.serpent", _card(bed, options, names)),
    ]


def universes(names: list[str], taken: tuple[str, ...] = ()) -> list[str]:
    """Return a universe for each name, all different and none of those taken."""
    return deck.different_words([f"u_{name}" for name in names], taken)


def _card(bed: Bed, options: Options, names: list[str]) -> str:
    told = deck.provenance_values(bed)
    low, high = (
        " ".join(f"{each:.9g}" for each in corner) for corner in (bed.container.bounds / CENTIMETRE).tolist()
    )
    needed = ", ".join([*(names[index] for index in np.unique(bed.set_index)), options.background])
    return (
        f"% {bed.count} spheres, packgen {told['version']}, scene {told['scene']}, seed {told['seed']}\n"
        f"% the container goes from {low} to {high} cm\n"
        f"% to be defined: {needed}, and a cell with fill {options.universe}\n"
        f'pbed {options.universe} {options.background} "pebbles.txt"\n'
    )
