"""The command in a process of its own, with a lattice in place of the core.

LATTICE_WAIT says what the core does before it returns, as compiled code and libraries do to a stop;
LATTICE_PAUSE names a function, ``module:attribute``, after which the run waits, for LATTICE_SECONDS. The file
LATTICE_MARK appears once it waits.
"""

from __future__ import annotations

import hashlib
import importlib
import os
import sys
import time
from functools import reduce
from pathlib import Path
from types import ModuleType, SimpleNamespace

from packgen.cli import main
from tests.beds import cubic_lattice, make_bed

LONG = 60.0


def wait_as_it_is() -> None:
    time.sleep(LONG)


def wait_and_make_another_error_of_it() -> None:
    try:
        time.sleep(LONG)
    except KeyboardInterrupt as error:
        raise SystemError("CPUDispatcher(<function f>) returned a result with an exception set") from error


def wait_and_lose_it() -> None:
    try:
        time.sleep(LONG)
    except KeyboardInterrupt:
        time.sleep(LONG)


def wait_and_do_not_hear_it() -> None:
    hashlib.pbkdf2_hmac("sha256", b"", b"", 2**31 - 1)  # no handler runs meanwhile


WAITS = {
    "as it is": wait_as_it_is,
    "another error": wait_and_make_another_error_of_it,
    "lost": wait_and_lose_it,
    "not heard": wait_and_do_not_hear_it,
}


def mark() -> None:
    Path(os.environ["LATTICE_MARK"]).touch()


def pack(scene, container, **_):
    if how := os.environ.get("LATTICE_WAIT"):
        mark()
        WAITS[how]()
    bed = make_bed(cubic_lattice(5, 0.1), 0.1, container, provenance={"scene": str(scene.path)})
    zone = SimpleNamespace(asked=125, placed=125, left_over=0, locations=())
    return SimpleNamespace(bed=bed, zones=(zone,), warnings=(), jamming=None, search=None)


def pause_after(name: str) -> None:
    module, _, path = name.partition(":")
    *places, last = path.split(".")
    holder = reduce(getattr, places, importlib.import_module(module))
    function = getattr(holder, last)

    def paused(*arguments, **named):
        result = function(*arguments, **named)
        mark()
        time.sleep(float(os.environ.get("LATTICE_SECONDS", LONG)))
        return result

    setattr(holder, last, paused)


if __name__ == "__main__":
    core = ModuleType("packgen.filling.pack")  # the real one takes seconds to load
    core.pack = pack
    sys.modules[core.__name__] = core
    if name := os.environ.get("LATTICE_PAUSE"):
        pause_after(name)
    sys.exit(main())
