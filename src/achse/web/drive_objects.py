"""Objects of a drive (CoE) as the page shows and writes them: typed, with range and meaning.

What an object is called and may be comes from the rows of the drive, for achse's own drives all of
them, for others those of the profile (CiA 402), whose types are the same everywhere.
"""

import asyncio
import math
import struct
from typing import Any

from achse.ams import AdsError
from achse.client import Target
from achse.drive import IDENTITIES
from achse.drive.objects import ROWS, ObjectRow, find
from achse.web.arguments import Arguments
from achse.web.buses import SDO, BusHandlers
from achse.web.messages import CallError

_IDENTITY = 0x1018
_VENDOR, _PRODUCT = 1, 2
_ASSIGNMENT = 0x1C12
"""RxPDOs that are sent."""

_PROFILE = range(0x6000, 0x7000)
_OWN = range(0x2000, 0x7000)
"""Not those of communication: the master sets them up."""

_AT_ONCE = 16


class DriveObjectHandlers:
    """Reads and writes objects of drives by their station addresses."""

    def __init__(self, buses: BusHandlers) -> None:
        self._buses = buses

    async def listed(self, arguments: Arguments) -> list[dict[str, Any]]:
        """Call `drives.objects`: those that the drive has, with their values now."""
        station = arguments.integer("drive", None, 1, 0xFFFE)
        master, slave = await self._buses.slave(station)
        rows = await self._rows(slave)
        sent = await self._sent(master, slave, station)
        room = asyncio.Semaphore(_AT_ONCE)

        async def read(row: ObjectRow) -> float | None:
            async with room:
                return await _read(slave, row)

        values = await asyncio.gather(*map(read, rows))
        return [
            _shown(row, value, sent)
            for row, value in zip(rows, values, strict=True)
            if value is not None
        ]

    async def write(self, arguments: Arguments) -> dict[str, Any]:
        """Call `drives.write`: set an object by its key; what it was before and what it is now.

        Raises CallError for a value of another type or out of range, before anything is sent.
        """
        station = arguments.integer("drive", None, 1, 0xFFFE)
        master, slave = await self._buses.slave(station)
        row = _row_of(arguments.text("key"), await self._rows(slave))
        if not _writable(row, await self._sent(master, slave, station)):
            raise CallError(f"{row.name}: expected an object that may be written")
        data = _packed(row, arguments.value("value"))
        before = await _read(slave, row)
        await slave.write_raw(SDO, row.index << 16 | row.subindex, data)
        return {"value": await _read(slave, row), "before": before}

    async def _sent(self, master: Target, slave: Target, station: int) -> set[int]:
        """Objects that the master sends with each frame, as `ObjectRow.key` numbers them."""
        if await self._buses.state(master, station) not in ("OP", "SAFEOP"):
            return set()
        indices: set[int] = set()
        for mapping in await _list(slave, _ASSIGNMENT, "<H"):
            indices |= {entry >> 8 for entry in await _list(slave, mapping, "<I")}
        return indices

    async def _rows(self, slave: Target) -> list[ObjectRow]:
        numbers = [await _read(slave, find(_IDENTITY, each)) for each in (_VENDOR, _PRODUCT)]
        own = numbers in [[each.vendor_id, each.product_code] for each in IDENTITIES.values()]
        return [row for row in ROWS if row.index in (_OWN if own else _PROFILE)]


async def _list(slave: Target, index: int, form: str) -> list[int]:
    """Return the entries of an object that begins with their count; none without it."""
    size, offset = struct.calcsize(form), index << 16
    try:
        count = (await slave.read_raw(SDO, offset, 1))[0]
        requests = [slave.read_raw(SDO, offset | n, size) for n in range(1, count + 1)]
        return [int(struct.unpack(form, data)[0]) for data in await asyncio.gather(*requests)]
    except (AdsError, IndexError, struct.error):
        return []


async def _read(slave: Target, row: ObjectRow) -> float | None:
    """Return the value; None if the drive has no such object, or one of another size."""
    size = row.type.bits // 8
    try:
        data = await slave.read_raw(SDO, row.index << 16 | row.subindex, size)
    except AdsError:
        return None
    return struct.unpack(row.type.form, data)[0] if len(data) == size else None


def _row_of(key: str, rows: list[ObjectRow]) -> ObjectRow:
    for row in rows:
        if _key(row) == key:
            return row
    raise CallError(f"key: expected one as `drives.objects` gives it, got {key!r:.60}")


def _packed(row: ObjectRow, value: Any) -> bytes:
    """Return the value as the drive takes it."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if number and not row.type.is_real and isinstance(value, float) and value.is_integer():
        value = int(value)
    if not number or (isinstance(value, float) and not (row.type.is_real and math.isfinite(value))):
        expected = "a number" if row.type.is_real else "a whole number"
        raise CallError(f"{row.name}: expected {expected}, got {value!r:.60}")
    if row.values and value not in row.values:
        expected = ", ".join(map(str, row.values))
        raise CallError(f"{row.name}: expected one of {expected}, got {value}")
    if not row.least <= value <= row.most:
        raise CallError(f"{row.name}: expected {row.least:g}..{row.most:g}, got {value:.17g}")
    return struct.pack(row.type.form, value)


def _key(row: ObjectRow) -> str:
    return f"{row.index:04X}:{row.subindex:02X}"


def _writable(row: ObjectRow, sent: set[int]) -> bool:
    """Return True if pages may write the object; only the master writes the objects in `sent`."""
    return row.writable and row.key not in sent


def _shown(row: ObjectRow, value: float, sent: set[int]) -> dict[str, Any]:
    return {
        "key": _key(row),
        "name": row.name,
        "value": value,
        "unit": row.unit,
        "minimum": row.least,
        "maximum": row.most,
        "choices": [{"value": each, "name": str(each)} for each in row.values] or None,
        "writable": _writable(row, sent),
        "meaning": row.doc,
        "link": None,
    }
