"""The folder of an unfinished run: gone on with by the same scene alone, and never replaced in silence."""

from __future__ import annotations

import errno
from dataclasses import replace

import pytest

from packgen.errors import ExportError
from packgen.workers.parts import Parts
from tests.beds import box_surface
from tests.scenes import box, constant, read_scene


@pytest.fixture
def scene(tmp_path):
    return read_scene(tmp_path, box([0, 0, 0], [1, 1, 1]), constant(0.1))[0]


@pytest.fixture
def parts(tmp_path):
    return Parts.beside(tmp_path / "results" / "bed")


def test_parts_stand_beside_the_results_under_a_name_of_their_own(tmp_path, parts, scene):
    parts.open(scene, resume=False)
    assert parts.folder == tmp_path / "results" / "bed.parts"
    assert not parts.begun


def test_a_run_goes_on_with_parts_of_its_own_scene(parts, scene):
    parts.open(scene, resume=False)
    parts.open(scene, resume=True)


def test_parts_are_not_replaced_by_a_run_that_does_not_ask_for_them(parts, scene):
    parts.open(scene, resume=False)
    with pytest.raises(ExportError, match="holds the parts of a run that did not end; give --resume"):
        parts.open(scene, resume=False)


def test_a_folder_that_a_run_uses_is_refused_by_the_run_beside_it(parts, scene, monkeypatch):
    parts.open(scene, resume=False)
    lock = parts.folder / "in_use"
    monkeypatch.setattr("packgen.workers.parts.owner", lambda: "1-1-0-0")
    for resume in (False, True):
        with pytest.raises(
            ExportError, match=r"in use by process \d+ on .*; wait for it, .* remove .*in_use"
        ):
            parts.open(scene, resume=resume)
    parts.unlock()  # of another run: it stays
    assert lock.exists()


def test_a_folder_whose_run_is_gone_is_gone_on_with(parts, scene, monkeypatch):
    parts.open(scene, resume=False)
    monkeypatch.setattr("packgen.workers.parts.owner", lambda: "1-1-0-0")
    monkeypatch.setattr("packgen.workers.parts.is_gone", lambda named: True)
    parts.open(scene, resume=True)
    assert (parts.folder / "in_use").read_text().startswith("1-1-0-0 ")
    parts.unlock()
    assert not (parts.folder / "in_use").exists()


def test_what_does_not_move_a_sphere_may_change_before_a_run_goes_on(tmp_path, parts):
    def scene(name, modulus, friction=0.5):
        return read_scene(
            tmp_path,
            box([0, 0, 0], [1, 1, 1]),
            constant(0.1) | {"name": name, "material": "ore"},
            materials={"ore": {"youngs_modulus": modulus, "friction": friction}},
            validation={"lost_limit": 3} if modulus > 1e8 else {},
        )[0]

    parts.open(scene("one", 1e8), resume=False)
    parts.open(scene("other", 1e9), resume=True)
    with pytest.raises(ExportError, match="differ in materials"):
        parts.open(scene("one", 1e8, 0.2), resume=True)


def test_there_is_nothing_to_go_on_with_where_no_run_has_begun(parts, scene):
    with pytest.raises(ExportError, match="found no parts of an earlier run"):
        parts.open(scene, resume=True)


def test_parts_of_another_scene_are_refused(parts, scene):
    parts.open(scene, resume=False)
    with pytest.raises(ExportError, match="parts of another bed, which differ in seed; remove"):
        parts.open(replace(scene, seed=scene.seed + 1), resume=True)


def test_parts_of_another_mesh_under_the_same_name_are_refused(tmp_path, parts):
    for side in (1.0, 2.0):
        surface = box_surface([0, 0, 0], [side, 1, 1])
        lines = ["OFF", f"{len(surface.vertices)} {len(surface.faces)} 0"]
        lines += [" ".join(map(str, corner)) for corner in surface.vertices.tolist()]
        lines += [f"3 {a} {b} {c}" for a, b, c in surface.faces.tolist()]
        (tmp_path / "vessel.off").write_text("\n".join(lines) + "\n")
        scene, _ = read_scene(tmp_path, {"path": "vessel.off"}, constant(0.1))
        if side == 1.0:
            parts.open(scene, resume=False)
    with pytest.raises(ExportError, match="differ in files"):
        parts.open(scene, resume=True)


def test_a_manifest_that_cannot_be_read_is_refused(parts, scene):
    parts.open(scene, resume=False)
    (parts.folder / "manifest.json").write_text("{")
    with pytest.raises(ExportError, match="cannot be read"):
        parts.open(scene, resume=True)


def test_a_folder_that_cannot_be_written_is_not_left_behind(parts, scene, monkeypatch):
    def full(self, *_, **__):
        self.touch()
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_text", full)
    with pytest.raises(ExportError, match="cannot be written: No space left on device; choose another"):
        parts.open(scene, resume=False)
    assert not parts.folder.exists()


def test_parts_are_begun_with_the_first_unit_and_removed_as_a_whole(parts, scene):
    parts.open(scene, resume=False)
    (parts.folder / "layer_00000_tile_0000_0000.npz").touch()
    assert parts.begun
    parts.remove()
    assert not parts.folder.exists()
