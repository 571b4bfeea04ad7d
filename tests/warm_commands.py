"""Commands without their start: a process that has loaded achse forks for each call.

`with warm_commands(folder) as commands:` offers the forks twice. `commands.folder` holds a quick
`achse` for PATH; it passes its streams, folder, network namespace, environment, arguments and
signals on, and ends as the command ends. `commands.popen(...)` and `commands.run(...)` return what
`subprocess` returns, without a stub process. What differs from the real command is the parent of
the working process: the server. So it must prove neither its start nor who gets the signals of a
terminal.

Where a system cannot fork so, both start real processes.
"""

import atexit
import contextlib
import ctypes
import gc
import io
import json
import os
import runpy
import select
import selectors
import signal
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

__all__ = ["EXECUTABLE", "PIPES", "WarmCommands", "is_supported", "warm_commands"]

PIPES: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
"""Options for commands whose output is read."""

SHARED = "ACHSE_TESTS_COMMANDS"
"""Environment variable: folder of a server that all workers of a run share."""

EXECUTABLE = "ACHSE_TESTS_EXECUTABLE"
"""Environment variable: interpreter with which a command starts others, in place of this one."""

CPU: list[float] = []
"""CPU seconds of the commands that have ended: they are no children of this process."""

STUB = """#!{python} -IS
import array, json, os, signal, socket, sys
{others}
line = socket.socket(socket.AF_UNIX)
line.connect({path!r})
call = json.dumps([sys.argv[1:], os.getcwd(), dict(os.environ), False]).encode()
streams = array.array("i", (0, 1, 2))
line.sendmsg([len(call).to_bytes(4, "big")], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, streams)])
line.sendall(call)
answer = line.makefile("r")
pid = int(answer.readline())
def hand_on(number, frame):
    try:
        os.kill(pid, number)
    except ProcessLookupError:
        pass
for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGUSR1):
    if signal.getsignal(number) is not signal.SIG_IGN:
        signal.signal(number, hand_on)
line.sendall(b"go")
code = int((answer.readline() or "1").split()[0])
if code < 0:
    signal.signal(-code, signal.SIG_DFL)
    os.kill(os.getpid(), -code)
os._exit(code)
"""


INTERPRETER = """
if sys.argv[1:2] != ["-m"] or sys.argv[2].partition(".")[0] != "achse":
    os.execv({python!r}, [{python!r}, *sys.argv[1:]])
if sys.argv[2] == "achse":
    del sys.argv[1:3]
"""
"""What makes the stub a Python that forks for `-m achse` and for modules of it."""


def is_supported() -> bool:
    """Return true if this system has process file descriptors and can pass files on."""
    return hasattr(os, "pidfd_open") and hasattr(socket, "recv_fds")


class ForkedCommand(subprocess.Popen[Any]):
    """A command that the server at `address` forks: `Popen` in all but the start and the wait."""

    def __init__(self, address: str, words: tuple[str, ...], **options: Any) -> None:
        self.address = address
        self.line = socket.socket(socket.AF_UNIX)
        super().__init__(words, **options)

    def _execute_child(self, words: tuple[str, ...], *rest: Any) -> None:
        cwd, env, (pipes, start_new_session) = rest[4], rest[5], (rest[9:15], rest[20])
        ends = enumerate((pipes[0], pipes[3], pipes[5]))
        streams = [number if pipe == -1 else pipe for number, pipe in ends]
        environment = dict(os.environ if env is None else env)
        folder = os.fspath(os.getcwd() if cwd is None else cwd)
        call = json.dumps([words, folder, environment, start_new_session]).encode()
        try:
            self.line.connect(self.address)
            socket.send_fds(self.line, [len(call).to_bytes(4, "big")], streams)
            self.line.sendall(call)
            self.answer = self.line.makefile("r")
            self.pid = int(self.answer.readline())
            self._child_created = True
            self.line.sendall(b"go")
        finally:
            self._close_pipe_fds(*pipes)  # type: ignore[attr-defined]

    def _internal_poll(self, *_: Any, **__: Any) -> int | None:
        return self._wait(0.0)

    def _wait(self, timeout: float | None) -> int | None:
        with self._waitpid_lock:  # type: ignore[attr-defined]
            limit = None if timeout is None else max(timeout, 0.0)
            if self.returncode is None and select.select([self.line], [], [], limit)[0]:
                code, _, seconds = self.answer.readline().partition(" ")
                self.returncode = int(code or -signal.SIGKILL)
                CPU.append(float(seconds or 0.0))
                self.answer.close()
                self.line.close()
        if self.returncode is None and timeout:
            raise subprocess.TimeoutExpired(self.args, timeout)
        return self.returncode


