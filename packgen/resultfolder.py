"""The folder of a run's results: written under a temporary name beside the final one, renamed at the end."""

from __future__ import annotations

import errno
import json
import os
import re
import shutil
import tempfile
from contextlib import ExitStack, suppress
from pathlib import Path
from types import TracebackType

from packgen.errors import ExportError
from packgen.leftovers import abandoned, owner, remove_scratch
from packgen.stopping import held, tidied

MANIFEST = "report.json"  # its key "files" lists what the run wrote
PAGE = "report.html"
UNVALIDATED, UNSETTLED = ".unvalidated", ".unsettled"  # names of what a stop has left unfinished
UNFINISHED = ".unfinished-"
DISK_FULL = (errno.ENOSPC, errno.EDQUOT)


class ResultFolder:
    """A folder that appears whole or not at all.

    As a context manager it makes a temporary sibling of the target, ``path``, for the run to write into.
    `commit` gives it the target's name; leaving the context without a commit deletes it. A folder that an
    earlier run wrote is replaced as a whole. One with foreign files is refused; with ``force`` it is set
    aside as ``NAME.old``, so that no result of a solver is ever lost or mixed with a new bed. Leftovers of
    killed runs of this target are tidied up first. A result that one of them was about to replace gets its
    name back; unfinished ones are removed.

    Args:
        target: The final name.
        force: Whether a folder with foreign files is set aside, not refused.
        keep: Files that the run reads, which must not be inside the target.
    """

    def __init__(self, target: Path, *, force: bool = False, keep: tuple[Path, ...] = ()) -> None:
        self.target = target.expanduser().resolve()
        self.set_aside: Path | None = None
        self.notes: list[str] = []  # what became of folders that were there before, for the user
        self.beside = ""  # what follows the target's name, where the results are put beside it
        self._registered = ExitStack()
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
        self.notes += _recover(self.target)
        with suppress(OSError):  # no place for temporary folders: whoever needs one reports it
            remove_scratch(Path(tempfile.gettempdir()))
        self.check()
        with held():
            self._make()
            self._registered.enter_context(tidied(self._discard))
        return self

    def _make(self) -> None:
        try:
            for parent in reversed([each for each in self.target.parents if not each.exists()]):
                parent.mkdir()
                self._parents_made.append(parent)
            name = tempfile.mkdtemp(
                prefix=f".{self.target.name}{UNFINISHED}{owner()}-", dir=self.target.parent
            )
        except OSError as error:
            self._remove_parents()
            reason = error.strerror or str(error)
            raise ExportError(
                f"{self.target}: cannot be written: {reason}; choose another with -o"
            ) from error
        self.path = Path(name)
        self.path.chmod(0o777 & ~_umask())  # mkdtemp makes it private

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with held():
            self._registered.close()
            self._discard()

    def _discard(self) -> None:
        """Remove what is not committed."""
        if self.path != self.target:
            for _ in range(3):  # where a process is ended its main thread may still be writing
                if self.path.exists():
                    shutil.rmtree(self.path, ignore_errors=True)
            self._remove_parents()

    def keep_beside(self, suffix: str) -> None:
        """Commit to a name beside the target, which stays; so do foreign files there.

        Args:
            suffix: What follows the target's name: `UNVALIDATED` or `UNSETTLED`.
        """
        number = 1
        while True:
            free = _numbered(self.target, suffix, number)
            if not os.path.lexists(free) or (
                free.is_dir() and not free.is_symlink() and not foreign_files(free)
            ):
                break
            number += 1
        self.beside, self.target = suffix, free

    def commit(self) -> None:
        """Give the results their final name, in place of an earlier run's.

        A folder into which foreign files have come since the start is set aside too: nothing is lost.

        Raises:
            OSError: The folder cannot be renamed; the former one is back in its place.
        """
        with held():
            self._name_after_target()
            discarded: Path | None = None
            aside: Path | None = None
            if self.target.exists():
                if foreign_files(self.target):
                    aside = _free_name(self.target)
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
            if aside is not None:
                self.notes.append(f"the former folder, which had other files, is now {aside}")
            if discarded is not None:
                _remove_former(discarded)

    def _name_after_target(self) -> None:
        """Name the unfinished folder after a target that has changed, as `_recover` reads it."""
        ending = self.path.name.rpartition(UNFINISHED)[2]
        named = self.path.with_name(f".{self.target.name}{UNFINISHED}{ending}")
        if named != self.path:
            self.path.rename(named)
            self.path = named

    def _remove_parents(self) -> None:
        for parent in reversed(self._parents_made):
            try:
                parent.rmdir()
            except OSError:  # something else is in it by now
                return


def _recover(target: Path) -> list[str]:
    """Tidy up what killed runs of a target have left; return a line for each result that was moved.

    A run that was killed between the two renames of its end has left the former result under its temporary
    name and ``~``: that result is whole and gets its name back. With ``~~`` it has been replaced.
    """
    suffixes = f"({re.escape(UNVALIDATED)}|{re.escape(UNSETTLED)})"
    beside = rf"\.{re.escape(target.name)}({suffixes}\d*)?{re.escape(UNFINISHED)}"
    notes = []
    # The former result comes before the new one, whose presence tells that the former was not replaced.
    for path in reversed(abandoned(target.parent, beside)):
        final = path.with_name(path.name[1:].rpartition(UNFINISHED)[0])
        if not path.name.endswith("~") or path.name.endswith("~~"):
            shutil.rmtree(path, ignore_errors=True)
        elif os.path.lexists(final) and not path.with_name(path.name[:-1]).exists():
            _remove_former(path)
        else:
            place = _free_name(final) if os.path.lexists(final) else final
            with suppress(OSError):  # another run was faster
                path.rename(place)
                notes.append(f"a run was killed as it replaced {final}; the former result is now {place}")
    return notes


def _remove_former(path: Path) -> None:
    """Remove a former result that has been replaced; its name says so before the first file goes."""
    replaced = path.with_name(path.name + "~")
    with suppress(OSError):
        path.rename(replaced)
        shutil.rmtree(replaced, ignore_errors=True)


def _free_name(target: Path) -> Path:
    number = 1
    while os.path.lexists(name := _numbered(target, ".old", number)):
        number += 1
    return name


def _numbered(target: Path, suffix: str, number: int) -> Path:
    return target.with_name(target.name + suffix + ("" if number == 1 else str(number)))


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
