"""The process of a unit: it answers the shim until the channel ends.

A saved state is a fork of the process that waits at a channel of its own: nothing is copied but the
pages that change. To restore it, it forks again, and the new process goes on at a new channel. The
process that the shim has started stays until all others have ended, and collects them.
"""

import ctypes
import gc
import logging
import os
import signal
import socket
import struct
import sys
import traceback
from collections.abc import Callable
from pathlib import Path

from achse.ams import DeviceError
from achse.fmu.errors import ExportError
from achse.fmu.model import Model, ModelError, UnitFile
from achse.fmu.protocol import VERSION, Reply, Request, UnitMessage, receive, send
from achse.station import ConfigError

_NUMBER = struct.Struct("<Q")
_DOUBLE = struct.Struct("<d")
_COUNTS = struct.Struct("<3I")

_SET_CHILD_SUBREAPER = 36
"""Of prctl (linux/prctl.h): processes whose parent has ended become children of this one."""

_OK, _WARNING, _ERROR = 0, 1, 3
"""Status of a log line, as FMI numbers it."""

_MOST_LINES = 1000

_REFUSALS = (ModelError, ConfigError, ExportError, DeviceError, OSError, ValueError)
"""Failures with a sentence; others bring a traceback."""


class _Lines(logging.Handler):
    """Lines of the log that the shim has not got yet."""

    def __init__(self) -> None:
        super().__init__(logging.INFO)
        self.lines: list[bytes] = []

    def emit(self, record: logging.LogRecord) -> None:
        if len(self.lines) < _MOST_LINES:
            status = _OK if record.levelno < logging.WARNING else _WARNING
            self.lines.append(bytes([status]) + self.format(record).encode("utf-8", "replace"))


class UnitServer:
    """Answers at a channel; `model` is there after the first request."""

    def __init__(self, channel: socket.socket) -> None:
        self.channel = channel
        self.log = _Lines()
        self._model: Model | None = None
        self._resources = Path()
        self._answers: dict[int, Callable[[bytes], None]] = {
            Request.OPEN: self._open,
            Request.STEP: self._step,
            Request.REFRESH: self._refresh,
            Request.SAVE: self._save,
            Request.UNPACK: self._unpack,
        }

    @property
    def model(self) -> Model:
        if self._model is None:
            raise ModelError("expected the request to open first")
        return self._model

    def serve(self) -> None:
        """Answer requests until the channel ends."""
        while (message := receive(self.channel)) is not None:
            self._answer(message)

    def _answer(self, message: UnitMessage) -> None:
        try:
            answer = self._answers.get(message.kind)
            if answer is None:
                raise ModelError(f"request {message.kind}: unknown here")
            answer(message.content)
        except _REFUSALS as failure:
            self._reply(Reply.FAILED, str(failure).encode("utf-8", "replace"))
        except Exception:
            self._reply(Reply.FAILED, traceback.format_exc().encode("utf-8", "replace"))

    def _reply(self, kind: Reply, content: bytes = b"", *descriptors: int) -> None:
        if self.log.lines:
            for line in self.log.lines:
                send(self.channel, Reply.LOG, line)
            self.log.lines.clear()
        send(self.channel, kind, content, descriptors)

    def _open(self, content: bytes) -> None:
        (version,) = struct.unpack_from("<I", content)
        if version != VERSION:
            raise ModelError(
                f"protocol {version}: expected {VERSION}; export the unit with this achse again"
            )
        resources, token, _ = content[4:].split(b"\0")
        self._resources = Path(os.fsdecode(resources))
        unit = UnitFile.read(self._resources)
        if token.decode("utf-8", "replace") != unit.token:
            raise ModelError(f"instantiation token: expected {unit.token}, got {token!r:.80}")
        model = self._model = Model(self._resources, unit)
        gc.collect()
        gc.freeze()  # pages that forked processes share
        counts = _COUNTS.pack(len(model.rows), model.input_size, len(model.image))
        self._reply(Reply.DONE, counts + b"".join(model.rows) + model.image)

    def _step(self, content: bytes) -> None:
        model = self.model
        model.apply(content[_NUMBER.size :])
        model.go_to(_NUMBER.unpack_from(content)[0])
        self._reply(Reply.DONE, bytes(model.image))

    def _refresh(self, content: bytes) -> None:
        model = self.model
        model.apply(content[_NUMBER.size :])
        model.refresh()
        if _NUMBER.unpack_from(content)[0] < len(model.rows):
            model.show_digest()
        self._reply(Reply.DONE, bytes(model.image))

    def _save(self, content: bytes) -> None:
        (elapsed,) = _DOUBLE.unpack(content)
        _ = self.model
        ours, theirs = socket.socketpair()
        if os.fork() == 0:
            _run_to_end(lambda: self._park(ours, theirs, elapsed))
        ours.close()
        with theirs:
            self._reply(Reply.DONE, b"", theirs.fileno())

    def _unpack(self, content: bytes) -> None:
        unit, resources = self.model.unit, self._resources
        ours, theirs = socket.socketpair()
        if os.fork() == 0:

            def replay() -> None:
                try:
                    self._model, elapsed = Model.unpack(resources, unit, content)
                except _REFUSALS as failure:
                    send(ours, Reply.FAILED, str(failure).encode("utf-8", "replace"))
                    return
                send(ours, Reply.DONE)
                self.log.lines.clear()
                self._park(ours, theirs, elapsed)

            _run_to_end(replay)
        ours.close()
        with theirs:
            outcome = receive(theirs)
            if outcome is None:
                raise ModelError("state: the process that replays it has ended")
            if outcome.kind == Reply.FAILED:
                raise ModelError(outcome.content.decode("utf-8", "replace"))
            self._reply(Reply.DONE, b"", theirs.fileno())

    def _park(self, ours: socket.socket, theirs: socket.socket, elapsed: float) -> None:
        """Wait as a saved state until the channel ends; return in the process that continues."""
        self.channel.close()
        theirs.close()
        self.channel = ours
        while (message := receive(ours)) is not None:
            if message.kind == Request.PACK:
                self._reply(Reply.DONE, self.model.pack(elapsed))
            elif message.kind == Request.RESTORE:
                next_ours, next_theirs = socket.socketpair()
                if os.fork() == 0:
                    ours.close()
                    next_theirs.close()
                    self.channel = next_ours
                    self.serve()
                    return
                next_ours.close()
                with next_theirs:
                    image = _DOUBLE.pack(elapsed) + self.model.image
                    self._reply(Reply.DONE, image, next_theirs.fileno())
            else:
                self._reply(Reply.FAILED, b"a saved state can be restored or serialised only")


def _run_to_end(run: Callable[[], None]) -> None:
    """Run in a forked process, and end it."""
    code = 1
    try:
        run()
        code = 0
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stderr.flush()
        os._exit(code)


def _collect_children() -> None:
    """Let ended processes disappear, and take those whose parent has ended as children."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def main() -> None:
    """Serve the shim whose channel is the standard input."""
    channel = socket.socket(fileno=os.dup(0))
    with open(os.devnull, "rb") as nothing:
        os.dup2(nothing.fileno(), 0)
    server = UnitServer(channel)
    logging.getLogger("achse").addHandler(server.log)
    logging.getLogger("achse").setLevel(logging.INFO)
    _collect_children()
    try:
        server.serve()
    except ConnectionError:
        return  # the importer has ended
    channel.close()
    try:
        os.wait()  # with SIGCHLD ignored: until the last child has ended
    except ChildProcessError:
        return
