"""The snippets of the documentation, and a reader who follows a page from top to bottom.

A fence says what is to be done with it: ``bash``: every command is run, in order; ``python``: is run;
``yaml``: is loaded as a scene that lies beside the examples; ``text``: has to be in what the last commands
printed, numbers apart. A second word is a file name: such a block is saved under it where the reader is.
Nothing else may be fenced, so that nothing stays unread.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from packgen.scene import load_scene

ROOT = Path(__file__).resolve().parent.parent
LANGUAGES = {"bash", "python", "yaml", "text", "csv", "toml"}
FILES_ONLY = {"csv", "toml"}  # make no sense but as a file
# The suite itself, which no test can run; tests/test_examples.py looks at its syntax.
NOT_RUN = {"bash tests/run"}
TIMEOUT = 900  # s, of one command
NUMBER = re.compile(r"[-+]?\d[\d,.]*(e[-+]?\d+)?%?")


@dataclass(frozen=True)
class Block:
    """A fenced block: its page, line, language, file name (empty: none), and text."""

    page: Path
    line: int
    language: str
    name: str
    text: str

    def __str__(self) -> str:
        return f"{self.page.relative_to(ROOT)}:{self.line}"


def pages() -> list[Path]:
    guides = sorted((ROOT / "examples" / "guides").glob("*.md"))
    return [ROOT / "README.md", ROOT / "examples" / "README.md", *guides, ROOT / "examples/studies/README.md"]


def blocks_of(page: Path) -> list[Block]:
    """Return the blocks of a page; code in any other form than a fence at the margin is refused."""
    blocks, lines = [], page.read_text(encoding="utf-8").splitlines()
    start, kept, before = 0, [], ""
    for number, line in enumerate(lines, 1):
        if line.startswith("```"):
            if start:
                blocks.append(_block(page, start, lines[start - 1][3:].split(), kept))
                start = 0
            else:
                start, kept = number, []
        elif start:
            kept.append(line)
        elif re.match(r"\s+```|~~~|<pre|<code", line) or (line.startswith("    ") and not before.strip()):
            raise ValueError(f"{page}:{number}: code outside of a fence at the margin")
        before = line
    if start:
        raise ValueError(f"{page}:{start}: fence without an end")
    return blocks


def _block(page: Path, line: int, words: list[str], kept: list[str]) -> Block:
    language, name = (words[0] if words else ""), " ".join(words[1:])
    if language not in LANGUAGES or (language in FILES_ONLY and not name):
        raise ValueError(f"{page}:{line}: no test knows what to do with {' '.join(words) or 'this'}")
    return Block(page, line, language, name, "\n".join(kept) + "\n")


def commands_of(text: str) -> list[str]:
    """Return the commands of a bash block; one that goes on after a backslash is one."""
    joined = re.sub(r"\\\n\s*", " ", text)
    return [line for line in joined.splitlines() if line.strip() and not line.lstrip().startswith("#")]


class Reader:
    """Follows a page in a copy of the project; what a page installs stays in that copy."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / "project"
        self.site = folder / "site"
        # With --others: a page may be tried before it is committed.
        listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
        tracked = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=False)
        if tracked.returncode == 0:
            for name in tracked.stdout.splitlines():
                if (ROOT / name).is_file():
                    (self.root / name).parent.mkdir(parents=True, exist_ok=True)
                    shutil.copy2(ROOT / name, self.root / name)
        else:
            hidden = shutil.ignore_patterns(".*_cache", ".venv", ".git", "__pycache__")
            shutil.copytree(ROOT, self.root, ignore=hidden)
        self._take_compiled_loops()
        # The environment of the tests serves as the reader's.
        (self.root / ".venv").symlink_to(sys.prefix)
        self.place = self.root
        self.printed = ""
        self.environment = {
            **os.environ,
            "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]),
            "PYTHONPATH": str(self.site),
            "PIP_TARGET": str(self.site),
            "PIP_UPGRADE": "1",
            "PIP_NO_DEPS": "1",
            "PIP_NO_BUILD_ISOLATION": "0",  # 0 for the negative option: build with the backend that is here
            "PIP_QUIET": "1",
            "PIP_DISABLE_PIP_VERSION_CHECK": "1",
            "COLUMNS": "120",
        }

    def _take_compiled_loops(self) -> None:
        """Spare the reader a minute of compiling: the copied sources are as old as the loops' own."""
        for package in ("packgen", "exporters"):
            for path in (ROOT / package).rglob("*.nb[ic]"):
                copied = self.root / path.relative_to(ROOT)
                copied.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(path, copied)

    def follow(self, block: Block) -> None:
        if block.name:
            path = self.place / block.name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.text, encoding="utf-8")
        elif block.language == "bash":
            self.printed = ""
            for command in commands_of(block.text):
                self._run(command, block)
        elif block.language == "python":
            self._call([sys.executable, "-c", block.text], 0, str(block))
        elif block.language == "yaml":
            path = self.root / "examples" / "snippet.yaml"
            path.write_text(block.text, encoding="utf-8")
            load_scene(path)
        else:
            self._expect(block)

    def _run(self, command: str, block: Block) -> None:
        if command.partition("#")[0].strip() in NOT_RUN:
            return
        said = re.search(r"#.*exit code (\d)", command)
        place = self.root / ".place"
        script = f"{command}\nstatus=$?\npwd > {place}\nexit $status"
        before = self.printed
        self._call(["bash", "-c", script], int(said[1]) if said else 0, f"{block}: {command}")
        self.printed = before + self.printed
        self.place = Path(place.read_text(encoding="utf-8").strip())

    def _call(self, command: list[str], code: int, what: str) -> None:
        done = subprocess.run(
            command, cwd=self.place, env=self.environment, capture_output=True, text=True, errors="replace",
            timeout=TIMEOUT, check=False, stdin=subprocess.DEVNULL,
        )  # fmt: skip
        self.printed = done.stdout + done.stderr
        assert done.returncode == code, f"{what}: exit code {done.returncode}\n{self.printed}"

    def _expect(self, block: Block) -> None:
        """Hold expected output against what was printed: each line, numbers, blanks, (...) apart."""
        printed = "\n".join(_plain(line) for line in self.printed.splitlines())
        for line in filter(str.strip, block.text.splitlines()):
            pattern = re.escape(_plain(line)).replace(re.escape("(...)"), r"\(.*\)")
            found = re.search(f"^{pattern}$", printed, re.MULTILINE)
            assert found, f"{block}: not printed: {line}\n{self.printed}"


def _plain(line: str) -> str:
    return " ".join(NUMBER.sub("0", line).split())
