"""``packgen report DIR`` and ``packgen compare DIR DIR ...``: pages from result folders."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from packgen.cli.ending import WHOLE_PAGES, Ending
from packgen.cli.names import refuse_unreadable
from packgen.cli.options import command_parser
from packgen.cli.screen import say, table


def run_page_command(command: str, arguments: Sequence[str], ending: Ending) -> int:
    """Run one of the two commands.

    Args:
        command: ``report`` or ``compare``.
        arguments: What follows it.
        ending: Told what is true of the pages.

    Returns:
        The exit code.

    Raises:
        PackgenError: A folder was not written by packgen.
    """
    return _compare(arguments, ending) if command == "compare" else _report(arguments, ending)


def _report(arguments: Sequence[str], ending: Ending) -> int:
    parser = command_parser("report", "Make report.html of result folders again.")
    parser.add_argument("folders", metavar="DIR", type=Path, nargs="+", help="result folder of a run")
    parser.add_argument("--picture", action="store_true", help="draw bed.png and bed_half.png too")
    options = parser.parse_args(arguments)
    refuse_unreadable(folder.resolve().name for folder in options.folders)
    from packgen.page import picture_folder, report_folder

    ending.claim = WHOLE_PAGES
    last = options.folders[-1]
    for folder in options.folders:
        page = report_folder(folder)
        if folder is last and not options.picture:
            ending.done(0, "all pages are written")
        say(f"written: {page}", sys.stdout)
        pictures = picture_folder(folder) if options.picture else ()
        if folder is last:
            ending.done(0, "all pages are written")
        for path in pictures:
            say(f"written: {path}", sys.stdout)
    return 0


def _compare(arguments: Sequence[str], ending: Ending) -> int:
    parser = command_parser("compare", "Put result folders side by side.")
    parser.add_argument("folders", metavar="DIR", type=Path, nargs="+", help="result folders of runs")
    parser.add_argument(
        "-o", "--output", metavar="FILE", type=Path, help="page to write (default: compare.html)"
    )
    options = parser.parse_args(arguments)
    refuse_unreadable(folder.resolve().name for folder in options.folders)
    from packgen.page import COMPARISON, compare_folders

    page = options.output or Path(COMPARISON)
    ending.claim = WHOLE_PAGES
    rows = compare_folders(options.folders, page)
    ending.done(0, f"the page is {page}")
    say(table(rows), sys.stdout)
    say(f"written: {page}", sys.stdout)
    return 0
