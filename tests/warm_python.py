"""The command `python` without its start, beside a quick `achse`: a warm process forks per call.

`serving(folder)` makes `folder/achse` and `folder/python`, with the server of
tests/warm_commands.py. Besides what that does: ACHSE_TESTS_ABSENT names modules that a command does
not find, and what a command starts with this Python is forked too, as the station of `achse run
--detach`.

`python --blocks` executes blocks of a page in one namespace: each line of its input is a block in
JSON, and each is answered by what it prints, and by a line that says how it ended.
"""

import atexit
import contextlib
import gc
import json
import os
import runpy
import signal
import subprocess
import sys
import threading
import traceback
import weakref
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from _pytest.config import default_plugins

import achse.cli
from tests import unneeded_modules
from tests.warm_commands import Server, end_as, load, standard_streams

__all__ = ["ABSENT", "BLOCK_END", "SHARED", "serving", "starting"]

SHARED = "ACHSE_TESTS_PYTHON"
"""Environment variable: folder of a server that all workers of a run share."""

ABSENT = "ACHSE_TESTS_ABSENT"
"""Environment variable: modules that a command does not find, with commas between."""

BLOCK_END = "\x1e"
"""Begins the line after what a block prints; `0` or `1` follows, as an exit code."""

PYTHON = "-python"
"""First word of a call that is not for `achse`."""

STUB = """#!{python} -IS
import _signal, _socket, os, sys
from _json import encode_basestring_ascii as quoted
line = _socket.socket(_socket.AF_UNIX)
line.connect({path!r})
words = [{tool!r}] * ({tool!r} != "achse") + sys.argv[1:]
environment = ", ".join(quoted(key) + ": " + quoted(value) for key, value in os.environ.items())
call = "[[%s], %s, {{%s}}, false]" % (
    ", ".join(map(quoted, words)), quoted(os.getcwd()), environment
)
call = call.encode()
streams = b"".join(number.to_bytes(4, sys.byteorder) for number in (0, 1, 2))
ancillary = [(_socket.SOL_SOCKET, _socket.SCM_RIGHTS, streams)]
line.sendmsg([len(call).to_bytes(4, "big")], ancillary)
line.sendall(call)
def answer():
    text = b""
    while text[-1:] != b"\\n":
        part = line.recv(1)
        if not part:
            return 1
        text += part
    return int(text.split()[0])
pid = answer()
def hand_on(number, frame):
    try:
        os.kill(pid, number)
    except ProcessLookupError:
        pass
for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGUSR1"):
    number = getattr(_signal, name)
    if _signal.getsignal(number) != _signal.SIG_IGN:
        _signal.signal(number, hand_on)
line.sendall(b"go")
code = answer()
if code < 0:
    _signal.signal(-code, _signal.SIG_DFL)
    os.kill(os.getpid(), -code)
os._exit(code)
"""
"""As that of tests/warm_commands.py, with the least imports: a page calls some ten commands."""

ROOT = Path(__file__).parents[1]


@contextlib.contextmanager
def serving(folder: Path) -> Iterator[Path]:
    """A folder whose `achse` and `python` are quick, for PATH: that of the run, or this one."""
    if shared := os.environ.get(SHARED):
        yield Path(shared)
        return
    with starting(folder) as ready:
        ready()
        yield folder


