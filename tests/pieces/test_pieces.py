"""A bed in pieces is the bed: the same spheres, numbered piece by piece, and no file that is not whole."""

from __future__ import annotations

import json
import weakref
from dataclasses import replace

import numpy as np
import pytest

from packgen.census import Census
from packgen.errors import ReadError
from packgen.pieces import MANIFEST, PieceWriter, in_pieces, is_manifest, read_manifest
from packgen.pieces import bed as bed_module
from packgen.pieces.bed import NAMES
from packgen.pieces.grid import Grid
from tests.pieces.beds import shaken


@pytest.fixture(scope="module")
def bed():
    return shaken()


@pytest.fixture
def pieces(bed, tmp_path):
    return in_pieces(bed, tmp_path, spheres=100)


def rows(bed):
    """Spheres as sorted rows."""
    table = np.column_stack([getattr(bed, name) for name in NAMES])
    return table[np.lexsort(table.T)]


def test_the_pieces_have_the_beds_spheres_and_no_others(bed, pieces):
    assert len(pieces.pieces) > 8
    assert np.array_equal(rows(pieces.gathered()), rows(bed))
    assert pieces.census == bed.census
    assert pieces.count == bed.count


def test_a_vessel_that_wraps_around_is_refused(bed, tmp_path):
    wraps = replace(bed, container=replace(bed.container, periodic=(True, False, False)))
    with pytest.raises(ValueError, match="found a vessel that wraps around"):
        in_pieces(wraps, tmp_path)


def test_numbers_go_on_from_piece_to_piece(pieces):
    gathered = pieces.gathered()
    for piece, chunk in zip(pieces.pieces, pieces.chunks(), strict=True):
        own = slice(piece.offset, piece.offset + piece.count)
        assert np.array_equal(chunk.position, gathered.position[own])
        assert (chunk.position >= piece.low).all()
        assert (chunk.position <= piece.high).all()


def test_a_part_has_all_spheres_around_it_with_their_numbers(pieces):
    gathered, reach = pieces.gathered(), 1.7
    for part in pieces.parts(reach):
        assert np.array_equal(part.bed.position, gathered.position[part.number])
        own = part.bed.position[: part.own]
        near = (gathered.position >= own.min(axis=0) - reach) & (gathered.position <= own.max(axis=0) + reach)
        assert set(part.number.tolist()) == set(np.flatnonzero(near.all(axis=1)).tolist())


def test_the_pieces_do_not_depend_on_how_the_spheres_come(bed, pieces, tmp_path, monkeypatch):
    monkeypatch.setattr("packgen.pieces.write.HELD_MAX", 64)
    other = tmp_path / "other"
    other.mkdir()
    grid = Grid.over(
        bed.container.bounds, 4 / 3 * np.pi * float((bed.radius**3).mean()), bed.radius.max(), 100
    )
    writer = PieceWriter(other, grid, 2)
    for start in range(0, bed.count, 50):
        writer.add(*(getattr(bed, name)[start : start + 50] for name in NAMES))
    found, census = writer.finish()
    assert (found, census) == (pieces.pieces, pieces.census)
    for piece in found:
        assert (other / piece.file).read_bytes() == (tmp_path / piece.file).read_bytes()


def test_every_nth_sphere_is_that_of_the_gathered_bed(pieces):
    assert np.array_equal(pieces.every(7).position, pieces.gathered().position[::7])


@pytest.mark.parametrize("step", ["every", "part", "in_box", "chunks"])
def test_no_step_keeps_the_pieces_that_it_has_read(pieces, monkeypatch, step):
    read, alive, most = bed_module.read_piece, [], [0]

    def watched(*arguments):
        alive[:] = [each for each in alive if each() is not None]
        most[0] = max(most[0], len(alive))
        columns = read(*arguments)
        owner = columns.position if columns.position.base is None else columns.position.base
        alive.append(weakref.ref(owner))
        return columns

    monkeypatch.setattr(bed_module, "read_piece", watched)
    if step == "chunks":
        for _ in pieces.chunks():
            pass
    elif step == "part":
        for _ in pieces.parts(0.5):
            pass
    elif step == "every":
        pieces.every(5)
    else:
        pieces.in_box(np.full(3, 3.0), np.full(3, 20.0))
    assert most[0] <= 2


def test_a_manifest_is_known_by_what_is_in_it_and_comes_back(pieces, tmp_path):
    path = tmp_path / MANIFEST
    assert is_manifest(path)
    assert not is_manifest(tmp_path / "none.json")
    (tmp_path / "other.json").write_text("{}")
    assert not is_manifest(tmp_path / "other.json")
    found = read_manifest(path)
    assert (found.pieces, found.census) == (pieces.pieces, pieces.census)
    assert found.provenance["scene"] == "shaken.yaml"


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda found: found.update(version=2), "found version 2 of a bed in pieces, expected 1"),
        (lambda found: found.pop("census"), "damaged manifest"),
        (lambda found: found["pieces"].pop(3), "from number .* expected some from"),
        (lambda found: found["pieces"].pop(), "found pieces of .* spheres, expected 1,728"),
        (lambda found: found["pieces"][0].update(file="../bed.npz"), "expected one below the manifest"),
    ],
)
def test_a_manifest_that_is_wrong_is_refused_in_a_line(pieces, tmp_path, change, told):
    path = tmp_path / MANIFEST
    found = json.loads(path.read_text())
    change(found)
    path.write_text(json.dumps(found))
    with pytest.raises(ReadError, match=told) as error:
        read_manifest(path)
    assert len(str(error.value).splitlines()) == 1


def test_a_piece_that_is_damaged_or_gone_is_told_in_a_line(pieces, tmp_path):
    first, second, third = (tmp_path / each.file for each in pieces.pieces[:3])
    first.write_bytes(first.read_bytes()[:200])
    second.unlink()
    with np.load(third) as stored:
        fewer = {name: stored[name][:-1] for name in stored}
    np.savez(third, **fewer)
    for place, told in enumerate(["damaged piece", "no such piece", "other spheres than the manifest says"]):
        with pytest.raises(ReadError, match=told) as error:
            pieces.part(pieces.pieces[place], 0.0)
        assert len(str(error.value).splitlines()) == 1


def test_a_census_is_the_same_in_parts_to_the_last_digit(bed, pieces):
    parts = [each.census for each in pieces.chunks()]
    found = parts[0]
    for each in parts[1:]:
        found = found.join(each)
    assert found == bed.census
    assert Census.from_json(json.loads(json.dumps(found.as_json()))) == found
    assert found.radius_mean == pytest.approx(bed.radius.mean(), rel=1e-15)
