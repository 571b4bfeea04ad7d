"""Orphaned handles: the connection over which clients requested them has ended, the target stays.

They are released on the next connection, before anything else goes there. First each client's
address requests the devices to release its abandoned handles, which stations of achse do; other
targets refuse it. Then the newest handles of each device are released by their numbers. If it knows
none of them it has restarted: its other numbers, if there are any, belong to others by now, and are
left alone. If it knows one, the rest follows.
"""

import logging
from collections import Counter, deque
from collections.abc import Callable
from functools import partial

from achse.ams import AmsAddress, Command, Frame
from achse.ams.commands import RESULT, WriteRequest
from achse.codes import ReservedGroup
from achse.router.forwarding.forwarded_client import ForwardedClient
from achse.router.forwarding.journal import JournalHandle, LinkJournal

log = logging.getLogger("achse.router")

_NEWEST = 2
"""Handles of a device that show if it has restarted, of several clients where there are: some may
have been released by a request whose answer was lost."""

_AT_ONCE = 64
"""Requests without an answer."""

SendRequest = Callable[[ForwardedClient, bytes, int, bytes, Callable[[Frame], None]], None]
"""Sends a request of the router as a client: device, command, data, what gets the answer."""


class EarlierClients:
    """The clients of connections that have ended; nothing comes for them."""

    def deliver(self, frame: Frame) -> bool:
        """Drop a frame."""
        return True


EARLIER = EarlierClients()


class OrphanRelease:
    """The work for one target, by the connection that is new.

    `session_of(alias)` returns the session of a client of before, `done()` is called when nothing
    more is to be released.
    """

    def __init__(
        self,
        journal: LinkJournal,
        session_of: Callable[[bytes], ForwardedClient | None],
        send_request: SendRequest,
        done: Callable[[], object],
    ) -> None:
        self._journal, self._session_of, self._send_request = journal, session_of, send_request
        self._report_end = done
        handles = journal.handles()
        self._devices = dict.fromkeys(each.device for each, _ in handles)
        self._requesters = [each for each, _ in handles if not each.handle]
        self._handles: dict[bytes, list[JournalHandle]] = {}
        """Handles of each device, the newest first."""
        for each, count in reversed(handles):
            if each.handle:
                self._handles.setdefault(each.device, []).extend([each] * count)
        self._answering_devices: set[bytes] = set()
        """Devices that have released a handle by its number."""
        self._to_send: deque[JournalHandle] = deque()
        self._following = self._release_newest
        self._waiting = 0
        self._is_closed = False
        self.answers = 0
        """Answers that have come."""

    def begin(self) -> None:
        """Let clients release their abandoned handles."""
        self._to_send.extend(self._requesters)
        self._go_on()

    def cancel(self) -> None:
        """Do nothing more: the connection has ended again. The journal stays as it is."""
        self._is_closed = True

    def give_up(self) -> None:
        """Wait for nothing more, if it has not ended yet."""
        if not self._is_closed:
            remaining = sum(map(len, self._handles.values()))
            log.warning(
                "handles of ended connections: no answer, %d may stay at the target", remaining
            )
            self._end()

    def _go_on(self) -> None:
        """Send what may go; begin the next phase when everything is answered."""
        while self._to_send and self._waiting < _AT_ONCE:
            self._send(self._to_send.popleft())
        while not (self._to_send or self._waiting or self._is_closed):
            self._following()
            while self._to_send and self._waiting < _AT_ONCE:
                self._send(self._to_send.popleft())

    def _send(self, each: JournalHandle) -> None:
        session = self._session_of(each.alias)
        # Only the same address releases its abandoned handles.
        if session is None or (not each.handle and session.alias != each.alias):
            return
        data = RESULT.pack(each.handle) if each.handle else b""
        data = WriteRequest(ReservedGroup.RELEASE_SYMBOL_HANDLE, 0, data).encode()
        self._waiting += 1
        self._send_request(session, each.device, Command.WRITE, data, partial(self._came, each))

    def _came(self, each: JournalHandle, answer: Frame) -> None:
        self._waiting -= 1
        self.answers += 1
        if each.handle:
            if not answer.error and answer.data[:4] == bytes(4):
                self._answering_devices.add(each.device)
            self._journal.released(*each)
        if not self._is_closed:
            self._go_on()

    def _release_newest(self) -> None:
        """Release the newest handles of each device by their numbers."""
        for handles in self._handles.values():
            handles.sort(key=_ranks(handles).__getitem__)
            self._to_send.extend(handles[:_NEWEST])
            del handles[:_NEWEST]
        self._following = self._release_rest

    def _release_rest(self) -> None:
        """Release the others where one of the newest was there."""
        for device, handles in self._handles.items():
            if device in self._answering_devices:
                self._to_send.extend(handles)
                log.info("%s: %d handles of ended connections", AmsAddress(device), len(handles))
            handles.clear()
        self._following = self._end

    def _end(self) -> None:
        self._is_closed = True
        for device in self._devices:
            self._journal.forget_device(device)
        self._report_end()


def _ranks(handles: list[JournalHandle]) -> dict[JournalHandle, int]:
    """Return the place of each handle among those of its client."""
    counts: Counter[bytes] = Counter()
    ranks: dict[JournalHandle, int] = {}
    for each in handles:
        ranks[each] = counts[each.alias]
        counts[each.alias] += 1
    return ranks
