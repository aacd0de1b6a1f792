"""On what, when and with which versions a benchmark ran."""

from __future__ import annotations

import datetime
import os
import platform
import re
import shutil
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

LIBRARIES = ("packgen", "numpy", "numba", "torch", "spheropack")


def facts(seed: int) -> dict[str, str]:
    """Return machine, date, versions and seed of a run, as they stand above its table."""
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")
    return {
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d"),
        "cpu": cpu_model(),
        "cores": str(usable_cores()),
        "load before": f"{load:.2f}",
        "system": f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        "versions": ", ".join(f"{name} {found}" for name in LIBRARIES if (found := _version(name))),
        "liggghts": liggghts_version() or "not installed",
        "seed": str(seed),
    }


def usable_cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def cpu_model() -> str:
    """Return the processor's name, as the system tells it."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor() or "unknown"
    found = re.search(r"^model name\s*:\s*(.+)$", text, re.MULTILINE)
    return found.group(1).strip() if found else platform.processor() or "unknown"


def liggghts_version() -> str | None:
    """Return what LIGGGHTS calls itself; None where it is not installed."""
    executable = shutil.which("liggghts")
    if executable is None:
        return None
    command = [executable, "-log", "none"]  # it would leave a log in the current folder
    run = subprocess.run(command, input="", capture_output=True, text=True, check=False, errors="replace")
    found = re.search(r"LIGGGHTS-\S+ [\d.]+", run.stdout)
    return found.group() if found else "unknown version"


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None
