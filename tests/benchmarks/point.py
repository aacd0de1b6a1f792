"""One point of the scaling curves, measured in a process of its own.

    python tests/benchmarks/point.py '{"scene": {...}, "threads": 1, "warm": true, "check": true}'

Prints one line of JSON: time, memory, and a digest of the bed, which must not depend on the threads.
"""

from __future__ import annotations

import hashlib
import json
import resource
import sys
import time
from typing import Any

START = time.perf_counter()

from columns import arrange, column_document  # noqa: E402
from quality import quality  # noqa: E402

MEGABYTE = 1.0e6


def measure(task: dict[str, Any]) -> dict[str, Any]:
    """Return what the arrangement of a scene took.

    Args:
        task: ``scene``: the scene; ``threads``: as ``packgen --threads``, or None; ``warm``: arrange a few
            spheres first, so that nothing is compiled or loaded meanwhile; ``check``: judge the bed.
    """
    if task["warm"]:
        arrange(column_document(100, seed=0, width=0.4), threads=task["threads"])
    before = _peak()
    bed, seconds = arrange(task["scene"], threads=task["threads"])
    result = {
        "spheres": bed.count,
        "seconds": seconds,
        "seconds_in_all": time.perf_counter() - START,
        "microseconds_a_sphere": 1e6 * seconds / max(bed.count, 1),
        "peak_memory_MB": _peak(),
        "memory_before_MB": before,
        "bed": hashlib.sha256(bed.position.tobytes()).hexdigest()[:12],
    }
    if task["check"]:
        judged = quality(bed)
        result |= {"core_density": judged.core_density, "overlap_max": judged.overlap_max}
    return result


def _peak() -> float:
    """Return the largest memory this process held so far [MB]."""
    unit = 1.0 if sys.platform == "darwin" else 1024.0
    return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / MEGABYTE


if __name__ == "__main__":
    print(json.dumps(measure(json.loads(sys.argv[1]))))
