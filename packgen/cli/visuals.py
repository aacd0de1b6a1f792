"""What people look at, page and pictures: made last, and never at the price of a finished bed."""

from __future__ import annotations

import os
import traceback
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from packgen.cli.screen import DEBUG_VARIABLE
from packgen.errors import PackgenError
from packgen.resultfolder import MANIFEST, PAGE, list_files
from packgen.stopping import stop_seen

if TYPE_CHECKING:  # a scene with a fault must not wait for scipy
    from packgen.bed import Bed
    from packgen.cli.stopwatch import Stopwatch
    from packgen.report import Report

Made = TypeVar("Made")


def write_looks(
    bed: Bed, report: Report, folder: Path, name: str, watch: Stopwatch, *, page: bool, picture: bool
) -> Report:
    """Write ``report.json``, page and pictures of a bed whose other files are written.

    Args:
        bed: The bed.
        report: All that is known of it, but for its files and the time that these take.
        folder: Where the files are.
        name: What the bed is called.
        watch: What times the stages.
        page: Whether to make the page.
        picture: Whether to draw pictures.

    Returns:
        The report as written, with a warning for each thing that could not be made.

    Raises:
        OSError: ``report.json`` cannot be written.
    """
    warnings: list[str] = []
    if picture:
        with watch.stage("picture"):
            _tried(lambda: _pictures(folder), "", warnings)
    view = None
    if page:
        with watch.stage("page"):
            view = _tried(lambda: _view(bed), f"no {PAGE}: ", warnings)
    listed = (*list_files(folder), MANIFEST)
    listed_too = () if view is None else (PAGE,)
    said = report.warnings
    report = replace(report, timings=watch.seconds, files=(*listed, *listed_too), warnings=(*said, *warnings))
    report.write(folder / MANIFEST)
    # The page shows what report.json says: it comes last.
    if view is not None and _tried(lambda: _page(folder, name, view), f"no {PAGE}: ", warnings) is None:
        report = replace(report, files=listed, warnings=(*said, *warnings))
        report.write(folder / MANIFEST)
    return report


# Each imports what it needs itself: a library that cannot be loaded costs no bed either.
def _pictures(folder: Path) -> tuple[Path, ...]:
    from packgen.page import write_pictures

    return write_pictures(folder)


def _view(bed: Bed) -> dict[str, Any]:
    from packgen.page import spheres_of, view_data

    return view_data(spheres_of(bed))


def _page(folder: Path, name: str, view: Mapping[str, Any]) -> Path:
    from packgen.page import write_page

    return write_page(folder, name, view)


def _tried(make: Callable[[], Made], what: str, warnings: list[str]) -> Made | None:
    """Return what a function makes; None, and a warning, where it fails in whatever way."""
    try:
        return make()
    except Exception as error:
        if stop_seen():  # compiled code makes another error of it
            raise KeyboardInterrupt from error
        if os.environ.get(DEBUG_VARIABLE):
            traceback.print_exc()
        kind = "" if isinstance(error, PackgenError) else f"{type(error).__name__}: "
        warnings.append(f"{what}{kind}{error}; all else is written")
        return None
