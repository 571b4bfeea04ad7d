"""Registry services of the system service: keys and values in memory, never those of the computer.

Groups 200 to 202 read, write and enumerate the keys of a hive, 206 to 208 delete one. The registry
is empty at the start of the program and ends with it.

Source: public clients of the vendor (registry export, import and its test); texts end with NUL.
"""

import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import islice
from typing import TypeVar

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.server import IndexGroup, RawGroup

T = TypeVar("T")

HIVES = {200: "HKEY_LOCAL_MACHINE", 201: "HKEY_CURRENT_USER", 202: "HKEY_CLASSES_ROOT"}
"""Hives by the index group that reads and writes them; deletion is 6 above."""

_DELETION = 6

MOST_BYTES = 1 << 20
"""Bytes of all names and values together."""

_PER_ENTRY = 256
"""Bytes that a key or value counts beside its texts."""

_DEEPEST = 64
"""Keys within keys."""

_KIND = 0xC000_0000
"""Bits of the offset that say what is enumerated; the others are the index."""
_KEYS = 0x0000_0000
_VALUES = 0xC000_0000

_TYPE = struct.Struct("<I")


@dataclass(slots=True)
class _Value:
    """A value with its name as it was written first."""

    name: bytes
    type: int
    data: bytes

    @property
    def size(self) -> int:
        return _PER_ENTRY + len(self.name) + len(self.data)


@dataclass(slots=True)
class _Key:
    """A key: its values and the keys within it by folded name."""

    name: bytes
    values: dict[bytes, _Value] = field(default_factory=dict)
    keys: dict[bytes, "_Key"] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """Bytes that it counts with all that is within it."""
        own = _PER_ENTRY + len(self.name) + sum(value.size for value in self.values.values())
        return own + sum(key.size for key in self.keys.values())


class Registry:
    """Hives of a station. Case does not matter in names of keys and values."""

    def __init__(self) -> None:
        self._hives = {group: _Key(name.encode()) for group, name in HIVES.items()}
        self._bytes = 0

    def groups(self) -> Iterable[IndexGroup]:
        for group, hive in HIVES.items():
            yield RawGroup(
                group,
                f"registry {hive}",
                read_write=self._reader(group),
                write=self._writer(group),
                last_offset=0xFFFF_FFFF,
                request="key; ReadWrite may add a value's name, Write adds name, UDINT type, data",
                response="name of a key; name, UDINT type and data of a value; data",
                description="In memory. ReadWrite: data of the named value, else offset n is key n"
                " within the key and 0xC0000000 + n its value n; 0x70C behind the last one."
                " Write: a value, and the keys on the way to it.",
            )
        for group, hive in HIVES.items():
            yield RawGroup(
                group + _DELETION,
                f"delete from registry {hive}",
                write=self._deleter(group),
                request="key with NUL",
                description="Delete a key with all that is in it; 0x1 without such a key.",
            )

    def _reader(self, group: int) -> Callable[[int, int, bytes, bytes], bytes]:
        def read(offset: int, length: int, data: bytes, client: bytes) -> bytes:
            path, rest = _text(data)
            key = self._walk(group, _steps(path))
            if key is None:
                raise DeviceError(ReturnCode.NOT_FOUND, f"registry key {_shown(path)}")
            if rest and offset == 0:
                name, _ = _text(rest)
                value = key.values.get(name.lower())
                if value is None:
                    raise DeviceError(ReturnCode.NOT_FOUND, f"registry value {_shown(name)}")
                return value.data
            return _enumerated(key, offset)

        return read

    def _writer(self, group: int) -> Callable[[int, bytes, bytes], None]:
        def write(offset: int, data: bytes, client: bytes) -> None:
            path, rest = _text(data)
            name, rest = _text(rest)
            if len(rest) < _TYPE.size:
                raise DeviceError(
                    ReturnCode.INVALID_SIZE, f"a registry value has a type, got {len(rest)} bytes"
                )
            self._set(group, path, _Value(name, _TYPE.unpack_from(rest)[0], rest[_TYPE.size :]))

        return write

    def _deleter(self, group: int) -> Callable[[int, bytes, bytes], None]:
        def delete(offset: int, data: bytes, client: bytes) -> None:
            path, rest = _text(data)
            if rest:
                raise DeviceError(
                    ReturnCode.INVALID_DATA, f"expected a key, got {len(rest)} bytes behind it"
                )
            *way, last = _steps(path) or [b""]
            parent = self._walk(group, way)
            key = None if parent is None else parent.keys.pop(last.lower(), None)
            if key is None:
                raise DeviceError(ReturnCode.INTERNAL_ERROR, f"registry key {_shown(path)}")
            self._bytes -= key.size

        return delete

    def _walk(self, group: int, steps: Iterable[bytes]) -> _Key | None:
        key: _Key | None = self._hives[group]
        for step in steps:
            if key is None:
                return None
            key = key.keys.get(step.lower())
        return key

    def _set(self, group: int, path: bytes, value: _Value) -> None:
        """Write a value, and the keys that are missing on the way. Raises DeviceError 0x70A."""
        key, steps = self._hives[group], _steps(path)
        missing = len(steps)
        for step in steps:
            inner = key.keys.get(step.lower())
            if inner is None:
                break
            key, missing = inner, missing - 1
        new = steps[len(steps) - missing :]
        old = None if new else key.values.get(value.name.lower())
        added = value.size + sum(_PER_ENTRY + len(step) for step in new)
        added -= 0 if old is None else old.size
        if self._bytes + added > MOST_BYTES:
            raise DeviceError(ReturnCode.DEVICE_NO_MEMORY, f"the registry has {MOST_BYTES} bytes")
        self._bytes += added
        for step in new:
            key = key.keys.setdefault(step.lower(), _Key(step))
        if old is None:
            key.values[value.name.lower()] = value
        else:
            old.type, old.data = value.type, value.data


def _enumerated(key: _Key, offset: int) -> bytes:
    """Key or value number `offset` of a key, NUL behind its name."""
    kind, index = offset & _KIND, offset & ~_KIND
    if kind == _KEYS:
        entry = _nth(key.keys.values(), index)
        return entry.name + b"\0"
    if kind == _VALUES:
        value = _nth(key.values.values(), index)
        return value.name + b"\0" + _TYPE.pack(value.type) + value.data
    raise DeviceError(ReturnCode.INVALID_OFFSET, f"registry enumeration 0x{offset:X}")


def _nth(entries: Iterable[T], index: int) -> T:
    for entry in islice(entries, index, None):
        return entry
    raise DeviceError(ReturnCode.NOT_FOUND, f"registry entry {index}")


def _text(data: bytes) -> tuple[bytes, bytes]:
    """Return the text that `data` begins with, and what follows its NUL. Raises DeviceError
    0x706."""
    text, end, rest = data.partition(b"\0")
    if not end:
        raise DeviceError(ReturnCode.INVALID_DATA, "expected a text with NUL in a registry request")
    return text, rest


def _steps(path: bytes) -> list[bytes]:
    """Return names of the keys of a path. Raises DeviceError 0x706 for a path that is none."""
    steps = path.split(b"\\") if path else []
    if len(steps) > _DEEPEST or not all(steps):
        raise DeviceError(ReturnCode.INVALID_DATA, f"registry key {_shown(path)}")
    return steps


def _shown(text: bytes) -> str:
    return repr(text.decode("cp1252", "replace"))[:80]