@dataclass(frozen=True)
class WarmCommands:
    """Starts `achse` with the words given."""

    folder: Path
    """Holds the `achse` of this object; it belongs first on PATH."""

    python: Path = Path(sys.executable)
    """Interpreter that is quick at `-m achse` and `-m achse.…`, for programs that start one."""

    address: str = ""
    """Socket of the server, if there is one."""

    def popen(self, *words: str, real: bool = False, **options: Any) -> "subprocess.Popen[str]":
        """Start `achse WORDS`; options and result are those of `subprocess.Popen`, in text.

        Those are cwd, env, stdin, stdout, stderr, bufsize, start_new_session. `real` starts a new
        interpreter.
        """
        options.setdefault("text", True)
        if self.address and not real:
            return ForkedCommand(self.address, words, **options)
        return subprocess.Popen([sys.executable, "-m", "achse", *words], **options)

    def run(
        self, *words: str, input: str | None = None, **options: Any
    ) -> "subprocess.CompletedProcess[str]":
        """Return the ended command with its output; options as for `popen`."""
        options.setdefault("stdin", subprocess.DEVNULL if input is None else subprocess.PIPE)
        options = PIPES | options
        with self.popen(*words, **options) as process:
            try:
                output, errors = process.communicate(input)
            except BaseException:
                process.kill()
                raise
        return subprocess.CompletedProcess(words, process.returncode, output, errors)

    def path(self, environment: Mapping[str, str] = os.environ) -> str:
        """Return the PATH of the environment with the folder first."""
        return os.pathsep.join((str(self.folder), environment.get("PATH", os.defpath)))


