"""The NC of a controller, seen from outside: its axes by name or id."""

import difflib
from typing import TYPE_CHECKING

from achse.ams.commands import ReadRequest
from achse.client.nc.axis import RemoteAxis
from achse.client.nc.errors import UnknownAxis
from achse.client.nc.services import AXIS_IDS, PARAMETERS, RING0_STATES, named
from achse.client.nc.tables import RemoteTable

if TYPE_CHECKING:
    from achse.client.target import Target

MAX_AXES = 255

MOST_TABLES = 255
"""Ids that one answer has."""


class RemoteNc:
    """An NC at port 500 of a controller, ours or a real one: `client.nc`."""

    def __init__(self, target: "Target") -> None:
        self.target = target

    def __repr__(self) -> str:
        return f"RemoteNc({self.target.address})"

    def axis(self, which: str | int) -> RemoteAxis:
        """Return the axis of that name (case does not count) or id; it is looked for when first
        used.

        Raises ValueError for what cannot be either.
        """
        if isinstance(which, bool) or not isinstance(which, str | int) or which == "":
            raise ValueError(f"an axis is a name or an id, got {which!r:.60}")
        if isinstance(which, int) and not 0 < which <= MAX_AXES:
            raise ValueError(f"an axis id is 1..{MAX_AXES}, got {which}")

        async def find() -> tuple[int, str]:
            return await self._find(str(which))

        return RemoteAxis(self.target, which, find)

    async def ids(self) -> list[int]:
        """Return the ids of all axes."""
        row = named((RING0_STATES,), AXIS_IDS)
        data = await self.target.read_raw(row.group, row.offset, MAX_AXES * _ID_BYTES)
        ids = (data[place : place + _ID_BYTES] for place in range(0, len(data), _ID_BYTES))
        return [number for id in ids if (number := int.from_bytes(id, "little"))]

    async def axes(self) -> list[RemoteAxis]:
        """Return all axes, by id, with their names."""

        async def never() -> tuple[int, str]:
            raise AssertionError("an axis by id is not looked for")

        return [RemoteAxis(self.target, id, never, name) for id, name in await self._names()]

    def table(self, table_id: int) -> RemoteTable:
        """Return the table with that id, there already or not. Raises ValueError for ids that none
        has."""
        return RemoteTable(self.target, table_id)

    async def tables(self) -> list[RemoteTable]:
        """Return all tables that there are, by id."""
        data = await self.target.read_raw(RING0_STATES, _TABLE_IDS, MOST_TABLES * _ID_BYTES)
        ids = (data[place : place + _ID_BYTES] for place in range(0, len(data), _ID_BYTES))
        return [self.table(number) for id in ids if (number := int.from_bytes(id, "little"))]

    async def _names(self) -> list[tuple[int, str]]:
        ids = await self.ids()
        names = named((PARAMETERS,), "axis_name")
        size = names.layout.size
        requests = [ReadRequest(*names.place(id), size) for id in ids]
        answers: list[tuple[int, str]] = []
        for id, outcome in zip(ids, await self.target.send_each(requests), strict=True):
            if outcome.result == 0:  # an axis may go between both questions
                answers.append((id, names.layout.decode(outcome.data.ljust(size, b"\0")[:size])))
        return answers

    async def _find(self, wanted: str) -> tuple[int, str]:
        every = await self._names()
        for id, name in every:
            if name.lower() == wanted.strip().lower():
                return id, name
        near = difflib.get_close_matches(wanted.lower(), [name.lower() for _, name in every])
        hint = f"; did you mean {' or '.join(n for _, n in every if n.lower() in near)}?" * bool(
            near
        )
        there = ", ".join(f"{id} {name}".strip() for id, name in every) or "none"
        raise UnknownAxis(
            0, wanted, f"the NC at {self.target.address} has no such axis{hint}; there are: {there}"
        )


_ID_BYTES = 4

_TABLE_IDS = 0x3A
"""Offset of the ids of all tables (002 §6.4.1.2)."""
