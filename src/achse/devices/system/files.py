"""File services of the system service: open, read, write, seek, find, delete, and their handles.

The form of today uses ReadWrite at groups 120 … 139, the handle in the offset. The older one
opens at 100 … 102 and uses the handle as index group; a file opened by either serves both.

Source: 000 §5.1 for the older form. The groups of today's form are those that clients use, as
recorded; its mode bits and what its requests contain are in no manual at hand: they are what the
file blocks of PLC libraries send.
"""

import io
import os
import stat
import struct
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import NoReturn

from achse.ams import DeviceError
from achse.ams.filetime import from_unix_ns
from achse.codes import ReturnCode
from achse.codes.groups import OPEN_FILES
from achse.devices.system.file_worker import FileWorker
from achse.devices.system.folder import Folder, as_name, device_errors
from achse.server import READ, READ_WRITE, WRITE, IndexGroup, RawGroup, RowFacts


class OpenMode:
    """Bits of the offset that opens a file; the place of the path is in its upper half."""

    READ = 0x01
    WRITE = 0x02
    APPEND = 0x04
    PLUS = 0x08
    BINARY = 0x10
    TEXT = 0x20
    ENSURE_FOLDER = 0x40
    ENABLE_FOLDER = 0x80

    KNOWN = 0xFF


_C_MODES = {OpenMode.READ: "r", OpenMode.WRITE: "w", OpenMode.APPEND: "a"}

FIRST_HANDLE = OPEN_FILES.start
"""First handle. The target chooses its numbers; used as index groups, they meet no other group."""

_HANDLES = len(OPEN_FILES)
"""Files and searches open at a time; their numbers are index groups too, so they are few."""

_PER_CLIENT = 64
_IDLE_NS = 600_000_000_000
"""A handle that was not used for so long is closed; its client must be gone."""

_FAILED = struct.pack("<i", -1)
_HANDLE = struct.Struct("<I")
_SEEK = struct.Struct("<iI")
_POSITION = struct.Struct("<i")

_NO_SEEK = 0xFFFF_FFFF
_LARGEST_READ = 16 << 20
_LARGEST_FILE = 1 << 30
"""Bytes to which a client may make a file grow."""

_MOST_MATCHES = 400_000
"""Names that all open searches together still have to return."""

FIND_ENTRY = struct.Struct("<II3QII8x260s16x")
"""Handle, attributes, times of creation, access and writing, size (high, low), name."""

_FOLDER, _FILE, _READ_ONLY = 0x10, 0x20, 0x01


class _Open:
    """State of a handle: an open file, or the remaining names of a search."""

    def __init__(
        self,
        client: bytes,
        file: io.FileIO | None = None,
        folder: Path | None = None,
        names: Sequence[str] = (),
    ) -> None:
        self.client = client
        self.file = file
        self.folder = folder or Path()
        self.rest = deque(names)
        """Names in `folder`."""
        self.used = 0


