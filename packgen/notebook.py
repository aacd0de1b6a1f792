"""How a bed looks in a notebook: its verdict, and the page of a report in a frame. Nothing is written."""

from __future__ import annotations

import html
import json
from collections.abc import Sequence
from typing import Any

from packgen.amounts import ZoneOutcome
from packgen.bed import Bed
from packgen.jamming import Jamming
from packgen.search import Search

__all__ = ["bed_html"]

HEIGHT = 720  # pixels of the frame
SHOWN_MAX = 100_000  # spheres in a notebook, which keeps them all: about 1 MB


def bed_html(
    bed: Bed,
    zones: Sequence[ZoneOutcome] = (),
    warnings: Sequence[str] = (),
    jamming: Jamming | None = None,
    search: Search | None = None,
) -> str:
    """Return a bed as HTML: a line with its verdict, and below it the page.

    Args:
        bed: The bed.
        zones: What was asked of each zone; nothing: that is not judged.
        warnings: What looks wrong.
        jamming: How it is jammed.
        search: How it was found.
    """
    from packgen.page import spheres_of, view_data
    from packgen.page.html import report_html
    from packgen.page.names import bed_name
    from packgen.report import compose_report, measure_bed

    measures = measure_bed(bed, zones=zones, jamming=jamming, search=search)
    report = compose_report(measures, bed.provenance, warnings=warnings)
    content: dict[str, Any] = json.loads(report.as_json())
    page = report_html(bed_name(content, "bed"), content, {}, view_data(spheres_of(bed), SHOWN_MAX))
    verdict = "✔ complete" if not report.missed else "✘ missed: " + "; ".join(report.missed)
    solid = report.solid_fraction
    fraction = (
        f"{solid.filled:.4f}" if solid.core is None else f"{solid.filled:.4f}, of its core {solid.core:.4f}"
    )
    line = f"{verdict}; {bed.count:,} spheres, solid fraction {fraction}"
    # A page within a page: quotes and ampersands of the inner one are escaped.
    frame = f'<iframe srcdoc="{html.escape(page)}" style="width:100%;height:{HEIGHT}px;border:0"></iframe>'
    return f"<p><strong>{html.escape(line)}</strong></p>\n{frame}"
