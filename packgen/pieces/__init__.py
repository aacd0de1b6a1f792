"""A bed in pieces: its spheres in files, each of a part of the space, and a manifest that says what they are.

No step holds the whole bed. The number of a sphere is that of the first one of its piece, which the manifest
has, and its place in the piece.
"""

from packgen.pieces.bed import GATHERED_MAX, PieceBed, read_gathered
from packgen.pieces.manifest import MANIFEST, Manifest, Piece, is_manifest, read_manifest
from packgen.pieces.write import PieceWriter, in_pieces

__all__ = [
    "GATHERED_MAX", "MANIFEST", "Manifest", "Piece", "PieceBed", "PieceWriter", "in_pieces", "is_manifest",
    "read_gathered", "read_manifest",
]  # fmt: skip
