"""What a page calls its bed: by its scene."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePath
from typing import Any

__all__ = ["bed_name"]


def bed_name(report: Mapping[str, Any], folder: str) -> str:
    """Return what a bed is called: its scene, and its folder where that is called otherwise.

    Args:
        report: Content of ``report.json``.
        folder: Name of its folder.
    """
    settings = report["settings"]
    scene = settings.get("scene")
    if not isinstance(scene, str) or scene in ("", "none") or "read_from" in settings:
        return folder
    name = PurePath(scene).stem
    return name if folder in (name, "bed") else f"{name}, {folder}"
