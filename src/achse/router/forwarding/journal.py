"""Journal of symbol handles that clients of a router hold at its targets.

A target may keep the handles of a connection that has ended. The journal names them after the
connection, or the router itself, is gone, so that they can be released. In its file each handle has
a slot of its own, which is free again after the release: the file is as long as the most handles at
one time. A record is written at once and never synchronised: the page cache survives a killed
process, and a computer that restarts begins with an empty journal at the worst.

A record with handle 0 says that a client has asked a device for handles: an answer may have been
under way when the connection ended.
"""

import logging
import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple, Protocol

log = logging.getLogger("achse.router")

_MAGIC = b"achse handle journal 1".ljust(32, b"\0")

_RECORD = struct.Struct("<8s8sII")
"""Alias, device, handle, number of the record; its CRC-32 and four bytes of 0 follow."""

_SUM = struct.Struct("<I4x")

_SLOT = len(_MAGIC)
"""Bytes of a slot; the first one is the magic."""

_FREE = bytes(_SLOT)

_GROWTH = 128
"""Slots by which the file grows, so that a release finds its slot on a full disk too."""

MOST_SLOTS = 1 << 18
"""Slots of a file, 8 MiB; further handles are known to the process alone."""


class JournalFile(Protocol):
    """Interface of the file: open for reading and writing, without a buffer."""

    def seek(self, offset: int, whence: int = 0, /) -> int: ...

    def read(self, size: int = -1, /) -> bytes | None: ...

    def write(self, data: bytes, /) -> int | None: ...

    def truncate(self, size: int | None = None, /) -> int: ...


class JournalError(Exception):
    """The file is not a journal."""


class JournalHandle(NamedTuple):
    """A symbol handle at a device, under the alias of the client; 0: it has asked for some."""

    alias: bytes
    device: bytes
    handle: int


