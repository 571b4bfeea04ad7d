"""The command `achse` without its start: a process that has loaded it forks for each call.

`serving(folder)` makes `folder/achse`. It hands its own streams, folder, environment and arguments
over, passes signals on, and ends as the command ends. What differs from the real command is the
process that does the work, which is a child of the server.
"""

import contextlib
import gc
import io
import json
import os
import selectors
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

__all__ = ["possible", "serving"]

STUB = """#!{python} -IS
import array, json, os, signal, socket, sys
line = socket.socket(socket.AF_UNIX)
line.connect({path!r})
call = json.dumps([sys.argv[1:], os.getcwd(), dict(os.environ)]).encode()
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
code = int(answer.readline() or 1)
if code < 0:
    signal.signal(-code, signal.SIG_DFL)
    os.kill(os.getpid(), -code)
os._exit(code)
"""


def possible() -> bool:
    """Whether this system has what it takes."""
    return hasattr(os, "pidfd_open") and hasattr(socket, "recv_fds")


@contextlib.contextmanager
def serving(folder: Path) -> Iterator[Path]:
    """A folder whose `achse` is quick, for PATH."""
    path = folder / "line"
    program = [sys.executable, __file__, str(path)]
    with subprocess.Popen(program, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as server:
        try:
            assert server.stdout is not None
            assert server.stdout.readline() == b"ready\n"
            stub = folder / "achse"
            stub.write_text(STUB.format(python=sys.executable, path=str(path)), encoding="utf-8")
            stub.chmod(0o755)
            yield folder
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
        head, streams, _flags, _sender = socket.recv_fds(line, 4, 3)
        text = b""
        while len(text) < int.from_bytes(head, "big"):
            text += line.recv(1 << 16)
        arguments, folder, environment = json.loads(text)
        pid = os.fork()
        if not pid:
            self.is_child = True
            self.listener.close()
            self.selector.close()
            for number, stream in enumerate(streams):
                os.dup2(stream, number)
                os.close(stream)
            line.sendall(b"%d\n" % os.getpid())
            line.recv(2)  # its signals come to us from now on
            line.close()
            os.chdir(folder)
            os.environ.clear()
            os.environ.update(environment)
            sys.argv = ["achse", *arguments]
            return
        for stream in streams:
            os.close(stream)
        ended = os.pidfd_open(pid)

        def end(_: Any) -> None:
            self.selector.unregister(ended)
            os.close(ended)
            code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
            with contextlib.suppress(KeyError):
                self.selector.unregister(line)
            with contextlib.suppress(OSError):
                line.sendall(b"%d\n" % code)
            line.close()

        def gone(_: Any) -> None:
            with contextlib.suppress(BlockingIOError):  # the child has read what was there
                if line.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT) == b"":  # killed
                    self.selector.unregister(line)
                    os.kill(pid, signal.SIGKILL)

        self.selector.register(ended, selectors.EVENT_READ, end)
        self.selector.register(line, selectors.EVENT_READ, gone)


def standard_streams() -> None:
    """As a new interpreter makes them."""
    at_once = bool(os.environ.get("PYTHONUNBUFFERED"))
    sys.stdin = open(0, closefd=False)  # noqa: SIM115
    for name, number, errors in (("stdout", 1, "strict"), ("stderr", 2, "backslashreplace")):
        raw: Any = io.FileIO(number, "w", closefd=False)
        buffered = raw if at_once else io.BufferedWriter(raw)
        lines = number == 2 or os.isatty(number)
        stream = io.TextIOWrapper(
            buffered, errors=errors, line_buffering=lines, write_through=at_once
        )
        setattr(sys, name, stream)
        setattr(sys, f"__{name}__", stream)


if __name__ == "__main__":
    import achse.cli

    for name in ("achse.cli.app", "achse.client.blocking", "achse.station", "llvmlite.binding"):
        with contextlib.suppress(ImportError):
            import_module(name)
    gc.collect()
    gc.freeze()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    server = Server(sys.argv[1])
    os.write(1, b"ready\n")
    server.serve()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    standard_streams()
    achse.cli.main()
