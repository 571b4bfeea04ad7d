"""Log file of one process of a fleet, of bounded length."""

import asyncio
import logging
import os
import threading
from pathlib import Path

log = logging.getLogger("achse.fleet")

_LONGEST, _KEPT = 8 * 1024 * 1024, 1024 * 1024
"""Bytes: a log that grows longer is shortened to its last lines of so many bytes."""

_CHUNK = 65536


class LogFile:
    """Appends what a process writes to its stderr.

    The supervisor is the only writer, so no line is lost while it shortens the file. A reader sees
    the file of before or the shortened file, both complete.
    """

    def __init__(self, file: Path, *, longest: int = _LONGEST, retained: int = _KEPT) -> None:
        if not 0 <= retained < longest:
            raise ValueError(
                f"expected 0 <= retained < longest, got retained {retained} and longest {longest}"
            )
        self.file = file
        self._longest, self._kept_bytes = longest, retained
        self._lock = threading.Lock()
        self._refused = False

    def follow(self, pipe: int) -> asyncio.Event:
        """Append what the pipe brings, in a thread; the event is set when the pipe has ended.

        Goes on reading when the file cannot be written: a full disk does not stop the process.
        """
        self.append(b"")  # the file is there from the beginning
        loop, ended = asyncio.get_running_loop(), asyncio.Event()

        def read() -> None:
            with os.fdopen(pipe, "rb", buffering=0) as stream:
                while data := stream.read(_CHUNK):
                    self.append(data)
            try:
                loop.call_soon_threadsafe(ended.set)
            except RuntimeError:  # the loop is closed
                return

        threading.Thread(target=read, name=f"achse-{self.file.stem}", daemon=True).start()
        return ended

    def append(self, data: bytes) -> None:
        """Write at the end of the file; shorten the file when it is too long."""
        with self._lock:
            try:
                with self.file.open("ab") as output:
                    output.write(data)
                if self.file.stat().st_size > self._longest:
                    self._shorten()
                self._refused = False
            except OSError as failure:
                if not self._refused:
                    log.warning("%s: lines are dropped: %s", self.file, failure)
                self._refused = True

    def _shorten(self) -> None:
        with self.file.open("rb") as whole:
            whole.seek(max(whole.seek(0, os.SEEK_END) - self._kept_bytes - 1, 0))
            end = whole.read()
        end = end.partition(b"\n")[2] or end[1:]  # a line longer than all is cut
        shortened = self.file.with_suffix(".shortened")
        shortened.write_bytes(end)
        shortened.replace(self.file)
