"""Files of a slave over ADS: opened by name, read or written in parts, closed.

A file is read whole from the slave with the first requested part, and written whole when
it is closed: that is how FoE takes it.
"""

import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.devices.io.groups import SlaveGroup
from achse.devices.io.later import answer_later
from achse.devices.io.served import ServedBus
from achse.ethercat.master import BusError
from achse.ethercat.master.foe_client import MAX_FILE, FoeClient, FoeProgress
from achse.ethercat.master.mailbox_client import MailboxClient
from achse.ethercat.master.steps import Steps
from achse.server import IndexGroup, RawGroup

_MOST_OPEN = 8
"""Files of one slave that are open at a time, for all clients."""
_LONGEST_NAME = 255
_U32 = 0xFFFF_FFFF
_HEADER = "vendor's interface header"


@dataclass
class _OpenFile:
    client: bytes
    name: str
    password: int
    writes: bool
    data: bytes | None = None
    at: int = 0
    under_way: bool = False
    """The slave reads or takes it now."""
    progress: FoeProgress = field(default_factory=FoeProgress)


class SlaveFiles:
    """The open files of one slave. `ready` gives its mailbox, or raises what is wrong now."""

    def __init__(
        self,
        bus: ServedBus,
        ready: Callable[[], MailboxClient],
        note: Callable[[bytes, BusError], None],
    ) -> None:
        self._bus = bus
        self._ready = ready
        self._note = note
        self._files: dict[int, _OpenFile] = {}
        self._last = 0

    def groups(self) -> Iterator[IndexGroup]:
        for group, name, read_write, request, response in (
            (
                SlaveGroup.FILE_OPEN_READ,
                "file, opened for reading",
                self._open(writes=False),
                "name of the file; offset: password",
                "UINT32 handle",
            ),
            (
                SlaveGroup.FILE_OPEN_WRITE,
                "file, opened for writing",
                self._open(writes=True),
                "name of the file; offset: password",
                "UINT32 handle",
            ),
            (SlaveGroup.FILE_CLOSE, "file, closed", self._close, "offset: handle", ""),
            (
                SlaveGroup.FILE_READ,
                "file, read",
                self._read,
                "offset: handle",
                "the next bytes; none at its end",
            ),
            (SlaveGroup.FILE_WRITE, "file, written", self._write, "bytes; offset: handle", ""),
        ):
            yield RawGroup(
                group,
                name,
                read_write=read_write,
                last_offset=_U32,
                request=request,
                response=response,
                description="FoE; a file is written when it is closed",
                source=_HEADER,
            )

        yield RawGroup(
            SlaveGroup.FILE_PROGRESS,
            "file, progress",
            read=lambda offset, length, client: self._progress(offset, length, b"", client),
            read_write=self._progress,
            last_offset=_U32,
            request="offset: handle",
            response="UINT32 bytes done, UINT32 bytes in all (0: not known); of a slave that is"
            " busy UINT32 done, UINT32 in all (0: unknown) and its words",
            description="FoE; while a file is read, or written on closing. Layout ours",
            source=_HEADER,
        )

    def end_client(self, client: bytes) -> None:
        """Note that a client is gone: its files are closed, and what was not written is dropped."""
        for handle in [number for number, each in self._files.items() if each.client == client]:
            del self._files[handle]

    def _open(self, *, writes: bool) -> Callable[[int, int, bytes, bytes], bytes]:
        def open_file(offset: int, length: int, data: bytes, client: bytes) -> bytes:
            self._ready()
            name = data.partition(b"\0")[0]
            if not 0 < len(name) <= _LONGEST_NAME:
                raise DeviceError(ReturnCode.INVALID_DATA, f"a name has 1 to {_LONGEST_NAME} bytes")
            if len(self._files) >= _MOST_OPEN:
                raise DeviceError(ReturnCode.DEVICE_NO_MEMORY, f"{_MOST_OPEN} files are open")
            self._last = self._last % _U32 + 1
            self._files[self._last] = _OpenFile(
                client, name.decode("latin-1"), offset, writes, b"" if writes else None
            )
            return self._last.to_bytes(4, "little")

        return open_file

    def _file(self, handle: int, client: bytes, *, writes: bool | None = None) -> _OpenFile:
        file = self._files.get(handle)
        if file is None or file.client != client:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"no file is open as {handle}")
        if file.under_way:
            raise DeviceError(ReturnCode.BUSY, f"file {handle} is under way")
        if writes is not None and file.writes != writes:
            raise DeviceError(ReturnCode.INVALID_ACCESS, "the file is open the other way")
        return file

    def _read(self, handle: int, length: int, data: bytes, client: bytes) -> bytes:
        file = self._file(handle, client, writes=False)
        if file.data is not None:
            return _next(file, length)

        def steps() -> Steps[bytes]:
            try:
                file.data = yield from foe.read(file.name, file.password, progress=file.progress)
            finally:
                file.under_way = False
            return _next(file, length)

        foe = self._foe()
        later = answer_later(
            self._bus.master,
            steps(),
            lambda part: part,
            lambda trouble: self._note(client, trouble),
        )
        file.under_way = True
        raise later

    def _progress(self, handle: int, length: int, data: bytes, client: bytes) -> bytes:
        file = self._files.get(handle)
        if file is None or file.client != client:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"no file is open as {handle}")
        at = file.progress
        numbers = struct.pack("<4I", at.done, at.whole, at.busy_done, at.busy_whole)
        return (numbers + at.text.encode("cp1252", "replace") + b"\0")[:length]

    def _write(self, handle: int, length: int, data: bytes, client: bytes) -> bytes:
        file = self._file(handle, client, writes=True)
        assert file.data is not None
        if len(file.data) + len(data) > MAX_FILE:
            raise DeviceError(ReturnCode.INVALID_SIZE, f"{MAX_FILE} bytes at most")
        file.data += data
        return b""

    def _close(self, handle: int, length: int, data: bytes, client: bytes) -> bytes:
        file = self._file(handle, client)
        if not file.writes:
            del self._files[handle]
            return b""
        assert file.data is not None
        content = file.data

        def steps() -> Steps[None]:
            try:
                yield from foe.write(file.name, content, file.password, progress=file.progress)
            finally:
                self._files.pop(handle, None)

        try:
            foe = self._foe()
        except DeviceError:
            del self._files[handle]
            raise
        later = answer_later(
            self._bus.master,
            steps(),
            lambda none: b"",
            lambda trouble: self._note(client, trouble),
        )
        file.under_way = True
        raise later

    def _foe(self) -> FoeClient:
        return FoeClient(self._ready())


def _next(file: _OpenFile, length: int) -> bytes:
    assert file.data is not None
    part = file.data[file.at : file.at + length]
    file.at += len(part)
    return part
