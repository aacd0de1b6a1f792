"""The manifest of a bed in pieces: its files, the spheres that they have, and what is known of them."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from packgen.bedfile import plain
from packgen.census import Census
from packgen.errors import ReadError
from packgen.version import __version__

MANIFEST = "manifest.json"
FORMAT = "packgen bed in pieces"
VERSION = 1
START = 4096  # bytes of a file that tell what it is
REMEDY = "make the bed anew, or take the manifest as packgen wrote it"


@dataclass(frozen=True, slots=True)
class Piece:
    """A file of spheres.

    Attributes:
        file: Its name, relative to the manifest.
        offset: Number of its first sphere in the bed.
        count: Number of its spheres.
        low: Least coordinates of their centres [m].
        high: Largest coordinates of their centres [m].
    """

    file: str
    offset: int
    count: int
    low: tuple[float, float, float]
    high: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Manifest:
    """What a manifest says.

    Attributes:
        pieces: The files in the order of their spheres' numbers.
        census: Numbers, sizes and places of all spheres in short.
        provenance: Version, scene, seed and settings, as in ``bed.npz``.
    """

    pieces: tuple[Piece, ...]
    census: Census
    provenance: Mapping[str, Any]

    def write(self, path: Path) -> None:
        """Write the file; equal beds give equal files, byte for byte."""
        head = {
            "format": FORMAT,
            "version": VERSION,
            "packgen": __version__,
            "sphere_count": self.census.count,
            "census": self.census.as_json(),
            "provenance": plain(self.provenance),
        }
        text = json.dumps(head, indent=1)[:-2]
        with path.open("w", encoding="utf-8") as file:
            file.write(text + ',\n "pieces": [\n')
            for place, each in enumerate(self.pieces):
                row = {name: plain(getattr(each, name)) for name in Piece.__slots__}
                file.write(("" if place == 0 else ",\n") + "  " + json.dumps(row))
            file.write("\n ]\n}\n")
            file.flush()
            os.fsync(file.fileno())


def is_manifest(path: Path) -> bool:
    """Return whether a file is the manifest of a bed in pieces; False where it cannot be read."""
    if path.suffix.lower() != ".json":
        return False
    try:
        with path.open("rb") as file:
            return FORMAT.encode() in file.read(START)
    except OSError:
        return False


def read_manifest(path: Path) -> Manifest:
    """Read a manifest.

    Raises:
        ReadError: It cannot be read, is of another version, or does not say what it should.
    """
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ReadError(f"{path}: cannot be read: {error.strerror or error}; expected a manifest") from error
    except ValueError as error:
        raise ReadError(f"{path}: found no JSON ({error}), expected a manifest; {REMEDY}") from error
    if found.get("version") != VERSION:
        raise ReadError(
            f"{path}: found version {found.get('version')} of a bed in pieces, expected {VERSION}; "
            f"read it with packgen {found.get('packgen')}"
        )
    try:
        pieces = tuple(_piece(each) for each in found["pieces"])
        manifest = Manifest(pieces, Census.from_json(found["census"]), dict(found["provenance"]))
    except (KeyError, TypeError, ValueError) as error:
        raise ReadError(
            f"{path}: found a damaged manifest ({error!r}), expected a whole one; {REMEDY}"
        ) from error
    _check(path, manifest)
    return manifest


def _piece(found: Mapping[str, Any]) -> Piece:
    return Piece(
        str(found["file"]),
        int(found["offset"]),
        int(found["count"]),
        _point(found["low"]),
        _point(found["high"]),
    )


def _point(found: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = map(float, found)
    return x, y, z


def _check(path: Path, manifest: Manifest) -> None:
    """Refuse numbers that do not go on from piece to piece, and files elsewhere."""
    number = 0
    for each in manifest.pieces:
        if each.offset != number or each.count < 1:
            raise ReadError(
                f"{path}: {each.file}: found {each.count} spheres from number {each.offset} on, expected "
                f"some from {number} on; {REMEDY}"
            )
        if Path(each.file).is_absolute() or ".." in Path(each.file).parts:
            raise ReadError(f"{path}: found the file {each.file}, expected one below the manifest; {REMEDY}")
        number += each.count
    if number != manifest.census.count:
        raise ReadError(
            f"{path}: found pieces of {number:,} spheres, expected {manifest.census.count:,}; {REMEDY}"
        )
