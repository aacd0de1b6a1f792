"""What cannot be shown costs its line, never the bed: whole runs, with streams that fail in every way."""

from __future__ import annotations

import io
import json
import os
from pathlib import Path

import pytest

from packgen.cli.screen import Screen, say
from tests.cli.processes import in_shell
from tests.cli.scenes import SCENE

FAILING = [
    '"$@" >/dev/full',
    '"$@" >&-',
    '"$@" 2>&-',
    '"$@" >&- 2>&-',
    '"$@" >/dev/full 2>&1',
    '"$@" <&- >&- 2>&-',
]
full_disk = pytest.mark.skipif(not Path("/dev/full").exists(), reason="the system has no /dev/full")


@pytest.fixture
def scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("box.yaml").write_text(SCENE)
    return "box.yaml"


@full_disk
@pytest.mark.slow
@pytest.mark.parametrize("line", FAILING)
def test_output_that_fails_is_no_failure_of_the_bed(scene, line):
    done = in_shell(line, scene, "--export", "liggghts")
    assert done.returncode == 0
    assert b"nothing was written" not in done.stderr
    assert b"fault of packgen" not in done.stderr
    assert b"Traceback" not in done.stderr
    listed = json.loads(Path("box/report.json").read_text())["files"]
    assert {"bed.npz", "report.json", "report.html", "liggghts/bed.data", "liggghts/in.bed"} <= set(listed)
    assert all(Path("box", name).stat().st_size for name in listed)
    assert sorted(os.listdir()) == ["box", "box.yaml"]


@full_disk
def test_a_summary_that_finds_no_room_is_said_once(scene):
    done = in_shell('"$@" >/dev/full', scene)
    (line,) = done.stderr.splitlines()
    assert line == b"packgen: standard output cannot be written: No space left on device"


def test_closed_error_output_leaves_the_summary(scene):
    done = in_shell('"$@" 2>&-', scene)
    assert b"125 of 125" in done.stdout
    assert done.stderr == b""


@full_disk
@pytest.mark.slow
@pytest.mark.parametrize("line", FAILING)
def test_pages_are_made_whatever_becomes_of_the_output(scene, line):
    assert in_shell('"$@"', scene, "--no-report", "--quiet").returncode == 0
    for arguments, page in (
        (["report", "box"], "box/report.html"),
        (["compare", "box", "box"], "compare.html"),
    ):
        done = in_shell(line, *arguments)
        assert done.returncode == 0
        assert b"nothing was written" not in done.stderr
        assert b"Traceback" not in done.stderr
        assert Path(page).stat().st_size


@full_disk
@pytest.mark.slow
@pytest.mark.parametrize("line", FAILING)
@pytest.mark.parametrize(
    ("argument", "code"), [("--help", 0), ("--version", 0), ("--sed", 2), ("none.yaml", 2)]
)
def test_what_makes_no_bed_keeps_its_exit_code(scene, line, argument, code):
    done = in_shell(line, argument)
    assert done.returncode == code
    assert b"Traceback" not in done.stderr
    assert b"Exception ignored" not in done.stderr


@pytest.mark.parametrize(
    "values", [{"PYTHONIOENCODING": "ascii"}, {"LC_ALL": "C"}, {"PYTHONIOENCODING": "latin-1"}]
)
def test_a_name_that_the_terminal_has_not_is_shown_as_codes(scene, values):
    Path("kürzen_æθ.yaml").write_text(SCENE)
    done = in_shell('"$@"', "kürzen_æθ.yaml", **values)
    assert done.returncode == 0
    assert b"written to" in done.stdout
    assert Path("kürzen_æθ", "report.html").exists()


@pytest.mark.parametrize(
    "arguments", [[b"caf\xe9.yaml"], [b"box.yaml", b"-o", b"caf\xe9"], [b"report", b"caf\xe9"]]
)
def test_a_name_that_is_no_text_is_refused_with_a_line(scene, arguments):
    Path(os.fsdecode(b"caf\xe9.yaml")).write_text(SCENE)
    done = in_shell('"$@"', *arguments)
    assert done.returncode == 2
    (line,) = done.stderr.decode().splitlines()
    assert "caf\\xe9" in line
    assert "expected" in line
    assert "rename it" in line
    assert sorted(os.listdir(b".")) == [b"box.yaml", b"caf\xe9.yaml"]


def test_a_folder_whose_name_is_no_text_is_refused_by_any_name(scene):
    folder = Path(os.fsdecode(b"caf\xe9"))
    folder.mkdir()
    Path("link").symlink_to(folder, target_is_directory=True)
    for arguments in (["report", "link"], ["compare", "link"], [scene, "-o", "link"]):
        done = in_shell('"$@"', *arguments)
        assert done.returncode == 2
        assert b"rename it" in done.stderr
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize(
    "error", [BrokenPipeError(), BlockingIOError(11, "again"), OSError(28, "full"), ValueError("closed")]
)
def test_a_stream_that_fails_raises_nothing(error):
    class Failing(io.StringIO):
        def write(self, text):
            raise error

    say("line", Failing())
    assert Screen(Failing()).write("bar") == 3


def test_a_screen_is_else_the_stream():
    stream = io.StringIO()
    screen = Screen(stream)
    screen.write("text")
    screen.flush()
    assert (stream.getvalue(), screen.isatty(), screen.closed) == ("text", False, False)