class HandleJournal:
    """Symbol handles at targets, and the clients that requested some; kept in `file` if there is
    one.

    Raises JournalError if the file is not a journal, OSError if it cannot be read or written.
    Later failures to write are logged once: the router goes on.
    """

    def __init__(self, file: JournalFile | None = None) -> None:
        self._file = file
        self._counts: Counter[JournalHandle] = Counter()
        """Requests for each handle; in the order of the first of them."""
        self._devices_by_client: dict[bytes, set[bytes]] = {}
        """Devices that each client has asked."""
        self._slots: dict[JournalHandle, list[int]] = {}
        self._free: list[int] = []
        self._end = 1
        """Slots of the file, the magic included."""
        self._number = 0
        self._warned = False
        if file is not None:
            self._load(file)

    def __len__(self) -> int:
        """Handles of all clients, each as often as it was requested."""
        return sum(count for each, count in self._counts.items() if each.handle)

    def add_requester(self, alias: bytes, device: bytes) -> None:
        """Add a client that requests a handle of a device."""
        if device not in self._devices_by_client.get(alias, ()):
            self._add(JournalHandle(alias, bytes(device), 0))

    def fetched(self, alias: bytes, device: bytes, handle: int) -> None:
        """Add a handle that a device has returned."""
        self._add(JournalHandle(alias, device, handle))

    def released(self, alias: bytes, device: bytes, handle: int) -> None:
        """Note that a device has released a handle, or does not know it. Unknown is not an
        error."""
        self._remove(JournalHandle(alias, device, handle))

    def forget_client(self, alias: bytes, net_id: bytes) -> None:
        """Forget a client that has no resource at the devices of a target."""
        for device in list(self._devices_by_client.get(alias, ())):
            if device[:6] == net_id:
                self._remove(JournalHandle(alias, device, 0))

    def forget_device(self, device: bytes) -> None:
        """Forget a device that has no resource of any client any more."""
        for each in [each for each in self._counts if each.device == device]:
            for _ in range(self._counts[each]):
                self._remove(each)

    def handles_at(self, net_id: bytes) -> list[tuple[JournalHandle, int]]:
        """Return the handles at the devices of a target, the oldest first, with their counts."""
        return [each for each in self._counts.items() if each[0].device[:6] == net_id]

    def _count(self, key: JournalHandle) -> None:
        self._counts[key] += 1
        if not key.handle:
            self._devices_by_client.setdefault(key.alias, set()).add(key.device)

    def _add(self, key: JournalHandle) -> None:
        self._count(key)
        file = self._file
        if file is None or (not self._free and not self._grow(file)):
            return
        slot = self._free.pop()
        self._number = self._number + 1 & 0xFFFF_FFFF
        body = _RECORD.pack(key.alias, key.device, key.handle, self._number)
        if self._write(file, slot, body + _SUM.pack(zlib.crc32(body))):
            self._slots.setdefault(key, []).append(slot)

    def _remove(self, key: JournalHandle) -> None:
        count = self._counts.get(key, 0)
        if not count:
            return
        if count > 1:
            self._counts[key] = count - 1
        else:
            del self._counts[key]
            if not key.handle:
                self._devices_by_client[key.alias].remove(key.device)
                if not self._devices_by_client[key.alias]:
                    del self._devices_by_client[key.alias]
        slots = self._slots.get(key)
        if slots:
            slot = slots.pop()
            if not slots:
                del self._slots[key]
            if self._file is not None and self._write(self._file, slot, _FREE):
                self._free.append(slot)

    # the file --------------------------------------------------------------------------------

    def _load(self, file: JournalFile) -> None:
        """Read the records of an earlier process."""
        file.seek(0)
        data = file.read(_SLOT * (MOST_SLOTS + 1)) or b""
        if len(data) >= _SLOT and data[:_SLOT] != _MAGIC:
            raise JournalError("not a journal of handles")
        records = sorted(_records(data), key=lambda each: each[0])
        for number, slot, key in records:
            self._number = number
            self._count(key)
            self._slots.setdefault(key, []).append(slot)
        if records:
            self._end = len(data) // _SLOT
            used = {slot for _, slot, _ in records}
            self._free = [each for each in range(self._end - 1, 0, -1) if each not in used]
            file.truncate(self._end * _SLOT)
        else:
            file.truncate(0)
            file.seek(0)
            file.write(_MAGIC)

    def _grow(self, file: JournalFile) -> bool:
        """Append free slots; False if the disk or the journal is full."""
        if self._end >= MOST_SLOTS:
            self._warn(f"{MOST_SLOTS} handles in it")
            return False
        begin, size = self._end * _SLOT, _GROWTH * _SLOT
        try:
            file.seek(begin)
            written = file.write(bytes(size))
            if written != size:
                file.truncate(begin)
                raise OSError(0, "no space left")
        except OSError as failure:
            self._warn(failure.strerror or str(failure))
            return False
        self._free.extend(range(self._end + _GROWTH - 1, self._end - 1, -1))
        self._end += _GROWTH
        return True

    def _write(self, file: JournalFile, slot: int, data: bytes) -> bool:
        """Write a slot; a file that cannot be kept true is emptied and left alone."""
        try:
            file.seek(slot * _SLOT)
            if file.write(data) == _SLOT:
                return True
            raise OSError(0, "no space left")
        except OSError as failure:
            self._warn(failure.strerror or str(failure))
            self._file = None
            try:
                file.truncate(0)
            except OSError as why:
                log.error("journal of handles cannot be emptied: %s", why.strerror)
            return False

    def _warn(self, reason: str) -> None:
        if not self._warned:
            self._warned = True
            log.warning(
                "journal of handles cannot be written: %s; handles stay at targets if this router"
                " is killed",
                reason,
            )


class LinkJournal:
    """The part of a journal that concerns the devices of one target."""

    def __init__(self, journal: HandleJournal, net_id: bytes) -> None:
        self._net_id = net_id
        self._journal = journal
        self.add_requester = journal.add_requester
        self.fetched = journal.fetched
        self.released = journal.released
        self.forget_device = journal.forget_device

    def forget_client(self, alias: bytes) -> None:
        """Forget a client that has no resource at the target."""
        self._journal.forget_client(alias, self._net_id)

    def handles(self) -> list[tuple[JournalHandle, int]]:
        """Return the handles at the target, the oldest first, with their counts."""
        return self._journal.handles_at(self._net_id)


def _records(data: bytes) -> Iterator[tuple[int, int, JournalHandle]]:
    """Yield number, slot and content of each whole record."""
    for slot in range(1, len(data) // _SLOT):
        position = slot * _SLOT
        body = data[position : position + _RECORD.size]
        if zlib.crc32(body) == _SUM.unpack_from(data, position + _RECORD.size)[0] and any(body):
            alias, device, handle, number = _RECORD.unpack(body)
            yield number, slot, JournalHandle(alias, device, handle)
