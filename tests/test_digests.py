"""One bed on every machine: digests of twelve scenes, here and as an older processor would compute them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.digests import KEPT, SCENES, digest_of
from tests.seeds import unshifted

pytestmark = unshifted

ROOT = Path(__file__).resolve().parent.parent
EXPECTED = json.loads(KEPT.read_text(encoding="utf-8"))
OF_TORCH = "adam"  # its sums are torch's, and these depend on the instruction set unless told otherwise
PLAIN_TORCH = {"ATEN_CPU_CAPABILITY": "default", "MKL_CBWR": "COMPATIBLE"}


def dispatched_features() -> str:
    """The instruction sets for which numpy has loops of their own and that this machine has."""
    from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__

    return " ".join(name for name in __cpu_dispatch__ if __cpu_features__.get(name))


def lacks_fused_products() -> bool:
    """Whether this processor is as old as the switches make it: they change nothing then."""
    from numpy._core._multiarray_umath import __cpu_features__

    return not __cpu_features__.get("FMA3")


def digests_under(environment: dict[str, str], *names: str) -> dict[str, str]:
    run = subprocess.run(
        [sys.executable, "-m", "tests.digests", *names],
        env=os.environ | environment,
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    digests: dict[str, str] = json.loads(run.stdout)
    return digests


def test_the_digests_are_of_all_scenes():
    assert list(EXPECTED) == list(SCENES)
    assert len(set(EXPECTED.values())) == len(SCENES)


@pytest.mark.parametrize("name", [name for name in SCENES if name != OF_TORCH])
def test_a_bed_has_the_digest_that_it_has_on_every_machine(name):
    assert digest_of(name) == EXPECTED[name]


def test_the_bed_of_adam_is_the_same_where_torch_uses_no_special_instructions():
    assert digests_under(PLAIN_TORCH, OF_TORCH)[OF_TORCH] == EXPECTED[OF_TORCH]


@pytest.mark.slow
def test_an_older_processor_makes_the_same_beds(tmp_path):
    older = {
        "NPY_DISABLE_CPU_FEATURES": dispatched_features(),
        "NUMBA_CPU_NAME": "x86-64",
        "NUMBA_CPU_FEATURES": "",
        "NUMBA_CACHE_DIR": str(tmp_path),
        "OPENBLAS_CORETYPE": "Nehalem",
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-AVX2_Usable,-FMA,-FMA_Usable,-FMA4",
    }
    others = [name for name in SCENES if name != OF_TORCH]
    assert digests_under(older, *others) == {name: EXPECTED[name] for name in others}


@pytest.mark.skipif(sys.platform != "linux", reason="the C library's switches are those of Linux")
@pytest.mark.skipif(lacks_fused_products(), reason="the processor is an older one itself")
def test_the_switches_of_an_older_processor_do_something():
    code = "import numpy as np; print(np.exp(np.linspace(-9, 9, 100_000)).tobytes().__hash__())"
    plain = {"PYTHONHASHSEED": "0"}
    older = plain | {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-AVX2_Usable,-FMA,-FMA_Usable,-FMA4"}
    older["NPY_DISABLE_CPU_FEATURES"] = dispatched_features()
    found = [
        subprocess.run(
            [sys.executable, "-c", code], env=os.environ | each, capture_output=True, text=True, check=True
        ).stdout
        for each in (plain, older)
    ]
    assert found[0] != found[1]
