"""How many cores this process may really use."""

from __future__ import annotations

import math
import os
from pathlib import Path

GROUPS = Path("/sys/fs/cgroup")


def free_cores(groups: Path = GROUPS, membership: Path = Path("/proc/self/cgroup")) -> int:
    """Return the cores that this process is bound to, or the quota of its control groups where that is less.

    Args:
        groups: Where the control groups are mounted.
        membership: What names the one of this process.

    Returns:
        A number of cores, at least 1.
    """
    bound = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, min(bound, math.floor(_quota(groups, membership) + 0.5)))


def _quota(groups: Path, membership: Path) -> float:
    """Return the cores that control groups grant (Linux kernel documentation, "cpu.max", "cpu.cfs_quota_us").

    A group has no more than any group that it is part of.
    """
    least = 1e9
    try:
        lines = membership.read_text(encoding="utf-8").splitlines()
    except OSError:
        return least
    for line in lines:
        _, controllers, name = line.split(":", 2)
        if controllers and "cpu" not in controllers.split(","):
            continue
        base = groups / "cpu" if controllers else groups
        folder = base / name.strip("/")
        # In a container the name may be that of the host, which is not there.
        for each in (folder, *folder.parents):
            if each.is_relative_to(base):
                least = min(least, _granted(each))
    return least


def _granted(folder: Path) -> float:
    try:
        if (folder / "cpu.max").exists():
            quota, period = (folder / "cpu.max").read_text(encoding="ascii").split()
        else:
            quota = (folder / "cpu.cfs_quota_us").read_text(encoding="ascii").strip()
            period = (folder / "cpu.cfs_period_us").read_text(encoding="ascii").strip()
        return float(quota) / float(period) if float(quota) > 0.0 else 1e9
    except (OSError, ValueError, ZeroDivisionError):
        return 1e9
