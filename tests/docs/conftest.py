"""Runs a page of the documentation as its reader would: pasted into one shell, in one go.

- ```` ```console ```` lines that begin with `$ ` are commands for bash; what follows up to the next
  one is the expected output, errors included. All commands of a page are one script, which one
  bash gets at once as its input: `cd` and variables last, a command that reads its input eats the
  rest, and a command is not waited for that runs in the background. `console fails` expects every
  command of the block to fail. A page ends all that it starts.
- ```` ```python ```` is executed; one namespace serves the page. ```` ```js ```` is run by Node.js.
  A ```` ```text ```` block right after either is what it prints.
- A block with `title="name"` is written to that file.

The shell and Python find what every Linux has, achse, and what the page names: in its paragraph
`You need`, or where it says `pip install`. Speed is not asked for: `achse[fast]` is always there.

In expected output `…` stands for anything within a line, alone in a line for any lines. Each page
has a folder and a loopback address of its own: `127.0.0.1` in a page means that address, and
ACHSE_HOST hands it to the commands.
"""

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sysconfig
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path

import pytest

from tests.warm_commands import is_supported
from tests.warm_python import ABSENT, BLOCK_END, serving

LANGUAGES = {"console", "python", "js", "text", "toml", "sh", "yaml", "powershell"}
"""What a fence may say; `sh`, `yaml` and `powershell` are only shown."""

NPM = Path(__file__).parents[1] / "interop" / "npm"
"""Where Node.js finds its packages."""

LOOPBACK = re.compile(r"\b127\.0\.0\.1\b(?!\.\d)")
"""The address, but not the NetId 127.0.0.1.1.1."""

EVERYWHERE = (
    "bash", "cat", "cp", "echo", "env", "grep", "head", "kill", "ls", "mkdir", "mv", "printf", "rm",
    "sed", "sleep", "sort", "tail", "test", "touch", "true", "false", "wc",
)  # fmt: skip
"""Programs of every Linux that pages call."""

NAMED: dict[str, set[str]] = {
    "[docs]": {"mkdocs", "material", "mike"},
    "[lsp]": {"lsprotocol", "pygls"},
    "[mcp]": {"jsonschema", "mcp", "mcp_types", "starlette", "uvicorn"},
    "[fmu]": {"fmpy", "numpy"},
    "gymnasium": {"gymnasium", "numpy"},
    "[metrics]": {"prometheus_client"},
    "[mqtt]": {"aiomqtt", "paho"},
    "[plot]": {"matplotlib", "numpy"},
    "[secure]": {"OpenSSL"},
    "[serial]": {"serial", "serial_asyncio_fast"},
    "[sweep]": {"dask", "distributed", "pyarrow", "yaml"},
    "[tables]": {"numpy", "pandas", "polars"},
    "[web]": {"starlette", "uvicorn", "wsproto"},
    "pyads": {"pyads"},
    "pysoem": {"pysoem"},
    "pytest": {"pytest", "_pytest", "pluggy"},
    "dev": {
        "coverage",
        "hypothesis",
        "jsonschema",
        "mpmath",
        "ruckig",
        "scipy",
        "toppra",
        "yaml",
    },
}
"""What a page may name in its `You need`, and the modules that come with it."""


NEEDS = re.compile(r"^You need: (?:.+\n)+|(?:pip install|--spec) [^\n]+", re.MULTILINE)


def names_in(text: str) -> set[str]:
    """What a page says that it needs: extras in brackets, and words."""
    extras = {f"[{extra}]" for extra in re.findall(r"\bextra `(\w+)`", text)}
    words = " ".join(NEEDS.findall(text)).replace(",", "],[")
    return extras | set(re.findall(r"\[\w+\]|[\w.-]*\w", words))


def absent_modules(text: str) -> set[str]:
    """Modules that a reader does not have who has installed what the page names."""
    names = names_in(text)
    if "dev" in names:
        return set()
    present = [modules for name, modules in NAMED.items() if name in names]
    return set[str]().union(*NAMED.values()).difference(*present)


@dataclass(frozen=True)
class Block:
    """A fenced block of a page; `line` is that of its opening fence."""

    language: str
    options: str
    body: str
    line: int

    @property
    def title(self) -> str:
        match = re.search(r'title="([^"]+)"', self.options)
        return match[1] if match else ""

    def commands(self) -> Iterator[tuple[str, list[str]]]:
        """Each command of a console block with the output expected of it."""
        for part in re.split(r"^\$ ", self.body, flags=re.MULTILINE)[1:]:
            command, *expected = part.splitlines()
            yield command, expected


