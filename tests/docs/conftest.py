"""Runs a page of the documentation as its reader would: block by block, in order.

- ```` ```console ```` lines that begin with `$ ` are given to bash; what follows up to the next one
  is the expected output, errors included. A command that ends in ` &` goes on in the background
  until the page ends, when it must leave with exit code 0 at SIGTERM; `fg` waits for the last one,
  `kill %%` ends it, and both expect the rest of its output. `console fails` expects every command
  of the block to fail.
- ```` ```python ```` is executed; one namespace serves the page. ```` ```js ```` is run by Node.js.
  A ```` ```text ```` block right after either is what it prints.
- A block with `title="name"` is written to that file.

In expected output `…` stands for anything within a line, alone in a line for any lines. Each page
has a folder and a loopback address of its own: `127.0.0.1` in a page means that address, and
ACHSE_HOST hands it to the commands.
"""

import contextlib
import io
import os
import re
import shutil
import signal
import subprocess
import sysconfig
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path
from typing import Any
from unittest import mock

import pytest

from tests.warm_commands import WarmCommands

LANGUAGES = {"console", "python", "js", "text", "toml", "sh", "yaml", "powershell"}
"""What a fence may say; `sh`, `yaml` and `powershell` are only shown."""

NPM = Path(__file__).parents[1] / "interop" / "npm"
"""Where Node.js finds its packages."""

PATIENCE = 60.0
"""Seconds for one command, or for a background command's first lines."""

LOOPBACK = re.compile(r"\b127\.0\.0\.1\b(?!\.\d)")
"""The address, but not the NetId 127.0.0.1.1.1."""


@dataclass(frozen=True)
class Block:
    """A fenced block of a page; `line` is that of its opening fence."""

    language: str
    options: str
    body: str
    line: int

    @property
    def title(self) -> str:
        found = re.search(r'title="([^"]+)"', self.options)
        return found[1] if found else ""

    def commands(self) -> Iterator[tuple[str, list[str]]]:
        """Each command of a console block with the output expected of it."""
        for part in re.split(r"^\$ ", self.body, flags=re.MULTILINE)[1:]:
            command, *expected = part.splitlines()
            yield command, expected


