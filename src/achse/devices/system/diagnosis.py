"""IPC diagnosis (MDP), group 0xF302 of the system service: what a station can say of its computer.

The offset is index << 16 | flags << 8 | sub-index; the index is area << 12 | module << 4 | table.
Area 1 is general, 8 has modules, 15 lists them: number, then type << 16 | id. Source: manual of
TcMDP, addressing; tables and sub-indices as the parameter keys of Tc3_IPCDiag have them.
"""

import platform
from collections.abc import Callable, Iterable, Iterator, Mapping

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.router.routes import RouteTable
from achse.server import Device, IndexGroup, RawGroup

_MODULES = 8
"""The area that has modules."""
_DEVICE_NAME = 0x1008
_MODULE_LIST = 15 << 12 | 2 << 4
_TIME, _TWINCAT, _CPU, _OS = 3, 8, 11, 24
_IDS = {_TWINCAT: 1, _CPU: 2, _OS: 3, _TIME: 4}
"""Modules by type."""
_NAME = 3
"""Sub-index of a module's name, in its table 0."""

Value = Callable[[], bytes]


class Diagnosis:
    """Values of a station `name`, by address; every other address is refused with 0x703."""

    def __init__(
        self,
        name: str,
        device: Device,
        routes: RouteTable,
        version: tuple[int, int, int],
        clock: Callable[[], int],
    ) -> None:
        self._device = device
        self._version = version
        self._routes = routes
        self._clock = clock
        self._values: Mapping[tuple[int, int], Value] = {
            (_DEVICE_NAME, 0): lambda: _text(name),
            (_MODULE_LIST, 0): lambda: _number(len(_IDS), 2),
            **{
                (_MODULE_LIST, number): _constant(kind << 16 | identity, 4)
                for number, (kind, identity) in enumerate(_IDS.items(), 1)
            },
            **dict(self._twincat()),
            **dict(self._computer()),
            (_index(_TIME, 1), 3): lambda: _number(self._clock() // 1_000_000_000, 4),
        }

    def groups(self) -> Iterable[IndexGroup]:
        yield RawGroup(
            0xF302,
            "IPC diagnosis",
            read=self._read,
            response="text with NUL, or a number",
            last_offset=0xFFFF_FFFF,
            description="Offset = index << 16 | flags << 8 | sub-index of the MDP.",
        )

    def _twincat(self) -> Iterator[tuple[tuple[int, int], Value]]:
        table = _index(_TWINCAT, 1)
        version, revision, build = self._version
        yield (_index(_TWINCAT, 0), _NAME), lambda: _text("TwinCAT")
        yield (table, 1), _constant(version, 2)
        yield (table, 2), _constant(revision, 2)
        yield (table, 3), _constant(build, 2)
        yield (table, 12), _constant(0, 2)
        yield (table, 4), lambda: _text(str(self._device.address.net_id))
        yield (table, 6), lambda: _number(self._device.ads_state, 2)
        yield (_index(_TWINCAT, 2), 0), lambda: _number(len(self._routes), 2)

    def _computer(self) -> Iterator[tuple[tuple[int, int], Value]]:
        yield (_index(_CPU, 0), _NAME), lambda: _text(platform.processor() or platform.machine())
        yield (_index(_OS, 0), _NAME), lambda: _text(platform.system())
        release = platform.release().partition("-")[0].split(".")
        for sub, part in enumerate((*release, "", "", "")[:3], 1):
            number = int(part) if part.isdecimal() else 0
            yield (_index(_OS, 1), sub), _constant(number & 0xFFFF_FFFF, 4)

    def _read(self, offset: int, length: int, client: bytes) -> bytes:
        index, sub = offset >> 16, offset & 0xFF
        value = self._values.get((index, sub))
        if value is not None:
            return value()
        if sub and index in _ROUTE_TABLES:
            routes = list(self._routes)
            if sub <= len(routes):
                return _text(str(getattr(routes[sub - 1], _ROUTE_TABLES[index])))
        raise DeviceError(ReturnCode.INVALID_OFFSET, f"the station knows no 0x{index:X}:{sub}")


def _index(kind: int, table: int) -> int:
    return _MODULES << 12 | _IDS[kind] << 4 | table


_ROUTE_TABLES = {
    _index(_TWINCAT, 2): "name",
    _index(_TWINCAT, 3): "host",
    _index(_TWINCAT, 4): "net_id",
}
"""Lists of the routes: what of a route each has."""


def _number(value: int, size: int) -> bytes:
    return (value & (1 << 8 * size) - 1).to_bytes(size, "little")


def _constant(value: int, size: int) -> Value:
    return lambda: _number(value, size)


def _text(text: str) -> bytes:
    return text.encode("cp1252", "replace") + b"\0"
