"""Tables of an NC, seen from outside: cams by rows, motion functions by points.

Services of 002 §6.4.8: parameters at 0xA000 + id, states at 0xA100 + id, functions at 0xA200 + id;
ids above 255 are on pages of their own.
"""

import struct
from collections.abc import Sequence
from enum import IntEnum
from typing import TYPE_CHECKING, NamedTuple

from achse.client.nc.arguments import real

if TYPE_CHECKING:
    from achse.client.target import Target

_PARAMETERS, _STATES, _FUNCTIONS = 0xA000, 0xA100, 0xA200
_NAME, _FACTS, _ROWS, _POINTS, _LAST = 0x02, (0x01, 0x03, 0x04, 0x10, 0x11), 1 << 24, 5 << 24, 0xFF
_USERS, _VALUES, _CHARACTERISTIC = 0x0A, 0x23, 0x50
_CREATE = {1: 0x1_0000, 10: 0x1_0001, 16: 0x1_0010}
_DELETE, _INITIALISE, _ONLINE = 0x2_0000, 0x3_0000, 0x1A
_POINT = struct.Struct("<IHHiI5d")
_NAME_BYTES = 31
_CHARACTERISTIC_BYTES = 512
_HIGHEST_ID = 4095

_PER_REQUEST = 4096
"""Rows of one request."""


class TableKind(IntEnum):
    """Use of a table (main type)."""

    CAM = 1
    CHARACTERISTIC = 10
    MOTION_FUNCTION = 16


class TableFacts(NamedTuple):
    """Properties of a table."""

    id: int
    name: str
    kind: TableKind
    sub_type: int
    """1 equidistant, 2 equidistant cyclic, 3 monotonic, 4 monotonic cyclic."""
    rows: int
    columns: int
    users: int

    @property
    def cyclic(self) -> bool:
        return self.sub_type % 2 == 0


class FunctionPoint(NamedTuple):
    """A point of a motion function, and the law of the segment that begins there.

    Positions in units of master and slave, derivatives per unit of the master.
    """

    master: float
    slave: float
    law: int = 5
    """Function type: 1 straight line, 5 rest to rest, 12 Bestehorn, 15 motion to motion …"""
    velocity: float = 0.0
    acceleration: float = 0.0
    jerk: float = 0.0
    point_type: int = 0
    """1: the point is passed over."""


class TableValues(NamedTuple):
    """Set values that a table demands of a slave; velocity is per master velocity, and so on."""

    position: float
    velocity: float
    acceleration: float