@contextlib.contextmanager
def starting(folder: Path) -> Iterator[Callable[[], None]]:
    """Start the server; the function that this yields returns when it serves."""
    path = folder / "line"
    program = [sys.executable, "-m", "tests.warm_python", str(path)]
    with subprocess.Popen(
        program, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as server:

        def ready() -> None:
            assert server.stdout is not None
            assert server.stdout.readline() == b"ready\n"
            for name, tool in (("achse", "achse"), ("python", PYTHON), ("python3", PYTHON)):
                stub = folder / name
                text = STUB.format(python=sys.executable, path=str(path), tool=tool)
                stub.write_text(text, encoding="utf-8")
                stub.chmod(0o755)

        try:
            yield ready
        finally:
            assert server.stdin is not None
            server.stdin.close()  # it ends with us, however we end


class Absent:
    """An importer that finds nothing: these modules are not installed, as it seems."""

    def __init__(self, names: set[str]) -> None:
        self.names = names

    def find_spec(self, name: str, path: object = None, target: object = None) -> None:
        if name.partition(".")[0] in self.names:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


def forget(names: set[str]) -> None:
    """From now on these modules are not found."""
    for name in [each for each in sys.modules if each.partition(".")[0] in names]:
        del sys.modules[name]
    sys.meta_path.insert(0, Absent(names))


class ForkingPopen(subprocess.Popen[Any]):
    """`Popen` that forks for a command of this Python, and starts any other command.

    So a station that a forked program starts is its own child, with the process id that it sees. A
    program with threads cannot fork.
    """

    def _execute_child(self, command: Any, *rest: Any) -> None:
        passed, shell, start_new_session = rest[3], rest[8], rest[20]
        cwd, env, pipes = rest[4], rest[5], rest[9:15]
        words = [] if isinstance(command, str) else [os.fspath(word) for word in command]
        named = words[1:2] in (["-m"], ["-c"]) or (words[1:2] != [] and words[1][:1] != "-")
        mine = words[:1] == [sys.executable] and named and not shell and not passed
        if not mine or threading.active_count() > 1:
            super()._execute_child(command, *rest)  # type: ignore[misc]
            return
        self.pid = os.fork()
        if self.pid:
            self._child_created = True
            self._close_pipe_fds(*pipes)  # type: ignore[attr-defined]
            return
        gc.freeze()  # what the program has open is not to be closed: numbers are used again
        atexit._clear()
        weakref.finalize._registry.clear()  # type: ignore[attr-defined]
        weakref.finalize._registered_with_atexit = False  # type: ignore[attr-defined]
        if start_new_session:
            os.setsid()
        for number, pipe in enumerate((pipes[0], pipes[3], pipes[5])):
            os.dup2(number if pipe == -1 else pipe, number)
        os.closerange(3, 1 << 10)
        os.chdir(cwd or ".")
        if env is not None:
            os.environ.clear()
            os.environ.update({os.fsdecode(k): os.fsdecode(v) for k, v in env.items()})
        standard_streams()
        end_as(lambda: python(words[1:]))


def restore() -> None:
    """Signals as a new process has them."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)


def python(arguments: list[str]) -> None:
    """Do what `python` does with these arguments."""
    restore()
    sys.path.insert(0, "")
    flag = arguments[0]
    if flag == "--blocks":
        blocks()
    elif arguments[:2] == ["-m", "achse"]:
        sys.argv = arguments[1:]
        achse.cli.main()
    elif flag == "-m":
        sys.argv = arguments[1:]
        runpy.run_module(arguments[1], run_name="__main__", alter_sys=True)
    elif flag == "-c":
        sys.argv = ["-c", *arguments[2:]]
        exec(compile(arguments[1], "<string>", "exec"), main_namespace())
    else:
        sys.argv = arguments
        sys.path[0] = str(Path(flag).parent.resolve())
        runpy.run_path(flag, run_name="__main__")


def main_namespace() -> dict[str, Any]:
    module = sys.modules["__main__"] = ModuleType("__main__")
    return vars(module)


def blocks() -> None:
    """Execute blocks in one namespace; one that fails prints its traceback, and the last word."""
    namespace = main_namespace()
    for line in sys.stdin:
        block = json.loads(line)
        failed = False
        try:
            code = "\n" * block["line"] + block["code"]
            exec(compile(code, block["page"], "exec"), namespace)
        except BaseException:
            failed = True
            traceback.print_exc(file=sys.stdout)
        sys.stdout.write(f"{BLOCK_END}{failed:d}\n")
        sys.stdout.flush()


WARM = (
    *(
        "achse.cli.axes.move",
        "achse.cli.axes.nc",
        "achse.cli.start.run",
        "achse.client.nc.blocking",
    ),
    *("achse.monitor.capture", "achse.monitor.symbols", "achse.scope"),
    *("concurrent.futures.thread", "encodings.idna", "rich.progress", "unittest.mock"),
    *("achse.cli.test.check", "achse.cli.test.swarm", "achse.swarm.campaign", "achse.testing"),
    *("achse.lsp.server", "achse.mcp.server", "jsonschema", "mcp"),
    *("pytest", *(f"_pytest.{name}" for name in default_plugins)),
)
"""Modules that commands of the pages load, besides what `load` does."""


def main(path: str) -> None:
    """Serve calls; each child does what it is asked for."""
    unneeded_modules.leave_out()
    achse_command = load()
    for name in WARM:
        import_module(name)
    assert threading.active_count() == 1, "a process with threads cannot fork"
    while str(ROOT) in sys.path:
        sys.path.remove(str(ROOT))
    gc.collect()
    gc.freeze()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    server = Server(path)
    os.write(1, b"ready\n")
    server.serve()
    standard_streams()
    main_namespace()
    if absent := os.environ.get(ABSENT):
        forget(set(absent.split(",")))
    subprocess.Popen = ForkingPopen  # type: ignore[misc]
    if sys.argv[1:2] == [PYTHON]:
        end_as(lambda: python(sys.argv[2:]))
    else:
        end_as(achse_command)


if __name__ == "__main__":
    main(sys.argv[1])
