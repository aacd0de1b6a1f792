"""The errors that packgen raises on purpose, each with the exit code that the command line gives it."""

from __future__ import annotations

from collections.abc import Sequence


class PackgenError(Exception):
    """An error with a message for the user: what was found, what was expected, what to do.

    Attributes:
        exit_code: What the command line returns: 2 the input is wrong and nothing was written,
            1 a bed was written but something asked for was not reached.
    """

    exit_code: int = 2


class SceneError(PackgenError, ValueError):
    """A scene file that is wrong; all its faults at once.

    Attributes:
        problems: One line a fault, ``file:line:column: path: found, expected``; what a terminal cannot show
            is escaped.
    """

    def __init__(self, problems: Sequence[str]) -> None:
        self.problems = tuple(printable(problem) for problem in problems)
        super().__init__("\n".join(self.problems))


class ReadError(PackgenError, ValueError):
    """A file of spheres that is not what it claims, or does not say what is needed; one line a fault."""


class GeometryError(PackgenError, ValueError):
    """A container or zone surface that cannot be read or cannot hold spheres."""


class PackingError(PackgenError):
    """A scene that cannot be packed: nothing fits, or the settings rule every sphere out."""


class ExportError(PackgenError, ValueError):
    """A bed that a format or a solver cannot take, or a folder that cannot be written."""


class SolverError(PackgenError):
    """A solver that is missing (exit code 2), or that crashed, hung or printed garbage (exit code 1)."""

    def __init__(self, message: str, *, exit_code: int = 1) -> None:
        super().__init__(message)
        self.exit_code = exit_code


def printable(text: str) -> str:
    """Return text as one line that a terminal can show."""
    return "".join(each if each.isprintable() else repr(each)[1:-1] for each in text)