class RemoteTable:
    """A table of an NC, there already or not. All methods raise `DeviceError` with its code.

    0x4016: no table has this id, 0x4063: the id is taken, 0x4259: the table is in use.
    """

    def __init__(self, nc: "Target", table_id: int) -> None:
        if not isinstance(table_id, int) or not 1 <= table_id <= _HIGHEST_ID:
            raise ValueError(f"a table id is 1..{_HIGHEST_ID}, got {table_id!r:.60}")
        self.nc = nc
        self.id = table_id

    def __repr__(self) -> str:
        return f"RemoteTable({self.id} of {self.nc})"

    def _group(self, base: int) -> int:
        return base + (self.id & _LAST) + (self.id >> 8 << 16)

    async def _number(self, base: int, offset: int) -> int:
        return int.from_bytes(await self.nc.read_raw(self._group(base), offset, 4), "little")

    async def facts(self) -> TableFacts:
        """Name, kind and size."""
        id, sub_type, kind, rows, columns = [
            await self._number(_PARAMETERS, offset) for offset in _FACTS
        ]
        data = await self.nc.read_raw(self._group(_PARAMETERS), _NAME, _NAME_BYTES)
        name = data.split(b"\0", 1)[0].decode("cp1252", "replace")
        users = await self._number(_STATES, _USERS)
        return TableFacts(id, name, TableKind(kind), sub_type, rows, columns, users)

    async def slave_type(self) -> int:
        """Return the slave type that follows such a table: 10 a cam, 13 a motion function."""
        kind = await self._number(_PARAMETERS, _FACTS[2])
        return 13 if kind == TableKind.MOTION_FUNCTION else 10

    async def create(
        self, rows: int, *, kind: TableKind = TableKind.CAM, cyclic: bool = False, columns: int = 2
    ) -> None:
        """Make the table, all 0; its places need not have equal steps. It has 2 rows or more.

        0x4A02 and 0x4A03: so many rows or columns are not allowed, 0x4A11: no memory.
        """
        if kind == TableKind.MOTION_FUNCTION:
            columns = 1
        data = struct.pack("<3I", 4 if cyclic else 3, rows, columns)
        await self.nc.write_raw(self._group(_FUNCTIONS), _CREATE[kind], data)

    async def delete(self) -> None:
        """Forget the table; 0x4259 while a slave or a drive uses it."""
        await self.nc.write_raw(self._group(_FUNCTIONS), _DELETE, b"")

    async def check(self) -> None:
        """See whether its numbers are a function; 0x4A06: places do not rise, 0x4A08: no law."""
        await self.nc.write_raw(self._group(_FUNCTIONS), _INITIALISE, b"")

    async def read_rows(self) -> list[tuple[float, ...]]:
        """Return all rows of a cam or a characteristic: place, value."""
        facts = await self.facts()
        row = struct.Struct(f"<{facts.columns}d")
        data = b""
        for first in range(0, facts.rows, _PER_REQUEST):
            count = min(_PER_REQUEST, facts.rows - first)
            data += await self.nc.read_raw(
                self._group(_PARAMETERS), _ROWS + first, row.size * count
            )
        return list(row.iter_unpack(data))

    async def write_rows(self, rows: Sequence[Sequence[float]], first: int = 0) -> None:
        """Write whole rows of a cam or a characteristic from one on, counted from 0."""
        for begin in range(0, len(rows), _PER_REQUEST):
            part = rows[begin : begin + _PER_REQUEST]
            numbers = [real("row", number) for row in part for number in row]
            data = struct.pack(f"<{len(numbers)}d", *numbers)
            await self.nc.write_raw(self._group(_PARAMETERS), _ROWS + first + begin, data)

    async def read_points(self) -> list[FunctionPoint]:
        """Return all points of a motion function."""
        facts = await self.facts()
        data = b""
        for first in range(0, facts.rows, _PER_REQUEST):
            count = min(_PER_REQUEST, facts.rows - first)
            data += await self.nc.read_raw(
                self._group(_PARAMETERS), _POINTS + first, _POINT.size * count * facts.columns
            )
        points = list(_POINT.iter_unpack(data))[:: facts.columns]
        return [
            FunctionPoint(master, slave, law, velocity, acceleration, jerk, kind)
            for _, law, kind, _, _, master, slave, velocity, acceleration, jerk in points
        ]

    async def write_points(self, points: Sequence[FunctionPoint], first: int = 0) -> None:
        """Write points of a motion function from one on, counted from 0.

        Slaves that follow it change over as `change_when` said, at once unless it did.
        """
        for begin in range(0, len(points), _PER_REQUEST):
            data = b"".join(
                _POINT.pack(
                    *(first + begin + n + 1, point.law, point.point_type, 1, 0),
                    *(real("point", number) for number in (*point[:2], *point[3:6])),
                )
                for n, point in enumerate(points[begin : begin + _PER_REQUEST])
            )
            await self.nc.write_raw(self._group(_PARAMETERS), _POINTS + first + begin, data)

    async def change_when(
        self, activation: int, position: float = 0.0, *, keep_place: bool = False
    ) -> None:
        """Set the time at which written points become active: 0 at once, 1 at a master position of
        the cam, 2 at a master position of the axis, 3 at the end of the cycle. `keep_place` shifts
        the offsets so that the slave continues from its present position (auto offset)."""
        scaling = int(keep_place)
        data = struct.pack("<I4xdII", activation, real("position", position), scaling, scaling)
        await self.nc.write_raw(self._group(_PARAMETERS), _ONLINE, data)

    async def values(self, master: float) -> TableValues:
        """Slave position, velocity and acceleration at a master position (velocity 1 of it)."""
        data = await self.nc.read_write_raw(
            self._group(_PARAMETERS), _VALUES, 24, struct.pack("<d", real("master", master))
        )
        return TableValues(*struct.unpack("<3d", data))

    async def demands(self, master_velocity: float = 1.0) -> tuple[float, ...]:
        """Return the 31 characteristic values at a master velocity (002 §6.4.9), extremes and
        means."""
        data = await self.nc.read_write_raw(
            self._group(_PARAMETERS),
            _CHARACTERISTIC,
            _CHARACTERISTIC_BYTES,
            struct.pack("<d504x", real("master_velocity", master_velocity)),
        )
        return struct.unpack_from("<31d", data)