@contextlib.contextmanager
def warm_commands(folder: Path) -> Iterator[WarmCommands]:
    """Run the server, with its files in the folder; or use the one that is shared."""
    if not is_supported():
        yield WarmCommands(Path(sys.executable).parent)
        return
    if shared := os.environ.get(SHARED):
        folder = Path(shared)
        yield WarmCommands(folder, folder / "interpreter" / "python", str(folder / "line"))
        return
    path = folder / "line"
    program = [sys.executable, "-P", __file__, str(path)]
    with subprocess.Popen(program, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as server:
        try:
            assert server.stdout is not None
            assert server.stdout.readline() == b"ready\n"
            stubs = folder / "achse", folder / "interpreter" / "python"
            others = "", INTERPRETER.format(python=sys.executable)
            for stub, text in zip(stubs, others, strict=True):
                stub.parent.mkdir(exist_ok=True)
                text = STUB.format(python=sys.executable, path=str(path), others=text)
                stub.write_text(text, encoding="utf-8")
                stub.chmod(0o755)
            yield WarmCommands(folder, stubs[1], str(path))
        finally:
            assert server.stdin is not None
            server.stdin.close()  # it ends with us, however we end


class Server:
    """Forks for each call; in the child, `serve` returns and the command is up to the caller."""

    def __init__(self, path: str) -> None:
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(path)
        self.listener.listen(100)
        self.selector = selectors.DefaultSelector()
        self.selector.register(self.listener, selectors.EVENT_READ, self.call)
        self.selector.register(0, selectors.EVENT_READ, self.leave)
        self.is_child = False

    def serve(self) -> None:
        while not self.is_child:
            for key, _ in self.selector.select():
                key.data(key.fileobj)
                if self.is_child:
                    return

    def leave(self, _: Any) -> None:
        os._exit(0)

    def call(self, _: Any) -> None:
        line, _address = self.listener.accept()
        streams: list[int] = []
        size, text = 1, b""
        with contextlib.suppress(ConnectionError):  # the caller is gone
            head, streams, _flags, _sender = socket.recv_fds(line, 4, 3)
            size = int.from_bytes(head, "big")
            while len(text) < size:
                text += (part := line.recv(1 << 16))
                if not part:  # the caller is gone
                    break
        pid = os.fork() if streams and len(text) == size else None
        if pid == 0:
            self.is_child = True
            join_network_of(line)
            self.become_command(line, streams, *json.loads(text))
            return
        for stream in streams:
            os.close(stream)
        if pid is None:
            line.close()
        else:
            self.watch(line, pid)

    def become_command(
        self,
        line: socket.socket,
        streams: list[int],
        words: list[str],
        folder: str,
        environment: dict[str, str],
        new_session: bool,
    ) -> None:
        """Close what belongs to the server, and be as a new process of the caller."""
        others = [key.fileobj for key in self.selector.get_map().values() if key.fileobj != 0]
        self.selector.close()
        for other in others:
            if isinstance(other, int):
                os.close(other)
            elif isinstance(other, socket.socket):
                other.close()
        for number, stream in enumerate(streams):
            os.dup2(stream, number)
            os.close(stream)
        if new_session:
            os.setsid()
        signal.signal(signal.SIGINT, lambda *_: os._exit(130))  # as `python -m achse` at first
        line.sendall(b"%d\n" % os.getpid())
        line.recv(2)  # its signals come to us from now on
        line.close()
        os.chdir(folder)
        os.environ.clear()
        os.environ.update(environment)
        sys.argv = ["achse", *words]
        sys.executable = environment.get(EXECUTABLE, sys.executable)

    def watch(self, line: socket.socket, pid: int) -> None:
        """Report the end of the process; kill it when its caller is gone."""
        ended = os.pidfd_open(pid)

        def end(_: Any) -> None:
            self.selector.unregister(ended)
            os.close(ended)
            _, status, usage = os.wait4(pid, 0)
            code = os.waitstatus_to_exitcode(status)
            with contextlib.suppress(KeyError):
                self.selector.unregister(line)
            with contextlib.suppress(OSError):
                line.sendall(b"%d %.3f\n" % (code, usage.ru_utime + usage.ru_stime))
            line.close()

        def gone(_: Any) -> None:
            if line.fileno() < 0:  # `end` came first, of the same look
                return
            try:
                left = line.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT)
            except BlockingIOError:  # the child has read what was there
                return
            except ConnectionError:  # killed before it read what the child had sent
                left = b""
            if left == b"":  # killed
                self.selector.unregister(line)
                os.kill(pid, signal.SIGKILL)

        self.selector.register(ended, selectors.EVENT_READ, end)
        self.selector.register(line, selectors.EVENT_READ, gone)


PEER = struct.Struct("iII")
"""What the kernel says of the other end: its process, user and group."""

NAMESPACES = {"user": 0x1000_0000, "net": 0x4000_0000}
"""Kinds of namespaces that a caller may have of its own, in the order of joining, by CLONE_NEW…."""


def join_network_of(line: socket.socket) -> None:
    """Enter the network namespace of the process at the other end."""
    peer = line.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, PEER.size)
    theirs = Path("/proc", str(PEER.unpack(peer)[0]), "ns")
    for name, kind in NAMESPACES.items():
        if (theirs / name).readlink() == Path("/proc/self/ns", name).readlink():
            continue
        with (theirs / name).open() as namespace:
            library = ctypes.CDLL(None, use_errno=True)
            if library.setns(namespace.fileno(), kind):
                raise OSError(ctypes.get_errno(), f"setns of a {name} namespace")


