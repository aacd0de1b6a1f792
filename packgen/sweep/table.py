"""The table of a sweep: a line a run, with its values, how it ended, and the main figures of its bed."""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from packgen.bedfile import plain
from packgen.resultfolder import MANIFEST
from packgen.scene import Scene
from packgen.summary import FIGURES, main_figures
from packgen.sweep.over import Run

__all__ = ["Line", "columns", "is_done", "line_of_folder", "write_table"]

VALIDATION = "validation.json"


@dataclass(frozen=True, slots=True)
class Line:
    """How a run of a sweep ended.

    Attributes:
        run: The run.
        exit_code: Its exit code: 0 complete, 1 something was missed, else there is no bed.
        figures: The main figures of its bed; empty without one.
        message: What was missed, or why there is no bed.
    """

    run: Run
    exit_code: int
    figures: Mapping[str, Any]
    message: str = ""

    def row(self) -> dict[str, Any]:
        """Return the line by the names of its columns."""
        figures = {name: self.figures.get(name) for name in FIGURES}
        ending = {"exit_code": self.exit_code, **figures, "message": self.message}
        return {"folder": self.run.name, **self.run.values, **ending}


def columns(runs: Sequence[Run]) -> list[str]:
    """Return the names of the columns."""
    return ["folder", *runs[0].values, "exit_code", *FIGURES, "message"]


def is_done(folder: Path, scene: Scene, exports: Sequence[str], solvers: Sequence[str]) -> bool:
    """Return whether a folder holds the whole result of a scene.

    Args:
        folder: The folder.
        scene: The scene with the values of the run.
        exports: Formats that are asked for.
        solvers: Solvers that are to have judged the bed, whatever they found.
    """
    try:
        stored = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))["settings"]["settings"]
    except (OSError, ValueError, KeyError, TypeError):
        return False
    wanted = json.loads(json.dumps(plain(scene.model_dump())))
    written = all((folder / name).is_dir() for name in exports)
    return bool(stored == wanted and written and set(solvers) <= _had_their_turn(folder))


def _had_their_turn(folder: Path) -> set[str]:
    """Return the solvers that have judged the bed of a folder, or came to no end of their own with it."""
    try:
        content = json.loads((folder / VALIDATION).read_text(encoding="utf-8"))
        failed = () if content.get("interrupted") else content.get("errors", ())
        return {*content["solvers"], *failed}
    except (OSError, ValueError, KeyError, TypeError):
        return set()


def line_of_folder(run: Run, folder: Path) -> Line:
    """Return the line of a run whose result is there.

    Raises:
        OSError: It is not.
    """
    report = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
    missed = "; ".join(report["missed"])
    return Line(run, int(bool(missed)), main_figures(report), missed)


def write_table(path: Path, runs: Sequence[Run], lines: Sequence[Line]) -> None:
    """Write the table; it appears whole or not at all.

    Raises:
        OSError: It cannot be written.
    """
    text = io.StringIO()
    writer = csv.DictWriter(text, columns(runs), lineterminator="\n")
    writer.writeheader()
    writer.writerows(each.row() for each in lines)
    partial = path.with_name(f".{path.name}.unfinished")
    try:
        partial.write_text(text.getvalue(), encoding="utf-8")
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)