def blocks_of(text: str) -> list[Block]:
    """The fenced blocks of a Markdown page."""
    fence = re.compile(r"^```(\w*)([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
    return [
        Block(match[1], match[2], match[3], text.count("\n", 0, match.start()) + 1)
        for match in fence.finditer(text)
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


class Shell:
    """One bash that gets a whole script at once.

    Before each command and each pause the script writes a mark: `MARK number exit-code`. At a pause
    it waits until we say so: a reader makes files there, or runs what is not for the shell.
    """

    MARK = "\x1e"

    def __init__(self, steps: list[str | None], environment: dict[str, str]) -> None:
        gate, self._gate = os.pipe()
        mark = f"printf '{self.MARK}%s\\n' $?"
        script = ["set -m"]
        for step in steps:
            script.append(f"read -rn 1 -u {gate}" if step is None else step)
            script.append(mark)
        script += ["jobs -pr", mark]
        self._process = subprocess.Popen(
            ["bash", "--norc", "--noprofile"],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            cwd=environment["PWD"],
            pass_fds=(gate,),
            start_new_session=True,
        )
        os.close(gate)
        assert self._process.stdin is not None
        self._process.stdin.write("".join(f"{line}\n" for line in script))
        self._process.stdin.close()

    def go_on(self) -> None:
        """End the pause."""
        os.write(self._gate, b"\n")
        self.result()

    def result(self) -> tuple[str, int]:
        """What the next command prints, and its exit code."""
        assert self._process.stdout is not None
        printed = []
        for line in self._process.stdout:
            text, mark, code = line.partition(self.MARK)
            printed.append(text)
            if mark:
                return "".join(printed), int(code)
        return "".join(printed) + "(the shell has no more commands: something read them)", 0

    def end(self) -> str:
        """Jobs that are still there after the last command."""
        return self.result()[0]

    def kill(self) -> None:
        """End the shell and all that it has started."""
        os.close(self._gate)
        for status in Path("/proc").glob("[0-9]*/stat"):
            with contextlib.suppress(OSError):
                if int(status.read_text().rpartition(")")[2].split()[3]) == self._process.pid:
                    os.kill(int(status.parent.name), signal.SIGKILL)
        self._process.kill()
        assert self._process.stdout is not None
        self._process.stdout.close()
        self._process.wait()


@dataclass
class Reader:
    """Somebody who pastes what one page says."""

    page: str
    folder: Path
    host: str
    tools: str
    blocks: list[Block] = field(default_factory=list)
    environment: dict[str, str] = field(default_factory=dict)
    _python: subprocess.Popen[str] | None = None

    def read(self, text: str) -> None:
        """Run the page; the first block that does not do what it says fails the test."""
        self.environment = self._environment(text)
        self.blocks = blocks_of(LOOPBACK.sub(self.host, text))
        steps: list[str | None] = []
        for block in self.blocks:
            if block.language == "console" and not block.title:
                steps += [command for command, _ in block.commands()]
            elif block.title or block.language in ("python", "js"):
                steps.append(None)
        shell = Shell(steps, self.environment | {"PWD": str(self.folder)}) if any(steps) else None
        try:
            for block, after in zip_longest(self.blocks, self.blocks[1:]):
                self._block(block, after, shell)
            if shell is not None:
                jobs = shell.end()
                assert jobs == "", f"{self.page} leaves running: {jobs}"
                left = self._stop_all()
                assert left == "no detached station runs\n", f"{self.page} leaves running: {left}"
                for log in self.runtime.glob("*.log"):
                    assert "Traceback" not in log.read_text(), log.read_text()
        finally:
            if shell is not None:
                shell.kill()
                self._stop_all()
            if self._python is not None:
                self._python.communicate()

    def _block(self, block: Block, after: Block | None, shell: Shell | None) -> None:
        if block.language == "console" and not block.title:
            assert shell is not None
            for command, expected in block.commands():
                printed, code = shell.result()
                self.check(block, command, expected, printed)
                assert (code != 0) == ("fails" in block.options), (
                    f"{self.page}:{block.line}: {command!r} ended with exit code {code}\n{printed}"
                )
            return
        if block.title:
            file = self.folder / block.title
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(block.body)
        elif block.language in ("python", "js"):
            printed = self.python(block) if block.language == "python" else self.js(block)
            if after is not None and after.language == "text":
                source = f"the {block.language} block before"
                self.check(after, source, after.body.splitlines(), printed)
        else:
            return
        if shell is not None:
            shell.go_on()

    def _environment(self, text: str) -> dict[str, str]:
        path = [self.tools, str(everywhere(self.folder.parent / "bin"))]
        if "Node.js" in names_in(text):
            path.append(os.path.dirname(shutil.which("node") or ""))
        if {"C", "compiler"} <= names_in(text):
            path.append(os.path.dirname(shutil.which("cc") or ""))
        return {name: os.environ[name] for name in KEPT if name in os.environ} | {
            "PATH": os.pathsep.join(path),
            "COLUMNS": "80",
            "NO_COLOR": "1",
            "PYTHONUNBUFFERED": "1",
            "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
            "PYTEST_PLUGINS": "achse.testing.plugin",
            "NODE_PATH": str(NPM / "node_modules"),
            "ACHSE_CERTIFICATES": str(self.folder / "own"),
            "ACHSE_RUNTIME_DIR": str(self.runtime),
            "ACHSE_STATE_DIR": str(self.folder / "state"),
            "ACHSE_HOST": self.host,
            ABSENT: ",".join(sorted(absent_modules(text))),
        }

    @property
    def runtime(self) -> Path:
        """The folder in which detached stations have their files."""
        return self.folder.parent / "runtime"

    def _stop_all(self) -> str:
        """Stop the detached stations of the page; without a file there was none."""
        if not self.runtime.exists() or not any(self.runtime.iterdir()):
            return "no detached station runs\n"
        return subprocess.run(
            [shutil.which("achse", path=self.environment["PATH"]) or "achse", "stop", "--all"],
            env=self.environment,
            stdout=subprocess.PIPE,
            text=True,
        ).stdout

    def python(self, block: Block) -> str:
        if self._python is None:
            self._python = subprocess.Popen(
                [f"{self.tools}/python", "--blocks"],
                cwd=self.folder,
                env=self.environment,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                text=True,
            )
        stdin, stdout = self._python.stdin, self._python.stdout
        assert stdin is not None
        assert stdout is not None
        stdin.write(json.dumps({"code": block.body, "page": self.page, "line": block.line}) + "\n")
        stdin.flush()
        printed = []
        for line in stdout:
            text, end, code = line.partition(BLOCK_END)
            printed.append(text)
            if end:
                failed = code != "0\n"
                break
        else:
            failed = True
        assert not failed, f"{self.page}:{block.line}: {''.join(printed)}"
        return "".join(printed)

    def js(self, block: Block) -> str:
        command = ["node", "--input-type=module", "--eval", block.body]
        return subprocess.run(
            command, cwd=NPM, stdout=subprocess.PIPE, text=True, check=True
        ).stdout

    def check(self, block: Block, source: str, expected: list[str], printed: str) -> None:
        assert matches(expected, printed), (
            f"{self.page}:{block.line}: {source} should print\n"
            + "\n".join(expected)
            + f"\nand printed\n{printed}"
        )


KEPT = (
    "HOME",
    "LANG",
    "LC_ALL",
    "TMPDIR",
    "USER",
    "PYTHONPATH",
    "PYTHONPYCACHEPREFIX",
    "ACHSE_CACHE_DIR",
    "XDG_CACHE_HOME",
)
"""Of our environment the reader has this."""


def everywhere(folder: Path) -> Path:
    """A folder with what every Linux has."""
    if not folder.exists():
        folder.mkdir()
        for name in EVERYWHERE:
            (folder / name).symlink_to(shutil.which(name) or name)
    return folder


STUBS = {
    "docs/how-to/test-your-plc-code.md": {
        "TcUnit": Path(__file__).parents[1] / "data" / "unit_tests" / "tcunit_stub"
    }
}
"""Folders that a reader of a page has, and what is in their place here: other people's sources."""


REAL = {"README.md"}
"""Pages whose `achse` is started as a reader's is; that of others is forked."""


@pytest.fixture(scope="session")
def prewarmed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with a quick `achse` and a quick `python`."""
    if not is_supported():
        pytest.skip("this system cannot hand files to another process")
    with serving(tmp_path_factory.mktemp("tools")) as folder:
        yield folder


@pytest.fixture
def read_page(
    tmp_path: Path, free_host: Callable[[], str], prewarmed: Path
) -> Callable[[str, str], None]:
    """`read_page(name, text)` runs a page."""

    def read(name: str, text: str) -> None:
        folder = tmp_path / "page"
        folder.mkdir(exist_ok=True)
        for source, stub in STUBS.get(name, {}).items():
            shutil.copytree(stub, folder / source)
        tools = prewarmed
        if name in REAL:
            tools = tmp_path / "tools"
            tools.mkdir(exist_ok=True)
            (tools / "achse").symlink_to(Path(sysconfig.get_path("scripts")) / "achse")
            (tools / "python").symlink_to(prewarmed / "python")
        Reader(name, folder, free_host(), str(tools)).read(text)

    return read


@pytest.fixture(scope="session")
def fences() -> Callable[[str], list[Block]]:
    """`fences(text)` gives the fenced blocks of a page."""
    return blocks_of


@pytest.fixture(scope="session")
def languages() -> set[str]:
    """What the opening fence of a block may say."""
    return LANGUAGES


@pytest.fixture(scope="session")
def optional_modules() -> set[str]:
    """What a page may name in its `You need`."""
    return set(NAMED)
