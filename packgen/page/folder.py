"""Pages from result folders: ``bed.npz``, ``report.json`` and ``validation.json`` are all they need."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from packgen.errors import PackgenError
from packgen.page.figures import side_by_side
from packgen.page.html import comparison_html, report_html
from packgen.page.names import bed_name
from packgen.page.picture import write_pictures
from packgen.page.spheres import read_spheres, view_data
from packgen.reading.known import known_by_provenance
from packgen.resultfolder import MANIFEST, PAGE

COMPARISON = "compare.html"
VALIDATION = "validation.json"
KEYS = (
    "packgen", "missed", "sphere_count", "zones", "sets", "overlap", "solid_fraction", "contacts", "sizes",
    "timings", "peak_memory", "settings", "files",
)  # fmt: skip


def report_folder(folder: Path) -> Path:
    """Make the page of a result folder again.

    Args:
        folder: What a run left.

    Returns:
        The page.

    Raises:
        PackgenError: The folder was not written by packgen.
        OSError: The page cannot be written.
    """
    report = read_report(folder)
    direction = report["settings"].get("settings", {}).get("gravity_direction")
    container = known_by_provenance(report["settings"], meshes=True).container
    view = view_data(read_spheres(folder / "bed.npz", direction, container))
    _list(folder, PAGE)
    return write_page(folder, folder.resolve().name, view)


def picture_folder(folder: Path) -> tuple[Path, ...]:
    """Draw the pictures of a result folder.

    Args:
        folder: What a run left.

    Returns:
        The pictures.

    Raises:
        PackgenError: The folder was not written by packgen, or nothing can be drawn.
        OSError: ``report.json`` cannot be written.
    """
    read_report(folder)
    drawn = write_pictures(folder)
    _list(folder, *(path.name for path in drawn))
    return drawn


def _list(folder: Path, *names: str) -> None:
    """Add names to the files of ``report.json``, else the next run takes them for somebody else's."""
    report = read_report(folder)
    if not set(names) <= set(report["files"]):
        report["files"] = sorted({*report["files"], *names})
        replace_page(folder / MANIFEST, json.dumps(report, indent=2, ensure_ascii=False) + "\n")


def write_page(folder: Path, name: str, view: Mapping[str, Any]) -> Path:
    """Write the page of a folder whose ``report.json`` is written.

    Args:
        folder: The folder.
        name: Name of the folder that it will have.
        view: What `packgen.page.spheres.view_data` gives.

    Returns:
        The page.
    """
    validation = _read(folder / VALIDATION) if (folder / VALIDATION).exists() else {}
    report = read_report(folder)
    replace_page(folder / PAGE, report_html(bed_name(report, name), report, validation, view))
    return folder / PAGE


def compare_folders(folders: Sequence[Path], page: Path) -> list[tuple[str, ...]]:
    """Put result folders side by side in one page.

    Args:
        folders: The result folders.
        page: The file to write; one that packgen wrote is replaced.

    Returns:
        The table of the page, with its head.

    Raises:
        PackgenError: A folder was not written by packgen, or packgen did not write the file.
        OSError: The page cannot be written.
    """
    if page.exists() and b'name="generator" content="packgen' not in page.read_bytes()[:1000]:
        raise PackgenError(f"{page}: exists and is no page of packgen; choose another file with -o")
    reports = [read_report(folder) for folder in folders]
    names = [folder.resolve().name for folder in folders]
    if len(set(names)) < len(names):
        names = [folder.as_posix() for folder in folders]
    replace_page(page, comparison_html(names, reports))
    return [("", *names), *side_by_side(reports)]


def read_report(folder: Path) -> dict[str, Any]:
    """Return the content of a folder's ``report.json``.

    Raises:
        PackgenError: It is missing, or no report of packgen.
    """
    content = _read(folder / MANIFEST)
    missing = [key for key in KEYS if key not in content]
    if missing:
        raise PackgenError(f"{folder / MANIFEST}: has no {', '.join(missing)}; run the scene again")
    return content


def _read(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise PackgenError(f"{path}: not found; expected a result folder of packgen") from error
    except (OSError, ValueError) as error:
        raise PackgenError(f"{path}: cannot be read ({error}); run the scene again") from error
    if not isinstance(content, dict):
        raise PackgenError(f"{path}: found no JSON object; run the scene again")
    return content


def replace_page(path: Path, text: str) -> Path:
    """Write a file that appears whole or not at all, and return its path."""
    partial = path.with_name(f".{path.name}.unfinished")
    try:
        partial.write_text(text, encoding="utf-8")
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)
    return path
