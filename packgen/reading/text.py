"""Files of text, as bytes of which parts become rows: a dump of many steps is never decoded as a whole."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from packgen.filefaults import fault
from packgen.reading.rows import Rows

HEAD = 65_536  # bytes in which a file that is no text shows


@dataclass(frozen=True, slots=True)
class Text:
    """A file of text: its path and its bytes."""

    path: Path
    data: bytes

    def line_at(self, offset: int) -> int:
        """Return the number of the line, from 1, in which a byte lies."""
        return self.data.count(b"\n", 0, offset) + 1

    def rows(self, start: int, stop: int | None = None, separator: str | None = None) -> Rows:
        """Return a part of the file, from one byte to another, as rows."""
        part = self.data[start:stop]
        return Rows(self.path, decoded(part), self.line_at(start), separator)

    def head(self, count: int) -> list[str]:
        """Return the first lines, at most ``count``."""
        lines: list[str] = []
        start = 0
        while len(lines) < count and start < len(self.data):
            end = self.data.find(b"\n", start)
            end = len(self.data) if end < 0 else end
            lines.append(decoded(self.data[start:end]).rstrip("\r"))
            start = end + 1
        return lines


def decoded(data: bytes) -> str:
    """Return bytes as text; those that are none become marks that no number has."""
    return data.decode("utf-8", "replace").removeprefix("\ufeff")


def read_text(path: Path) -> Text:
    """Read a file of text.

    Raises:
        ReadError: It is empty, or no text.
        OSError: It cannot be read.
    """
    data = path.read_bytes()
    if not data.strip():
        raise fault(path, "an empty file", "a row a sphere", remedy="is it complete?")
    if b"\0" in data[:HEAD]:
        raise fault(
            path, "bytes that are no text", "text, or a file whose ending is npz, vtp, vtu or vtk",
            remedy="name it after what it is, or save it as text",
        )  # fmt: skip
    return Text(path, data)
