"""Start process (group 500 of the system service): programs of the computer that the user allows.

Without allowed programs every request is refused with 0x701. No shell reads the command line.

Source: public clients of the vendor for the layout; the refusals are our own.
"""

import errno
import shlex
import struct
import subprocess
import threading
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path, PurePath

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.devices.system.folder import device_errors
from achse.server import IndexGroup, RawGroup

MOST_PROCESSES = 16
"""Processes of one station that run at the same time."""

_HEAD = struct.Struct("<3I")
"""Lengths of application, folder and command line, without their NULs."""

_LONGEST = 1 << 15
"""Bytes of a request."""

_HIDDEN = 0x1_0000
"""Bit of the offset: no window. Processes of a station have none anyway."""

Spawn = Callable[[Sequence[str], str | None], "subprocess.Popen[bytes]"]
"""Start a program with its arguments in a folder, None for that of the station."""

Beside = Callable[[bytes, int, Callable[[], bytes]], bytes]
"""Do a job for a client beside the loop, see `Files.beside`."""


class Processes:
    """Processes that clients started. They outlive the station.

    `programs` are absolute paths, in whose parts `*` and `?` stand for any characters.
    """

    def __init__(self, programs: Sequence[str], beside: Beside, spawn: Spawn | None = None) -> None:
        self._programs = tuple(programs)
        self._beside = beside
        self._spawn = _spawn if spawn is None else spawn
        self._running: list[subprocess.Popen[bytes]] = []
        self._lock = threading.Lock()

    def groups(self) -> Iterable[IndexGroup]:
        yield RawGroup(
            500,
            "start process",
            write=self._start,
            last_offset=_HIDDEN,
            request="UDINT lengths of program, folder and command line; the three texts with NUL",
            description="0x701 without programs in [system], 0x723 for one that it does not name,"
            " 0x70C for one that is not there.",
        )

    def sweep(self) -> None:
        """Forget processes that have ended."""
        if self._running:
            with self._lock:
                self._running = [process for process in self._running if process.poll() is None]

    def _start(self, offset: int, data: bytes, client: bytes) -> None:
        if not self._programs:
            raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, "no programs in [system]")
        if offset & ~_HIDDEN:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"start process 0x{offset:X}")
        program, folder, line = _texts(data)
        if not self._allowed(program):
            raise DeviceError(
                ReturnCode.DEVICE_ACCESS_DENIED, f"{program!r:.80} is not in [system] programs"
            )
        try:
            arguments = [program, *shlex.split(line)]
        except ValueError as fault:
            raise DeviceError(ReturnCode.SYNTAX, f"command line: {fault}") from None
        self._beside(client, len(data), lambda: self._run(arguments, folder or None))

    def _allowed(self, program: str) -> bool:
        path = PurePath(program)
        return (
            path.is_absolute()
            and ".." not in path.parts
            and any(path.match(pattern) for pattern in self._programs)
        )

    def _run(self, arguments: Sequence[str], folder: str | None) -> bytes:
        self.sweep()
        with self._lock, device_errors():
            if len(self._running) >= MOST_PROCESSES:
                raise DeviceError(ReturnCode.BUSY, f"{MOST_PROCESSES} processes run already")
            self._running.append(self._spawn(arguments, folder))
        return b""


def _texts(data: bytes) -> tuple[str, str, str]:
    """Application, folder and command line. Raises DeviceError 0x705 or 0x706."""
    if not _HEAD.size <= len(data) <= _LONGEST:
        raise DeviceError(
            ReturnCode.INVALID_SIZE,
            f"expected {_HEAD.size} to {_LONGEST} bytes, got {len(data)}",
        )
    lengths = _HEAD.unpack_from(data)
    if len(data) != _HEAD.size + sum(lengths) + len(lengths):
        raise DeviceError(ReturnCode.INVALID_SIZE, f"lengths {lengths} in {len(data)} bytes")
    texts, start = [], _HEAD.size
    for length in lengths:
        text = data[start : start + length + 1]
        if text.find(b"\0") != length:
            raise DeviceError(ReturnCode.INVALID_DATA, "expected a text of its length with NUL")
        texts.append(text[:-1].decode("utf-8", "surrogateescape"))
        start += length + 1
    program, folder, line = texts
    return program, folder, line


def _spawn(arguments: Sequence[str], folder: str | None) -> "subprocess.Popen[bytes]":
    """Start a program, a file without format by the shell, as execvp does. Raises OSError."""
    try:
        return _popen(arguments, folder)
    except OSError as failure:
        if failure.errno != errno.ENOEXEC or not Path("/bin/sh").exists():
            raise
        return _popen(["/bin/sh", *arguments], folder)


def _popen(arguments: Sequence[str], folder: str | None) -> "subprocess.Popen[bytes]":
    return subprocess.Popen(
        arguments,
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
