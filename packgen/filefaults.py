"""Faults of a file that holds spheres: one line each, at most twenty of them and how many more there are."""

from __future__ import annotations

from pathlib import Path

from packgen.errors import ReadError

FAULTS_MAX = 20
TEXT_MAX = 40  # characters of a value that are shown


class Faults:
    """Collects the faults of a file; the first ones are kept, all are counted.

    Args:
        path: The file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lines: list[str] = []
        self._count = 0

    def add(self, found: str, expected: str, *, place: int | str | None = None, remedy: str = "") -> None:
        """Add a fault.

        Args:
            found: What is there.
            expected: What should be.
            place: Number of the line, or what else says where; None: the file as a whole.
            remedy: What to do about it.
        """
        self._count += 1
        if self._count <= FAULTS_MAX:
            where = "" if place is None else f":{place}"
            after = f"; {remedy}" if remedy else ""
            self._lines.append(f"{self._path}{where}: found {found}, expected {expected}{after}")

    @property
    def any(self) -> bool:
        """Whether there is one."""
        return self._count > 0

    def error(self) -> ReadError:
        """Return the faults as an error."""
        more = self._count - FAULTS_MAX
        rest = [f"{self._path}: found {more:,} faults more, expected none"] if more > 0 else []
        return ReadError("\n".join([*self._lines, *rest]))

    def check(self) -> None:
        """Raise the faults, if there are any.

        Raises:
            ReadError: There are.
        """
        if self.any:
            raise self.error()


def fault(
    path: Path, found: str, expected: str, *, place: int | str | None = None, remedy: str = ""
) -> ReadError:
    """Return the error for a single fault; see `Faults.add`."""
    faults = Faults(path)
    faults.add(found, expected, place=place, remedy=remedy)
    return faults.error()


def shown(text: str) -> str:
    """Return a value of a file in quotes, short, whatever characters it has."""
    kept = text if len(text) <= TEXT_MAX else text[:TEXT_MAX] + "..."
    return ascii(kept)
