"""Snapshots of persistent data while a station runs: a killed one loses the last cycles only.

Images are taken in the station's loop, between two cycles, by the computer's time: a station at a
thousand times the speed writes as often as any other. A thread writes them. An image that
is like the last one written is not written.
"""

import asyncio
import logging
import threading
import time
from collections.abc import Awaitable, Callable

from achse.station.persistence.persistent_image import PersistentImage, PersistentLayout
from achse.station.persistence.snapshot_file import Snapshot, SnapshotFile

_SHARE = 20
"""Taking images costs the loop at most one part in so many of its time."""
_PAUSE_S = 1.0
"""After a write that failed, s."""
_SLOW_S = 1.0
"""A write that takes longer is reported."""

_QUIET_S = 30.0
"""Trouble is over after so long without it, s; if it comes back before, nothing is reported."""

log = logging.getLogger("achse.station")


class Snapshots:
    """Writes snapshots to a file every `interval_s` seconds, if something has changed."""

    def __init__(
        self,
        file: SnapshotFile,
        interval_s: float,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        """`clock` and `sleep` go by the computer's time, in seconds."""
        self._file = file
        self._interval_s = interval_s
        self._clock = clock
        self._sleep = sleep
        self._lock = threading.Lock()
        self._stored_image: PersistentImage | None = None
        """The image that the file has, or another file that is newer."""
        self._saves = 0
        """Count of saves to the other file: images from before a save are out of date."""
        self._encoded: tuple[PersistentLayout, bytes] | None = None
        self._failures, self._slowness = _Trouble(), _Trouble()

    def begin_with(self, image: PersistentImage) -> None:
        """Take an image as written: it is what the files at the start led to.

        After a write that failed no file has it: it is written as soon as that is possible.
        """
        with self._lock:
            self._stored_image = None if self._failures.is_present else image

    async def run(self, capture: Callable[[], PersistentImage | None]) -> None:
        """Write what `capture` returns, until cancelled; None if there is nothing to write now."""
        pause = self._interval_s
        while True:
            await self._sleep(pause)
            began = self._clock()
            self._report_end(began)
            image = capture()
            taken = self._clock()
            pause = max(self._interval_s, _SHARE * (taken - began))
            if image is None or image.is_like(self._stored_image):
                continue
            is_written = await asyncio.to_thread(self.write, image, self._saves)
            took = self._clock() - taken
            pause = max(pause - took, took) if is_written else max(pause, _PAUSE_S)

    def write(self, image: PersistentImage, saves: int | None = None) -> bool:
        """Write an image, unless a save came between; False if that failed, which is reported.

        `saves` is how many saves there were when the image was taken.
        """
        with self._lock:
            if saves not in (None, self._saves):
                return True
            began = self._clock()
            try:
                self._file.write(Snapshot(self._encode(image.layout), image.content, image.time_ns))
            except OSError as failure:
                self._report_failure(failure)
                return False
            self._stored_image = image
            self._report_success(self._clock() - began)
            return True

    def supersede(self, image: PersistentImage, write: Callable[[], None]) -> None:
        """Let `write` put an image into another file; then the snapshot file is removed.

        Waits for a snapshot that is being written. Raises OSError of both.
        """
        with self._lock:
            self._saves += 1
            write()
            self._file.remove()
            self._stored_image = image

    def _encode(self, layout: PersistentLayout) -> bytes:
        if self._encoded is None or self._encoded[0] is not layout:
            self._encoded = layout, layout.encode()
        return self._encoded[1]

    def _report_failure(self, failure: OSError) -> None:
        if self._failures.occurs(self._clock()):
            log.error("%s cannot be written: %s", self._file.path, failure.strerror)

    def _report_success(self, took_s: float) -> None:
        now = self._clock()
        self._failures.is_present = False
        if took_s <= _SLOW_S:
            self._slowness.is_present = False
        elif self._slowness.occurs(now):
            log.warning(
                "%s: writing took %.1f s, expected up to %g s; a power cut loses so much",
                *(self._file.path, took_s, _SLOW_S),
            )
        self._report_end(now)

    def _report_end(self, now: float) -> None:
        """Report once that writes succeed again, as soon as that is so for a while."""
        self._slowness.end(now)
        if count := self._failures.end(now):
            log.warning("%s is written again; %d writes failed", self._file.path, count)


class _Trouble:
    """Trouble that may come and go many times a second, at a limit of the system for example."""

    def __init__(self) -> None:
        self.is_present = False
        self._count, self._last = 0, 0.0

    def occurs(self, now: float) -> bool:
        """Note an occurrence; True if it is the first one."""
        self.is_present = True
        self._count, self._last = self._count + 1, now
        return self._count == 1

    def end(self, now: float) -> int:
        """Count of occurrences if the trouble is over now; 0 while it goes on."""
        if self.is_present or now - self._last < _QUIET_S:
            return 0
        count, self._count = self._count, 0
        return count
