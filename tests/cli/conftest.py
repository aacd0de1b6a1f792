"""A scene, and a core that is a lattice: tests of the command line run in no time."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from tests.beds import cubic_lattice, make_bed
from tests.cli.scenes import SCENE


@dataclass
class Zone:
    asked: int | None = 125
    placed: int = 125
    left_over: int = 0
    locations: tuple[object, ...] = ()


@dataclass
class Result:
    bed: object
    zones: tuple[Zone, ...] = (Zone(),)
    warnings: tuple[str, ...] = ()
    jamming: None = None
    search: None = None


@pytest.fixture
def scene(tmp_path, monkeypatch):
    """A scene file in an otherwise empty current folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "box.yaml").write_text(SCENE)
    return "box.yaml"


@pytest.fixture
def core(monkeypatch):
    """Replaces the core by one that returns, or raises, what the test says."""

    def install(outcome=None, *, shift=0.0, placed=125, warnings=(), called_with=None):
        def pack(scene, container, *, warn, **keys):
            (called_with if called_with is not None else {}).update(keys)
            for line in warnings:
                warn(line)
            if outcome is not None:
                raise outcome
            position = cubic_lattice(5, 0.1)[:placed]
            position[0, 2] += shift
            bed = make_bed(position, 0.1, container, provenance={"seed": scene.seed})
            return Result(bed, (Zone(125, placed, 125 - placed),), warnings)

        monkeypatch.setattr("packgen.filling.pack.pack", pack)

    return install
