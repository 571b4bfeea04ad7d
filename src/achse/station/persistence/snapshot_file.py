"""Snapshot file: two alternating slots in a file that keeps its size.

A snapshot overwrites the older slot, in place, and is on the disk when `write` returns. A write
that the power cuts leaves the other slot whole: digests show which slots are. What the bytes mean
(the layout) is in the header and rarely changes; then another file takes the place of this one.
"""

import contextlib
import hashlib
import struct
from pathlib import Path
from typing import NamedTuple

from achse.station.persistence.file_port import DISK, FilePort

_MAGIC = b"achse\x00s1"
_HEADER = struct.Struct("<8sQQ16s")
"""Magic, bytes of the layout, bytes of a snapshot, digest of these and the layout."""
_SLOT = struct.Struct("<Qq16s")
"""Number, station time in ns, digest of header, these and the content."""
_BLOCK = 4096
"""Slots share no block of the disk with each other or the header."""


class SnapshotFileError(ValueError):
    """No slot of a snapshot file is whole: says what was expected and what came."""


class Snapshot(NamedTuple):
    """A copy of data at one moment."""

    layout: bytes
    """Layout of the content."""
    content: bytes
    time_ns: int
    """Station time."""


class SnapshotFile:
    """The file at `path`. Not for several threads at a time."""

    def __init__(self, path: Path, port: FilePort = DISK) -> None:
        self.path = path
        self._port = port
        self._content: tuple[bytes, int] | None = None
        """Layout and length of the content in the file that this object has begun."""
        self._digest = b""
        """Digest of the header."""
        self._number = 0
        """Number of the last snapshot."""

    def read(self) -> tuple[Snapshot, bool] | None:
        """Return the newest whole snapshot, and True if a newer one is torn; None without a file.

        Raises OSError, SnapshotFileError.
        """
        content = self._port.read(self.path)
        return None if content is None else _parsed(content)

    def write(self, snapshot: Snapshot) -> None:
        """Put a snapshot in place of the one before the last. Raises OSError.

        The last one is whole until this one is.
        """
        if self._content != (snapshot.layout, len(snapshot.content)):
            self._begin(snapshot)
            return
        number = self._number + 1
        slot = _slot(number, self._digest, snapshot)
        size = len(snapshot.content)
        offset = _offset(number & 1, len(snapshot.layout), size)
        begun, self._content = self._content, None  # after a failure another file is begun
        try:
            self._port.overwrite(self.path, offset, slot)
        except FileNotFoundError:
            self._begin(snapshot)
            return
        self._content, self._number = begun, number

    def remove(self) -> None:
        """Remove the file. Raises OSError."""
        self._content = None
        self._port.remove(self.path)

    def _begin(self, snapshot: Snapshot) -> None:
        """Put a file with this snapshot and an empty slot in the place of the file."""
        self._content = None
        layout, size = snapshot.layout, len(snapshot.content)
        lengths = struct.pack("<8sQQ", _MAGIC, len(layout), size)
        digest = _digest(lengths, layout)
        content = bytearray(_offset(2, len(layout), size))
        content[: _HEADER.size] = lengths + digest
        content[_HEADER.size : _HEADER.size + len(layout)] = layout
        slot, offset = _slot(0, digest, snapshot), _offset(0, len(layout), size)
        content[offset : offset + len(slot)] = slot
        fresh = self.path.with_name(self.path.name + ".new")
        try:
            self._port.create(fresh, bytes(content))
            self._port.replace(fresh, self.path)
        except OSError:
            with contextlib.suppress(OSError):
                self._port.remove(fresh)
            raise
        self._content, self._digest, self._number = (layout, size), digest, 0


def _digest(*parts: bytes) -> bytes:
    state = hashlib.blake2b(digest_size=16)
    for part in parts:
        state.update(part)
    return state.digest()


def _offset(slot: int, layout: int, size: int) -> int:
    """Return where slot 0 or 1 begins; of slot 2, where the file ends."""
    header = -(-(_HEADER.size + layout) // _BLOCK) * _BLOCK
    return header + slot * (-(-(_SLOT.size + size) // _BLOCK) * _BLOCK)


def _slot(number: int, header: bytes, snapshot: Snapshot) -> bytes:
    place = struct.pack("<Qq", number, snapshot.time_ns)
    return place + _digest(header, place, snapshot.content) + snapshot.content


def _parsed(content: bytes) -> tuple[Snapshot, bool]:
    if len(content) < _HEADER.size:
        raise SnapshotFileError(f"expected {_HEADER.size} bytes or more, got {len(content)}")
    magic, length, size, header = _HEADER.unpack_from(content)
    if magic != _MAGIC:
        raise SnapshotFileError(f"expected a snapshot file, got {magic!r} at its beginning")
    layout = content[_HEADER.size : _HEADER.size + length]
    if len(layout) != length or _digest(content[: _HEADER.size - 16], layout) != header:
        raise SnapshotFileError("the header is torn")
    newest: tuple[int, Snapshot] | None = None
    torn = False
    for slot in (0, 1):
        begin = _offset(slot, length, size)
        record = content[begin : begin + _SLOT.size + size]
        if len(record) < _SLOT.size + size:
            torn = True
            continue
        number, time_ns, digest = _SLOT.unpack_from(record)
        if _digest(header, record[:16], record[_SLOT.size :]) != digest:
            torn |= any(record)
        elif newest is None or number > newest[0]:
            newest = number, Snapshot(layout, record[_SLOT.size :], time_ns)
    if newest is None:
        raise SnapshotFileError("both snapshots are torn")
    return newest[1], torn
