"""Page and pictures: made last, and never at the cost of a finished bed."""

from __future__ import annotations

import os
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

from packgen.cli.screen import DEBUG_VARIABLE
from packgen.cli.stopwatch import Stopwatch, peak_memory
from packgen.errors import PackgenError
from packgen.resultfolder import MANIFEST, PAGE, list_files
from packgen.stopping import stop_seen

if TYPE_CHECKING:  # a scene with a fault must not wait for scipy
    from packgen.bed import AnyBed
    from packgen.report import Measures, Report

Thing = TypeVar("Thing")


@dataclass(frozen=True, slots=True)
class _Made(Generic[Thing]):
    """The result of an attempt: the thing, or None and a warning."""

    thing: Thing | None = None
    warnings: tuple[str, ...] = ()


class Compose(Protocol):
    """What makes the report once the last files and warnings are known."""

    def __call__(self, *, files: Sequence[str], warnings: Sequence[str]) -> Report:
        """Return the report of a run.

        Args:
            files: All files of the run.
            warnings: What could not be drawn.
        """


def composer(
    measures: Measures,
    provenance: Mapping[str, Any],
    watch: Stopwatch,
    *,
    missed: Sequence[str],
    warnings: Sequence[str],
) -> Compose:
    """Return what makes the report once the last files are written.

    Args:
        measures: What was measured of the bed.
        provenance: Where the bed comes from.
        watch: What times the stages.
        missed: What was not reached, beside what the measures say.
        warnings: What looks wrong so far.
    """
    from packgen.report import compose_report

    so_far, memory = warnings, peak_memory()

    def compose(*, files: Sequence[str], warnings: Sequence[str]) -> Report:
        return compose_report(
            measures,
            provenance,
            missed=missed,
            warnings=(*so_far, *warnings),
            timings=watch.seconds,
            peak_memory=memory,
            files=files,
        )

    return compose


def write_looks(
    bed: AnyBed, compose: Compose, folder: Path, name: str, watch: Stopwatch, *, page: bool, picture: bool
) -> Report:
    """Write ``report.json``, page and pictures of a bed whose other files are written.

    Args:
        bed: The bed.
        compose: What makes the report.
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
    drawn: _Made[tuple[Path, ...]] = _Made()
    view: _Made[dict[str, Any]] = _Made()
    if picture:
        with watch.stage("picture"):
            drawn = _tried(lambda: _pictures(folder), "")
    if page:
        with watch.stage("page"):
            view = _tried(lambda: _view(bed), f"no {PAGE}: ")
    warnings = (*drawn.warnings, *view.warnings)
    listed = (*list_files(folder), MANIFEST)
    shown = view.thing
    report = compose(files=listed if shown is None else (*listed, PAGE), warnings=warnings)
    report.write(folder / MANIFEST)
    if shown is None:
        return report
    # The page shows what report.json says: it comes last.
    written = _tried(lambda: _page(folder, name, shown), f"no {PAGE}: ")
    if written.thing is None:
        report = compose(files=listed, warnings=(*warnings, *written.warnings))
        report.write(folder / MANIFEST)
    return report


# Each imports what it needs itself: a library that cannot be loaded costs no bed either.
def _pictures(folder: Path) -> tuple[Path, ...]:
    from packgen.page import write_pictures

    return write_pictures(folder)


def _view(bed: AnyBed) -> dict[str, Any]:
    from packgen.bed import Bed
    from packgen.page import spheres_of, view_data
    from packgen.pieces import GATHERED_MAX, PieceBed

    if isinstance(bed, PieceBed):
        if bed.count > GATHERED_MAX:
            raise PackgenError(
                f"found a bed in pieces of {bed.count:,} spheres, expected at most {GATHERED_MAX:,} to show"
            )
        bed = bed.gathered()
    assert isinstance(bed, Bed)
    return view_data(spheres_of(bed))


def _page(folder: Path, name: str, view: Mapping[str, Any]) -> Path:
    from packgen.page import write_page

    return write_page(folder, name, view)


def _tried(make: Callable[[], Thing], what: str) -> _Made[Thing]:
    """Return the result of a function, or a warning where it fails in any way."""
    try:
        return _Made(make())
    except Exception as error:
        if stop_seen():  # compiled code makes another error of it
            raise KeyboardInterrupt from error
        if os.environ.get(DEBUG_VARIABLE):
            traceback.print_exc()
        kind = "" if isinstance(error, PackgenError) else f"{type(error).__name__}: "
        return _Made(warnings=(f"{what}{kind}{error}; all else is written",))
