"""Leftovers of killed runs: each names its process, and is removed once that process is gone."""

from __future__ import annotations

import os
import re
import shutil
import socket
import zlib
from contextlib import suppress
from functools import cache
from pathlib import Path

NOBODY = "0-0-0-0"  # where the system does not tell: such folders are never removed
SCRATCH = "packgen_"  # the solvers' temporary folders
_OWNER = r"(?P<pid>[0-9a-f]+)-(?P<start>[0-9a-f]+)-(?P<machine>[0-9a-f]+)-(?P<boot>[0-9a-f]+)"


@cache
def _here() -> tuple[str, str] | None:
    """Return a tag of this machine and one of the time since it started; None where it does not tell.

    A folder may be shared by machines and containers, whose process numbers mean nothing here.
    """
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text()
        namespace = os.readlink("/proc/self/ns/pid")
    except OSError:
        return None
    with suppress(OSError):
        namespace += Path("/etc/machine-id").read_text()
    machine = f"{socket.gethostname()} {namespace}"
    return _tag(machine), _tag(boot)


def _tag(text: str) -> str:
    return f"{zlib.crc32(text.encode(errors='surrogateescape')):08x}"


def _start_of(pid: int) -> int | None:
    """Return when a process started, in ticks since the machine did; None where there is no such process."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text(errors="replace")
    except OSError:
        return None
    # The name of the program comes second, in brackets, and may hold anything.
    state, *values = text.rpartition(")")[2].split()
    return None if state in "ZX" else int(values[18])


def owner() -> str:
    """Return this process as part of a file's name: number and start of the process, machine, and its start.

    A later process may have the same number.
    """
    here, start = _here(), _start_of(os.getpid())
    return NOBODY if here is None or start is None else f"{os.getpid():x}-{start:x}-{here[0]}-{here[1]}"


def is_gone(named: str) -> bool:
    """Return whether the process that `owner` named is known to have ended."""
    found, here = re.fullmatch(_OWNER, named), _here()
    if found is None or here is None or found["machine"] != here[0]:
        return False
    if found["boot"] != here[1]:
        return True  # this machine has been started anew since
    return _start_of(int(found["pid"], 16)) != int(found["start"], 16)


def abandoned(folder: Path, prefix: str) -> list[Path]:
    """Return the folders in a folder that are named after a process that is gone, in order of names.

    Args:
        folder: Where to look.
        prefix: What comes before the process in their names, a regular expression.
    """
    pattern = re.compile(prefix + f"(?P<owner>{_OWNER})" + r"-\w+~*")
    found = []
    with suppress(OSError), os.scandir(folder) as entries:
        for each in entries:
            match = pattern.fullmatch(each.name)
            if match and each.is_dir(follow_symlinks=False) and is_gone(match["owner"]):
                found.append(folder / each.name)
    return sorted(found)


def remove_scratch(folder: Path) -> None:
    """Remove the solvers' temporary folders of runs of this user that were killed."""
    for path in abandoned(folder, SCRATCH):
        with suppress(OSError):
            if path.stat().st_uid == os.getuid():
                shutil.rmtree(path, ignore_errors=True)
