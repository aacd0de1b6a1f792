"""The page of a contest: a table of algorithms, why some have no bed, and the plots of their beds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from packgen.contest import Standing, standing_rows
from packgen.page.folder import read_report, replace_page
from packgen.page.html import environment, plots_by_title
from packgen.version import __version__

__all__ = ["PAGE", "write_contest_page"]

PAGE = "contest.html"


def write_contest_page(folder: Path, name: str, table: Sequence[Standing]) -> Path:
    """Write the page of a contest.

    Args:
        folder: The folder of its runs.
        name: What the scene is called.
        table: How the algorithms stand.

    Returns:
        The page.

    Raises:
        PackgenError: A bed's report cannot be read.
        OSError: The page cannot be written.
    """
    reports: dict[str, Mapping[str, Any]] = {
        each.algorithm: read_report(folder / each.folder) for each in table if each.folder is not None
    }
    text = environment().get_template("contest.html.j2").render(
        name=name,
        table=table,
        rows=standing_rows(table),
        pages={
            each.algorithm: f"{each.folder}/report.html"
            for each in table
            if each.folder is not None and (folder / each.folder / "report.html").is_file()
        },
        plots=plots_by_title(list(reports), list(reports.values())),
        version=__version__,
    )  # fmt: skip
    return replace_page(folder / PAGE, text)