class Files:
    """Open files of all clients, below one folder; without a folder every service is refused.

    With a `worker` it does what takes the disk, and answers come later; without one, in virtual
    time, they come at once. While there is a worker, only its thread touches what is open.
    """

    def __init__(self, folder: Folder | None, clock: Callable[[], int]) -> None:
        self.worker: FileWorker | None = None
        self._folder = folder
        self._clock = clock
        self._open: dict[int, _Open] = {}
        self._last = FIRST_HANDLE - 1

    # services ----------------------------------------------------------------------------------

    def groups(self) -> Iterable[IndexGroup]:
        """Yield the index groups of both forms."""
        for number, mode in ((100, "w+"), (101, "r"), (102, "r+")):
            yield self._group(
                number, f"open ({mode})", self._opener(mode), "path", "handle, -1 if it cannot be"
            )
        yield self._group(120, "open file", self._open_file, "path", "handle")
        yield self._group(121, "close file", self._close_file)
        yield self._group(122, "read file", self._read, "", "BYTE[n]")
        yield self._group(123, "write file", self._write, "BYTE[n]")
        yield self._group(124, "seek", self._seek, "DINT position, UDINT origin")
        yield self._group(125, "tell", self._file_position, "", "DINT position")
        yield self._group(
            126, "read line", self._read_line, "", "text with NUL, nothing at the end"
        )
        yield self._group(127, "write text", self._write_text, "text with NUL")
        yield self._group(130, "at end", self._at_end, "", "UDINT")
        yield self._group(131, "delete", self._delete, "path")
        yield self._group(132, "rename", self._rename, "two paths with NUL")
        yield self._group(133, "find", self._find, "pattern; nothing for the next one", "entry")
        yield self._group(138, "make folder", self._make_folder, "path")
        yield self._group(139, "remove folder", self._remove_folder, "path")
        yield RawGroup(
            111, "close handle", write=self._close_handle_later, request="UDINT", source=__name__
        )
        yield _HandleGroup(self)

    def _group(
        self,
        number: int,
        name: str,
        serve: Callable[[int, int, bytes, bytes], bytes],
        request: str = "",
        response: str = "",
    ) -> RawGroup:
        def served(offset: int, length: int, data: bytes, client: bytes) -> bytes:
            return self.beside(client, len(data), lambda: serve(offset, length, data, client))

        return RawGroup(
            number,
            name,
            read_write=served,
            request=request,
            response=response,
            last_offset=0xFFFF_FFFF,
            source="000 §5.1" if number < 110 else "",
        )

    def beside(self, client: bytes, size: int, job: Callable[[], bytes]) -> bytes:
        """Return the result of `job`; with a worker, raise `Deferred` and answer later."""
        if self.worker is None:
            return job()
        raise self.worker.later(client, size, job)

    # handles -----------------------------------------------------------------------------------

    @property
    def clients(self) -> set[bytes]:
        """Clients that have something open."""
        return {entry.client for entry in list(self._open.values())}

    def __len__(self) -> int:
        return len(self._open)

    def end_client(self, client: bytes) -> None:
        """Close what a client has open, and forget what it still wants."""
        if self.worker is None:
            self._end(client)
        else:
            self.worker.end_client(client, lambda: self._end(client))

    def _end(self, client: bytes) -> None:
        for handle in [h for h, entry in self._open.items() if entry.client == client]:
            self._close(handle)

    def close_all(self) -> None:
        """Close whatever is open."""
        for handle in list(self._open):
            self._close(handle)

    def sweep(self, now_ns: int) -> None:
        """Close what was not used for ten minutes."""
        idle = [h for h, e in list(self._open.items()) if now_ns - e.used > _IDLE_NS]
        if idle and self.worker is None:
            self._close_idle(now_ns)
        elif idle and self.worker is not None:
            self.worker.do(b"", lambda: self._close_idle(now_ns))

    def _close_idle(self, now_ns: int) -> None:
        for handle in [h for h, e in self._open.items() if now_ns - e.used > _IDLE_NS]:
            self._close(handle)

    def _close(self, handle: int) -> None:
        file = self._open.pop(handle).file
        if file is not None:
            with device_errors():
                file.close()

    def _room(self, client: bytes) -> None:
        open_count = sum(entry.client == client for entry in self._open.values())
        if open_count >= _PER_CLIENT or len(self._open) >= _HANDLES:
            raise DeviceError(ReturnCode.NO_MORE_HANDLES, f"{open_count} files are open")

    def _keep(self, entry: _Open) -> int:
        entry.used = self._clock()
        handle = self._last
        while True:
            handle = FIRST_HANDLE + (handle + 1 - FIRST_HANDLE) % _HANDLES
            if handle not in self._open:
                break
        self._last = handle
        self._open[handle] = entry
        return handle

    def _entry(self, handle: int, client: bytes) -> _Open:
        entry = self._open.get(handle)
        if entry is None or entry.client != client:
            raise DeviceError(ReturnCode.NOT_FOUND, f"file handle 0x{handle:X}")
        entry.used = self._clock()
        return entry

    def file(self, handle: int, client: bytes, *, to: str = "") -> io.FileIO:
        """Return the open file of a client; `to`: "read" or "write" must be what it was opened
        for."""
        file = self._entry(handle, client).file
        if (
            file is None
            or (to == "read" and not file.readable())
            or (to == "write" and not file.writable())
        ):
            raise DeviceError(ReturnCode.INCOMPATIBLE, f"0x{handle:X} was not opened to {to}")
        return file

    @property
    def folder(self) -> Folder:
        if self._folder is None:
            raise DeviceError(
                ReturnCode.SERVICE_NOT_SUPPORTED, "this station shows no folder ([system] root)"
            )
        return self._folder

    # open and close ----------------------------------------------------------------------------

    def _opener(self, mode: str) -> Callable[[int, int, bytes, bytes], bytes]:
        def serve(offset: int, length: int, data: bytes, client: bytes) -> bytes:
            path = self.folder.path
            try:
                handle = self._open_path(path(data, offset), mode, client)
            except DeviceError as refusal:
                if refusal.code != ReturnCode.NOT_FOUND.number:
                    raise
                return _FAILED
            if mode == "r+":
                self.file(handle, client).truncate(0)
            return _HANDLE.pack(handle)

        return serve

    def _open_file(self, offset: int, length: int, data: bytes, client: bytes) -> bytes:
        flags, place = offset & 0xFFFF, offset >> 16
        letter = _C_MODES.get(flags & 0x07)
        if letter is None or flags & ~OpenMode.KNOWN or flags & 0x30 == 0x30:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"open mode 0x{flags:X}")
        path = self.folder.path(data, place)
        if flags & OpenMode.ENSURE_FOLDER and letter != "r":
            with device_errors():
                path.parent.mkdir(parents=True, exist_ok=True)
        mode = letter + ("+" if flags & OpenMode.PLUS else "")
        return _HANDLE.pack(self._open_path(path, mode, client))

    def _open_path(self, path: Path, mode: str, client: bytes) -> int:
        self._room(client)
        with device_errors():
            if path.exists() and not path.is_file():
                raise DeviceError(ReturnCode.NOT_FOUND, f"{path.name} is not a file")
            file = io.FileIO(path, mode)
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                file.close()
                raise DeviceError(ReturnCode.NOT_FOUND, f"{path.name} is not a file")
        return self._keep(_Open(client, file))

    def _close_file(self, offset: int, length: int, data: bytes, client: bytes) -> bytes:
        self.close(offset, client)
        return b""

    def close(self, handle: int, client: bytes) -> None:
        """Close a handle of a client; raises DeviceError 0x70C if it has none."""
        self._entry(handle, client)
        self._close(handle)

    def _close_handle_later(self, offset: int, data: bytes, client: bytes) -> None:
        if len(data) != 4:
            raise DeviceError(ReturnCode.INVALID_SIZE, f"a handle has 4 bytes, got {len(data)}")
        handle = _HANDLE.unpack(data)[0]
        self.beside(client, 0, lambda: self._close_file(handle, 0, b"", client))

    # read and write ----------------------------------------------------------------------------

    def _read(self, offset: int, length: int, data: bytes, client: bytes) -> bytes:
        return self.read(self.file(offset, client, to="read"), length)

    def read(self, file: io.FileIO, length: int) -> bytes:
        """Return up to `length` bytes; the size of the file decides, not the request."""
        with device_errors():
            left = os.fstat(file.fileno()).st_size - file.tell()
            return file.read(max(min(length, left, _LARGEST_READ), 0)) or b""

    def _write(self, offset: int, length: int, data: bytes, client: bytes) -> bytes:
        self.write(self.file(offset, client, to="write"), data)
        return b""

    def write(self, file: io.FileIO, data: bytes) -> None:
        """Write all of `data`; 0x70A if the file would become too large."""
        with device_errors():
            if file.tell() + len(data) > _LARGEST_FILE:
                raise DeviceError(ReturnCode.DEVICE_NO_MEMORY, f"more than {_LARGEST_FILE} bytes")
            rest = memoryview(data)
            while rest:
                rest = rest[file.write(rest) :]

    def _read_line(self, offset: int, length: int, data: bytes, client: bytes) -> bytes:
        file = self.file(offset, client, to="read")
        with device_errors():
            line = file.readline(max(min(length, _LARGEST_READ) - 1, 0))
        return line + b"\0" if line else b""

    def _write_text(self, offset: int, length: int, data: bytes, client: bytes) -> bytes:
        self.write(self.file(offset, client, to="write"), data.partition(b"\0")[0])
        return b""

    def _seek(self, offset: int, length: int, data: bytes, client: bytes) -> bytes:
        if len(data) != _SEEK.size:
            raise DeviceError(ReturnCode.INVALID_SIZE, f"seek with {len(data)} bytes")
        file = self.file(offset, client)
        position, origin = _SEEK.unpack(data)
        with device_errors():
            bases = (0, file.tell(), os.fstat(file.fileno()).st_size)
            if origin > 2 or bases[origin] + position < 0:
                raise DeviceError(
                    ReturnCode.INVALID_PARAMETER, f"seek {position} from origin {origin}"
                )
            file.seek(bases[origin] + position)
        return b""

    def _file_position(self, offset: int, length: int, data: bytes, client: bytes) -> bytes:
        file = self.file(offset, client)
        with device_errors():
            return _POSITION.pack(min(file.tell(), 0x7FFF_FFFF))

    def _at_end(self, offset: int, length: int, data: bytes, client: bytes) -> bytes:
        file = self.file(offset, client)
        with device_errors():
            return _HANDLE.pack(file.tell() >= os.fstat(file.fileno()).st_size)

    # names -------------------------------------------------------------------------------------

    def _delete(self, offset: int, length: int, data: bytes, client: bytes) -> bytes:
        path = self.folder.path(data, offset >> 16, itself=True)
        with device_errors():
            if offset & OpenMode.ENABLE_FOLDER and path.is_dir() and not path.is_symlink():
                path.rmdir()
            else:
                path.unlink()
        return b""

    def _rename(self, offset: int, length: int, data: bytes, client: bytes) -> bytes:
        old, nul, new = data.removesuffix(b"\0").partition(b"\0")
        if not nul:
            raise DeviceError(ReturnCode.INVALID_SIZE, "rename takes two names")
        source = self.folder.path(old, offset >> 16, itself=True)
        target = self.folder.path(new, offset >> 16, itself=True)
        if target == source:  # only the case changes
            target = source.with_name(self.folder.last_name(new, offset >> 16))
        with device_errors():
            if target.exists() or target.is_symlink():
                raise DeviceError(ReturnCode.EXISTS, target.name)
            source.rename(target)
        return b""

    def _make_folder(self, offset: int, length: int, data: bytes, client: bytes) -> bytes:
        path = self.folder.path(data, offset >> 16 or offset)
        with device_errors():
            path.mkdir()
        return b""

    def _remove_folder(self, offset: int, length: int, data: bytes, client: bytes) -> bytes:
        path = self.folder.path(data, offset >> 16 or offset, itself=True)
        with device_errors():
            path.rmdir()
        return b""

    def _find(self, offset: int, length: int, data: bytes, client: bytes) -> bytes:
        if offset >= FIRST_HANDLE and offset >> 16 == 0:
            handle = offset
            entry = self._entry(handle, client)
        else:
            self._room(client)
            with device_errors():
                folder, names = self.folder.matching(data, offset >> 16 or offset)
            if sum(len(other.rest) for other in self._open.values()) + len(names) > _MOST_MATCHES:
                raise DeviceError(ReturnCode.DEVICE_NO_MEMORY, "searches have too many names left")
            entry = _Open(client, folder=folder, names=names)
            handle = self._keep(entry)
        while entry.rest:
            path = entry.folder / entry.rest.popleft()
            try:
                if self.folder.holds(path):
                    return self._describe(handle, path)
            except OSError:  # gone since
                continue
        self._close(handle)
        raise DeviceError(ReturnCode.NOT_FOUND, "nothing more is found")

    def _describe(self, handle: int, path: Path) -> bytes:
        facts = path.stat()
        attributes = _FOLDER if stat.S_ISDIR(facts.st_mode) else _FILE
        if not facts.st_mode & stat.S_IWUSR:
            attributes |= _READ_ONLY
        times = (
            max(from_unix_ns(time), 0)
            for time in (facts.st_ctime_ns, facts.st_atime_ns, facts.st_mtime_ns)
        )
        size = facts.st_size
        return FIND_ENTRY.pack(
            handle, attributes, *times, size >> 32, size & 0xFFFF_FFFF, as_name(path)[:259]
        )


