"""Log lines written by a thread of their own, so that a reader that stalls stops nothing."""

import logging
import os
import threading
import time
from collections import deque
from typing import TextIO

from achse.router.rate import Rates

_LINES, _BYTES = 10_000, 1 << 22
"""Most lines and bytes that wait for the reader; lines beyond are dropped and counted."""

_LONGEST = 1 << 14
"""Characters of one record; a longer one is cut."""

_PER_SECOND, _ALL_PER_SECOND = 100, 1000
"""Lines of one kind (one place in the program), and of all; those beyond are counted."""

_PIECE = 4096
"""Bytes that are written at once: what a pipe takes whole."""

_FAREWELL = 0.5
"""Seconds that the end of the program waits for a reader."""


class LogWriter(logging.Handler):
    """Writes to `stream`, never in the thread that logs.

    - What a reader does not take waits, 10,000 lines and 4 MB at most. Then lines are dropped; how
      many is reported as soon as there is room.
    - Of one kind (one place in the program) at most 100 lines a second are written, and 1,000 of
      all; their number is reported once a second.
    - At the end of the program a reader has half a second to take what waits.
    """

    def __init__(self, stream: TextIO) -> None:
        super().__init__()
        self.dropped = 0
        """Lines lost so far: the reader stalled, or there were too many."""
        self._stream = stream
        try:
            self._file: int | None = stream.fileno()
        except (OSError, ValueError):
            self._file = None  # a stream in memory
        self._rates = Rates(_PER_SECOND, _ALL_PER_SECOND)
        self._waiting: deque[bytes] = deque()
        self._size = 0
        self._unread = self._left_out = 0
        """Dropped lines that were not reported yet, by reason."""
        self._reported_at = 0.0
        """Time of the last report that lines were left out."""
        self._writing = self._ended = False
        self._changed = threading.Condition()
        self._thread: threading.Thread | None = None

    def emit(self, record: logging.LogRecord) -> None:
        """Put a record among those that wait."""
        place = (record.pathname, record.lineno)
        if self._rates.take(place, time.monotonic_ns()):
            line = self._line(record)
            with self._changed:
                if len(self._waiting) < _LINES and self._size + len(line) <= _BYTES:
                    self._report_unread()
                    self._put(line)
                else:
                    self._unread += 1
                    self.dropped += 1
                self._go_on()
        else:
            with self._changed:
                self._left_out += 1
                self.dropped += 1
                self._go_on()

    def _line(self, record: logging.LogRecord) -> bytes:
        try:
            text = self.format(record)
        except Exception as failure:  # of a message that does not fit its arguments
            text = f"{record.pathname}:{record.lineno}: {record.msg!r}: {failure!r}"
        if len(text) > _LONGEST:
            text = f"{text[:_LONGEST]} … ({len(text)} characters)"
        return text.encode("utf-8", "backslashreplace") + b"\n"

    def _put(self, line: bytes) -> None:
        self._waiting.append(line)
        self._size += len(line)

    def _report_unread(self) -> None:
        if self._unread:
            self._put(
                self._warning("%d lines were dropped: the reader of the log stalled", self._unread)
            )
            self._unread = 0

    def _go_on(self) -> None:
        if self._thread is None and not self._ended:
            self._thread = threading.Thread(target=self._run, name="achse-log", daemon=True)
            self._thread.start()
        self._changed.notify_all()

    def flush(self) -> None:
        """Wait until all is written, half a second at most."""
        with self._changed:
            self._changed.wait_for(lambda: not (self._waiting or self._writing), _FAREWELL)

    def close(self) -> None:
        """Take no more; what was not written by now may be lost."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()
        super().close()

    # the thread ------------------------------------------------------------------------------

    def _run(self) -> None:
        while lines := self._next():
            self._write(lines)

    def _next(self) -> bytes:
        """Return the lines to write now; nothing at the end."""
        with self._changed:
            self._writing = False
            self._changed.notify_all()
            while not (self._waiting or self._unread or self._ended or self._is_report_due()):
                self._changed.wait(1.0 if self._left_out else None)
            lines = bytearray()
            if self._is_report_due():
                self._reported_at = time.monotonic()
                lines += self._warning("%d lines were left out: too many a second", self._left_out)
                self._left_out = 0
            if not self._waiting:
                self._report_unread()
            while self._waiting and len(lines) + len(self._waiting[0]) <= _PIECE:
                lines += self._take()
            if not lines and self._waiting:
                lines += self._take()  # longer than a piece
            self._writing = bool(lines)
            return bytes(lines)

    def _take(self) -> bytes:
        line = self._waiting.popleft()
        self._size -= len(line)
        return line

    def _is_report_due(self) -> bool:
        return self._left_out > 0 and time.monotonic() - self._reported_at >= 1.0

    def _warning(self, text: str, count: int) -> bytes:
        place = ("achse.log", logging.WARNING, __file__, 0)
        return self._line(logging.LogRecord(*place, text, (count,), None))

    def _write(self, data: bytes) -> None:
        try:
            if self._file is None:
                self._stream.write(data.decode("utf-8"))
                return
            while data:
                try:
                    data = data[os.write(self._file, data) :]
                except BlockingIOError:  # a process that shares the pipe made it so
                    time.sleep(0.05)
        except (OSError, ValueError):
            pass  # the reader has ended: no report is possible
