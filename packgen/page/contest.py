"""The page of a contest: an algorithm a row, with its figures or why it has no bed, and plots of the beds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from packgen.contest import HEAD, Standing, standing_rows
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
    rows = standing_rows(table)[1:]
    text = environment().get_template("contest.html.j2").render(
        name=name,
        table=table,
        labels=[row[0] for row in rows],
        rows=list(zip(table, zip(*(row[1:] for row in rows), strict=True), strict=True)),
        head=sum(row[0] in HEAD for row in rows),
        pages={
            each.algorithm: f"{each.folder}/report.html"
            for each in table
            if each.folder is not None and (folder / each.folder / "report.html").is_file()
        },
        plots=plots_by_title(list(reports), list(reports.values())),
        version=__version__,
    )  # fmt: skip
    return replace_page(folder / PAGE, text)
