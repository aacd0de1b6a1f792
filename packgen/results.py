"""The folder of a run's results: written under a temporary name beside the final one, renamed at the end."""

from __future__ import annotations

import errno
import json
import os
import shutil
import tempfile
from pathlib import Path
from types import TracebackType

from packgen.errors import ExportError

MANIFEST = "report.json"  # its key "files" lists what the run wrote
PAGE = "report.html"
DISK_FULL = (errno.ENOSPC, errno.EDQUOT)


class ResultFolder:
    """A folder that appears whole or not at all.

    As a context manager it makes a temporary sibling of the target, ``path``, for the run to write into.
    `commit` gives it the target's name; leaving the context without a commit deletes it. A folder that an
    earlier run wrote is replaced as a whole. One with foreign files is refused; with ``force`` it is set
    aside as ``NAME.old``, so that no result of a solver is ever lost or mixed with a new bed.

    Args:
        target: The final name.
        force: Whether a folder with foreign files is set aside, not refused.
        keep: Files that the run reads, which must not be inside the target.
    """

    def __init__(self, target: Path, *, force: bool = False, keep: tuple[Path, ...] = ()) -> None:
        self.target = target.expanduser().resolve()
        self.set_aside: Path | None = None
        self._force = force
        self._keep = keep
        self._parents_made: list[Path] = []
        self.path = self.target  # until the temporary folder is made

    def check(self) -> None:
        """Refuse a target that must not be replaced.

        Raises:
            ExportError: It is a file, the current folder, holds an input, or has files that no run wrote.
        """
        if self.target.exists() and not self.target.is_dir():
            raise ExportError(f"{self.target}: is a file, expected a folder; choose another with -o")
        if not self.target.exists():
            return
        if Path.cwd().is_relative_to(self.target):
            raise ExportError(f"{self.target}: is the folder you are in; name a folder inside it with -o")
        for path in self._keep:
            if path.resolve().is_relative_to(self.target):
                raise ExportError(
                    f"{self.target}: holds {path.name}, an input; choose another folder with -o"
                )
        foreign = foreign_files(self.target)
        if foreign and not self._force:
            named = ", ".join(foreign[:3]) + (f" and {len(foreign) - 3} more" if len(foreign) > 3 else "")
            raise ExportError(
                f"{self.target}: has files that packgen did not write ({named}); choose another folder "
                "with -o, or give --force to set this one aside"
            )

    def __enter__(self) -> ResultFolder:
        self.check()
        try:
            for parent in reversed([each for each in self.target.parents if not each.exists()]):
                parent.mkdir()
                self._parents_made.append(parent)
            name = tempfile.mkdtemp(prefix=f".{self.target.name}.unfinished-", dir=self.target.parent)
        except OSError as error:
            self._remove_parents()
            reason = error.strerror or str(error)
            raise ExportError(
                f"{self.target}: cannot be written: {reason}; choose another with -o"
            ) from error
        self.path = Path(name)
        self.path.chmod(0o777 & ~_umask())  # mkdtemp makes it private
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.path != self.target:
            shutil.rmtree(self.path, ignore_errors=True)
            self._remove_parents()

    def commit(self) -> None:
        """Give the results their final name, in place of an earlier run's.

        A folder into which foreign files have come since the start is set aside too: nothing is lost.

        Raises:
            OSError: The folder cannot be renamed; the former one is back in its place.
        """
        discarded: Path | None = None
        aside: Path | None = None
        if self.target.exists():
            if foreign_files(self.target):
                aside = self._free_name()
            else:
                discarded = self.path.with_name(self.path.name + "~")
        former = aside or discarded
        try:
            if former is not None:
                self.target.rename(former)
            self.path.rename(self.target)
        except BaseException:
            if former is not None and not self.target.exists():
                former.rename(self.target)
            raise
        self.path, self.set_aside = self.target, aside
        if discarded is not None:
            shutil.rmtree(discarded, ignore_errors=True)

    def _free_name(self) -> Path:
        number = 1
        while True:
            suffix = ".old" if number == 1 else f".old{number}"
            name = self.target.with_name(self.target.name + suffix)
            if not name.exists():
                return name
            number += 1

    def _remove_parents(self) -> None:
        for parent in reversed(self._parents_made):
            try:
                parent.rmdir()
            except OSError:  # something else is in it by now
                return


def foreign_files(folder: Path) -> list[str]:
    """Return what is in a folder that no run of packgen wrote, as relative names in order.

    Args:
        folder: An existing folder.

    Returns:
        Names of files that its ``report.json`` does not list; of all files where there is no such list.
    """
    try:
        written = set(json.loads((folder / MANIFEST).read_text(encoding="utf-8"))["files"])
    except (OSError, ValueError, KeyError, TypeError):
        written = set()
    return [name for name in list_files(folder) if name not in written]


def list_files(folder: Path) -> list[str]:
    """Return the files below a folder as relative names with forward slashes, in order; empty folders too."""
    names = []
    for place, folders, files in os.walk(folder):
        here = Path(place).relative_to(folder)
        names += [(here / name).as_posix() for name in files]
        names += [
            (here / name).as_posix() + "/" for name in folders if not any((folder / here / name).iterdir())
        ]
    return sorted(names)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