def standard_streams() -> None:
    """As a new interpreter makes them."""
    at_once = bool(os.environ.get("PYTHONUNBUFFERED"))
    encoding, _, errors_wanted = os.environ.get("PYTHONIOENCODING", "").partition(":")
    sys.stdin = open(0, encoding=encoding or None, closefd=False)  # noqa: SIM115
    for name, number, errors in (
        ("stdout", 1, errors_wanted or "strict"),
        ("stderr", 2, "backslashreplace"),
    ):
        raw: Any = io.FileIO(number, "w", closefd=False)
        buffered = raw if at_once else io.BufferedWriter(raw)
        lines = number == 2 or os.isatty(number)
        stream = io.TextIOWrapper(
            buffered, encoding or None, errors, line_buffering=lines, write_through=at_once
        )
        setattr(sys, name, stream)
        setattr(sys, f"__{name}__", stream)


def end_as(command: Callable[[], object]) -> None:
    """Run the command and end the process, without freeing what it has loaded."""
    code: object = 0
    try:
        command()
    except SystemExit as end:
        code = end.code
    except BaseException:
        sys.excepthook(*sys.exc_info())
        code = 1
    threading._shutdown()  # type: ignore[attr-defined]  # waits as Python does
    atexit._run_exitfuncs()
    if isinstance(code, str):
        print(code, file=sys.stderr)
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except OSError:
        code = 120  # as Python itself
    os._exit(code if isinstance(code, int) else 0 if code is None else 1)


LOADED = (
    *("achse.client.blocking", "achse.cli.start.run", "achse.cli.test.projects"),
    *("achse.cli.fieldbus.bus_serve", "achse.cli.fieldbus.drive", "achse.cli.fieldbus.served"),
    *("achse.cli.start.detached", "achse.cli.start.web", "achse.cli.target"),
    *("achse.devices.debug_service", "achse.devices.slave_service", "achse.drive"),
    *("achse.faults.drives", "achse.fmu.server", "achse.plc.bodies", "achse.plc.machine.build"),
    *("achse.st.project", "achse.station.building.drive_buses", "achse.station.building.terminals"),
    *("achse.station.slaves.control_port", "achse.tcunit", "achse.web.calls"),
    *("achse.web.listening", "achse.web.server", "llvmlite.binding", "uvloop"),
)
"""Modules that commands import when they need them."""


def load() -> Callable[[], None]:
    """Return the command, with all loaded that it may need."""
    import typer.main

    import achse.cli
    from achse.cli.app import app
    from achse.st.declared.standard import standard_libraries
    from achse.station import Station

    tree = typer.main.get_command(app)
    achse.cli._commands = lambda _: tree  # type: ignore[assignment,return-value]
    for name in LOADED:
        with contextlib.suppress(ImportError):
            import_module(name)
    nothing = io.StringIO()
    with contextlib.redirect_stdout(nothing), contextlib.redirect_stderr(nothing):
        for words in (["axis", "show", "--tcp-port", "1"], ["axis", "--help"], ["check", "none"]):
            with contextlib.suppress(SystemExit):
                tree.main(words, prog_name="achse")
    Station.demo().advance(0.01)
    standard_libraries()  # else each command parses what its programs name
    assert threading.active_count() == 1, threading.enumerate()
    return achse.cli.main


def run_module() -> None:
    """Be `python -m MODULE`."""
    del sys.argv[:2]
    runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    command = load()
    gc.collect()
    gc.freeze()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    server = Server(sys.argv[1])
    os.write(1, b"ready\n")
    server.serve()
    standard_streams()
    end_as(run_module if sys.argv[1:2] == ["-m"] else command)