def blocks_of(text: str) -> list[Block]:
    """The fenced blocks of a Markdown page."""
    fence = re.compile(r"^```(\w*)([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
    return [
        Block(found[1], found[2], found[3], text.count("\n", 0, found.start()) + 1)
        for found in fence.finditer(text)
    ]


def matches(expected: list[str], printed: str) -> bool:
    """True if `printed` is what the page shows, with `…` for what varies."""
    pattern = "".join(
        r"(?:[^\n]*\n)*"
        if line.strip() == "…"
        else re.escape(line.rstrip()).replace("…", "[^\n]*") + r"[ \t]*\n"
        for line in expected
    )
    if printed and not printed.endswith("\n"):
        printed += "\n"
    return re.fullmatch(pattern, printed) is not None


@dataclass
class Reader:
    """Somebody who types in what one page says."""

    page: str
    folder: Path
    host: str
    tools: str = ""
    namespace: dict[str, Any] = field(default_factory=lambda: {"__name__": "__main__"})
    background: list[subprocess.Popen[str]] = field(default_factory=list)

    @property
    def environment(self) -> dict[str, str]:
        return os.environ | {
            "PATH": os.pathsep.join(
                filter(None, (self.tools, sysconfig.get_path("scripts"), os.environ["PATH"]))
            ),
            "COLUMNS": "80",
            "NO_COLOR": "1",
            "PYTHONUNBUFFERED": "1",
            "NODE_PATH": str(NPM / "node_modules"),
            "ACHSE_CERTIFICATES": str(self.folder / "own"),
        }

    def read(self, text: str) -> None:
        """Run the page; the first block that does not do what it says fails the test."""
        blocks = blocks_of(LOOPBACK.sub(self.host, text))
        surroundings = mock.patch.dict(os.environ, {"ACHSE_HOST": self.host})
        with contextlib.chdir(self.folder), surroundings:
            try:
                for block, after in zip_longest(blocks, blocks[1:]):
                    if block.title:
                        Path(block.title).parent.mkdir(parents=True, exist_ok=True)
                        Path(block.title).write_text(block.body)
                    elif block.language == "console":
                        self.console(block)
                    elif block.language in ("python", "js"):
                        printed = (
                            self.python(block) if block.language == "python" else self.js(block)
                        )
                        if after is not None and after.language == "text":
                            source = f"the {block.language} block before"
                            self.check(after, source, after.body.splitlines(), printed)
            finally:
                for process in self.background:
                    self.end(process)
        codes = [process.returncode for process in self.background]
        assert not any(codes), f"{self.page}: a background command ended with exit code {codes}"

    def console(self, block: Block) -> None:
        for command, expected in block.commands():
            if command.endswith(" &"):
                self.check(block, command, expected, self.start(command, len(expected)))
                continue
            if command in ("fg", "kill %%"):
                process = self.background.pop()
                rest = self.end(process, wait=command == "fg")
                self.check(block, command, expected, rest)
                assert process.returncode == 0, f"{self.page}:{block.line}: {rest}"
                continue
            run = subprocess.run(
                ["bash", "-c", command],
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                timeout=PATIENCE,
            )
            self.check(block, command, expected, run.stdout)
            failed = run.returncode != 0
            assert failed == ("fails" in block.options), (
                f"{self.page}:{block.line}: {command!r} ended with exit code {run.returncode}\n"
                + run.stdout
            )

    def start(self, command: str, lines: int) -> str:
        """Start a background command; its first `lines` lines."""
        process = subprocess.Popen(
            ["bash", "-c", "exec " + command.removesuffix(" &")],
            env=self.environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.background.append(process)
        assert process.stdout is not None
        overdue = threading.Timer(PATIENCE, process.kill)
        overdue.start()
        printed = "".join(process.stdout.readline() for _ in range(lines))
        overdue.cancel()
        return printed

    def end(self, process: subprocess.Popen[str], *, wait: bool = False) -> str:
        """The rest of the output of a background command that ends now, or by itself."""
        if not wait:
            process.send_signal(signal.SIGTERM)
        try:
            return process.communicate(timeout=PATIENCE)[0]
        except subprocess.TimeoutExpired:
            process.kill()
            return process.communicate()[0]

    def python(self, block: Block) -> str:
        code = compile("\n" * block.line + block.body, self.page, "exec")
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(code, self.namespace)
        return printed.getvalue()

    def js(self, block: Block) -> str:
        command = ["node", "--input-type=module", "--eval", block.body]
        return subprocess.run(
            command, cwd=NPM, stdout=subprocess.PIPE, text=True, check=True, timeout=PATIENCE
        ).stdout

    def check(self, block: Block, source: str, expected: list[str], printed: str) -> None:
        assert matches(expected, printed), (
            f"{self.page}:{block.line}: {source} should print\n"
            + "\n".join(expected)
            + f"\nand printed\n{printed}"
        )


STAND_INS = {
    "docs/how-to/test-your-plc-code.md": {
        "TcUnit": Path(__file__).parents[1] / "data" / "unit_tests" / "standin"
    }
}
"""Folders that a reader of a page has, and what is in their place here: other people's sources."""


REAL = {"README.md", "docs/tutorial.md"}
"""Pages whose commands are started as a reader's are; those of others are forked."""


@pytest.fixture
def read_page(
    tmp_path: Path, free_host: Callable[[], str], warm_commands: WarmCommands
) -> Callable[[str, str], None]:
    """`read_page(name, text)` runs a page."""

    def read(name: str, text: str) -> None:
        for folder, stand_in in STAND_INS.get(name, {}).items():
            shutil.copytree(stand_in, tmp_path / folder)
        tools = "" if name in REAL else str(warm_commands.folder)
        Reader(name, tmp_path, free_host(), tools).read(text)

    return read


@pytest.fixture(scope="session")
def fences() -> Callable[[str], list[Block]]:
    """`fences(text)` gives the fenced blocks of a page."""
    return blocks_of


@pytest.fixture(scope="session")
def languages() -> set[str]:
    """What the opening fence of a block may say."""
    return LANGUAGES
