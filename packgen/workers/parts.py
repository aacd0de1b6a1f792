"""The folder of an unfinished run by several processes: what its units have left, and what the run was to be.

It stands beside the results under a name of its own, ``NAME.parts``, and goes when they are complete. A run
that was interrupted goes on from it.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import socket
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from packgen.bedfile import plain
from packgen.errors import ExportError
from packgen.leftovers import is_gone, owner
from packgen.version import __version__

if TYPE_CHECKING:
    from packgen.scene import Scene

SUFFIX = ".parts"
MANIFEST = "manifest.json"
LOCK = "in_use"
FORMAT = 2  # of the files; another one cannot be gone on from


@dataclass(frozen=True, slots=True)
class Parts:
    """The folder of a run's parts.

    Attributes:
        folder: The folder.
    """

    folder: Path

    @classmethod
    def beside(cls, target: Path) -> Parts:
        """Return the folder of the parts of a result folder."""
        target = target.expanduser().resolve()
        return cls(target.with_name(target.name + SUFFIX))

    def open(self, scene: Scene, *, resume: bool) -> None:
        """Make the folder, or go on with the one that is there.

        Args:
            scene: The scene, as it is packed.
            resume: Whether there has to be one of the same scene.

        Raises:
            ExportError: There is a folder and ``resume`` is not said, or it is said and there is none, or the
                folder is of another scene, or another run uses it, or it cannot be written.
        """
        wanted = _described(scene)
        if resume:
            self._check(wanted)
            self._lock()
            return
        try:
            self.folder.mkdir(parents=True)
        except FileExistsError:
            self._refuse_in_use()
            raise ExportError(
                f"{self.folder}: holds the parts of a run that did not end; give --resume to go on with it, "
                "or remove the folder"
            ) from None
        except OSError as error:
            raise self._unwritable(error) from error
        try:
            (self.folder / MANIFEST).write_text(json.dumps(wanted, indent=2) + "\n", encoding="utf-8")
        except OSError as error:
            self.remove()
            raise self._unwritable(error) from error
        self._lock()

    def _lock(self) -> None:
        """Note that this run uses the folder.

        Raises:
            ExportError: Another one does.
        """
        self._refuse_in_use()
        lock = self.folder / LOCK
        try:
            lock.unlink(missing_ok=True)  # of a run that is gone
            with lock.open("x", encoding="utf-8") as file:
                file.write(f"{owner()} {os.getpid()} {socket.gethostname()}\n")
        except FileExistsError:
            self._refuse_in_use()
            raise self._in_use("another run") from None
        except OSError as error:
            raise self._unwritable(error) from error

    def _refuse_in_use(self) -> None:
        """Refuse a folder that another run uses, as far as that is known."""
        try:
            named, process, machine = (self.folder / LOCK).read_text(encoding="utf-8").split()
        except (OSError, ValueError):
            return
        if named != owner() and not is_gone(named):
            raise self._in_use(f"process {process} on {machine}")

    def _in_use(self, what: str) -> ExportError:
        return ExportError(
            f"{self.folder}: is in use by {what}; wait for it, choose another folder with -o, or remove "
            f"{self.folder / LOCK} if it has ended"
        )

    def unlock(self) -> None:
        """Note that this run does not use the folder any more."""
        lock = self.folder / LOCK
        with suppress(OSError):
            if lock.read_text(encoding="utf-8").startswith(f"{owner()} "):
                lock.unlink()

    def _unwritable(self, error: OSError) -> ExportError:
        reason = error.strerror or str(error)
        return ExportError(f"{self.folder}: cannot be written: {reason}; choose another with -o")

    def _check(self, wanted: Mapping[str, Any]) -> None:
        """Refuse a folder that is not of the scene."""
        remedy = f"remove {self.folder.name} and leave --resume out"
        try:
            found = json.loads((self.folder / MANIFEST).read_text(encoding="utf-8"))
        except FileNotFoundError:
            raise ExportError(
                f"{self.folder}: found no parts of an earlier run, expected some; leave --resume out"
            ) from None
        except (OSError, ValueError) as error:
            raise ExportError(f"{self.folder / MANIFEST}: cannot be read: {error}; {remedy}") from error
        different = [key for key in wanted if not isinstance(found, dict) or found.get(key) != wanted[key]]
        if different:
            raise ExportError(
                f"{self.folder}: has parts of another bed, which differ in {', '.join(different)}; {remedy}"
            )

    @property
    def begun(self) -> bool:
        """Whether there is anything to go on with."""
        return next(self.folder.glob("layer_*"), None) is not None

    def remove(self) -> None:
        """Remove the folder."""
        shutil.rmtree(self.folder, ignore_errors=True)


def _described(scene: Scene) -> dict[str, Any]:
    """Return all that decides where the spheres are; names, moduli, limits of solvers and such do not."""
    settings = plain(scene.model_dump())
    for name in ("validation", "wall_material"):
        settings.pop(name)
    settings["materials"] = {each["name"]: each["friction"] for each in settings["materials"]}
    for each in settings["particle_sets"]:
        each.pop("name", None)
    settings["params"].pop("verbosity", None)
    return {
        "format": FORMAT,
        "packgen": __version__,
        **settings,
        "files": {str(path): hashlib.sha256(path.read_bytes()).hexdigest() for path in _paths(settings)},
    }


def _paths(settings: Any) -> list[Path]:
    """Return the files that settings name, in their order."""
    if isinstance(settings, dict):
        own = settings.get("path")
        paths = [Path(own)] if isinstance(own, str) and Path(own).is_file() else []
        return paths + [path for value in settings.values() for path in _paths(value)]
    return [path for value in settings for path in _paths(value)] if isinstance(settings, list) else []