class _HandleGroup(IndexGroup):
    """The older form: the handle of an open file as index group, the position as offset."""

    def __init__(self, files: Files) -> None:
        self._files = files

    def index_groups(self) -> Iterable[int]:
        return range(FIRST_HANDLE, FIRST_HANDLE + _HANDLES)

    def describe(self) -> Iterator[RowFacts]:
        yield RowFacts(
            index_group=FIRST_HANDLE,
            last_index_group=FIRST_HANDLE + _HANDLES - 1,
            index_offset=0,
            last_index_offset=0xFFFF_FFFF,
            access=READ | WRITE | READ_WRITE,
            name="open file",
            layout="BYTE[n]",
            description="The offset is the position, -1 goes on; reading nothing only moves there;"
            " writing nothing at -1 closes. ReadWrite writes and answers the number of bytes"
            " written, -1 if that cannot be.",
            source="000 §5.1",
        )

    def watch(self, group: int, offset: int, length: int, client: bytes) -> NoReturn:
        raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, "open files are not watched")

    def read(self, group: int, offset: int, length: int, client: bytes) -> bytes:
        return self._files.beside(client, 0, lambda: self._read(group, offset, length, client))

    def write(self, group: int, offset: int, data: bytes, client: bytes) -> None:
        self._files.beside(client, len(data), lambda: self._write(group, offset, data, client))

    def read_write(
        self, group: int, offset: int, read_length: int, data: bytes, client: bytes
    ) -> bytes:
        def written() -> bytes:
            try:
                self._write(group, offset, data, client)
            except DeviceError as refusal:
                if refusal.code == ReturnCode.NOT_FOUND.number:  # no such handle
                    raise
                return _FAILED[:read_length]
            return _HANDLE.pack(len(data))[:read_length]

        return self._files.beside(client, len(data), written)

    def _read(self, group: int, offset: int, length: int, client: bytes) -> bytes:
        file = self._files.file(group, client, to="read" if length else "")
        if offset != _NO_SEEK:
            with device_errors():
                file.seek(offset)
        return self._files.read(file, length) if length else b""

    def _write(self, group: int, offset: int, data: bytes, client: bytes) -> bytes:
        if not data and offset == _NO_SEEK:
            self._files.close(group, client)
            return b""
        file = self._files.file(group, client, to="write")
        if offset != _NO_SEEK:
            with device_errors():
                file.seek(offset)
        self._files.write(file, data)
        return b""
