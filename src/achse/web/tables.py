"""Cam tables and channels of the NC: curves, and paths as far as they were driven."""

import asyncio
import struct
from collections import deque
from collections.abc import Sequence
from typing import Any

from achse.ams import AdsError, DeviceError
from achse.client.nc import RemoteTable
from achse.codes import NcError
from achse.web.arguments import Arguments
from achse.web.shared_subscriptions import SharedSubscription
from achse.web.watched import NC_PORT, WatchedTarget

_MOST_POINTS = 2000


class TableHandlers:
    """Cam tables as curves."""

    def __init__(self, watched: WatchedTarget) -> None:
        self._nc = watched.device(NC_PORT).nc

    async def tables(self, arguments: Arguments) -> list[dict[str, Any]]:
        """Call `tables.list`: what tables there are."""
        facts = [await table.facts() for table in await self._nc.tables()]
        return [
            {
                "table": each.id,
                "name": each.name,
                "kind": each.kind.name.lower().replace("_", " "),
                "cyclic": each.cyclic,
                "rows": each.rows,
                "users": each.users,
            }
            for each in facts
        ]

    async def points(self, arguments: Arguments) -> dict[str, Any]:
        """Call `tables.points`: master, position, velocity, acceleration at equal steps."""
        table = self._nc.table(arguments.integer("table", None, 1, 4095))
        count = arguments.integer("count", 500, 2, _MOST_POINTS)
        first, last = await _ends(table)
        masters = [first + (last - first) * n / (count - 1) for n in range(count)]
        values = await asyncio.gather(*map(table.values, masters))
        return {
            "master": masters,
            "position": [each.position for each in values],
            "velocity": [each.velocity for each in values],
            "acceleration": [each.acceleration for each in values],
        }


async def _ends(table: RemoteTable) -> tuple[float, float]:
    """Return the least and the greatest master position."""
    facts = await table.facts()
    if facts.kind.name == "MOTION_FUNCTION":
        points = await table.read_points()
        return points[0].master, points[-1].master
    rows = await table.read_rows()
    return rows[0][0], rows[-1][0]


_PARAMETERS, _STATES, _FUNCTIONS, _CYCLIC = 0x2000, 0x2100, 0x2200, 0x2300
_GROUP_STATES, _RING0_STATES = 0x3100, 0x1100
_CHANNEL_IDS = 0x31
_LONGEST_LIST = 1020
_ACTIONS = {"start": 0x02, "load": 0x04, "reset": 0x10, "stop": 0x11}
_INTERPRETER = (
    "INITIALISATION_FAILED", "IDLE", "READY", "STARTED", "SCANNING", "RUNNING", "STAY_RUNNING",
    "TABLE_FULL", "SEARCHING", "END", "SINGLE_STOP", "ABORTING", "ABORTED", "FAULT", "RESETTING",
    "STOPPING", "WAITING", "FLUSHING",
)  # fmt: skip
"""States of a channel's interpreter by their numbers (002 §6.4.2.2, 0x03)."""

_PLAN = 0x8000_0001
"""Offset of the planned path, of achse stations alone."""

_PLAN_HEAD, _PLAN_POINT = struct.Struct("<4I"), struct.Struct("<3dII")
_PLAN_LONGEST = _PLAN_HEAD.size + 256 * _PLAN_POINT.size
_PLAN_STATES = ("unfinished", "whole", "cut", "fault")
_NO_POINTS = 0xFFFF_FFFF

_MOST_PATH = 5000
"""Points of a path that are kept."""


class ChannelHandlers:
    """Channels with their interpreters, and where their tools went."""

    def __init__(self, watched: WatchedTarget) -> None:
        self._nc = watched.device(NC_PORT)
        self._paths: dict[int, deque[tuple[float, float, float, int]]] = {}

    async def there(self) -> bool:
        """Return True if the NC has a channel with an interpreter."""
        try:
            return bool(await self.channels(Arguments({})))
        except AdsError:
            return False

    async def channels(self, arguments: Arguments) -> list[dict[str, Any]]:
        """Call `channels.list`: channels with an interpreter and their axes."""
        data = await self._nc.read_raw(_RING0_STATES, _CHANNEL_IDS, _LONGEST_LIST)
        channels = []
        for id in struct.unpack(f"<{len(data) // 4}I", data):
            if await self._unsigned(_PARAMETERS + id, 0x03) == 2:
                name = await self._text(_PARAMETERS + id, 0x02, 31)
                channels.append({"channel": id, "name": name, "axes": await self._axes(id)})
        return channels

    async def _unsigned(self, group: int, offset: int) -> int:
        return int.from_bytes(await self._nc.read_raw(group, offset, 4), "little")

    async def _text(self, group: int, offset: int, length: int = 256) -> str:
        data = await self._nc.read_raw(group, offset, length)
        return data.split(b"\0", 1)[0].decode("cp1252", "replace")

    async def _axes(self, id: int) -> list[int]:
        group = await self._unsigned(_PARAMETERS + id, 0x21)
        data = await self._nc.read_raw(_GROUP_STATES + group, 0x552, 32)
        return list(struct.unpack("<8I", data))[:3]

    async def watch(self, subscription: SharedSubscription, arguments: Arguments) -> None:
        """Publish topic `channel`: state, program line, error, positions of X, Y, Z."""
        id = arguments.integer("channel", None, 1, 255)
        every = arguments.number("every", 0.1, 0.02, 10.0)
        path = self._paths.setdefault(id, deque(maxlen=_MOST_PATH))
        while True:
            axes = await self._axes(id)
            positions = await asyncio.gather(*map(self._position, axes))
            state = await self._unsigned(_STATES + id, 0x03)
            error = await self._unsigned(_STATES + id, 0x01)
            row = NcError.of(error) if error else None
            place = (positions[0], positions[1], positions[2], 0)
            if state and any(axes) and (not path or path[-1][:3] != place[:3]):
                path.append(place)
            subscription.show(
                {
                    "state": _state(state),
                    "program": await self._text(_STATES + id, 0x07),
                    "line": await self._text(_CYCLIC + id, 0x2000_0001),
                    "error": error,
                    "error_text": "" if row is None else row.text,
                    "axes": axes,
                    "positions": positions,
                    "plan": await self._plan_now(id),
                }
            )
            await subscription.pause(every)

    async def _position(self, axis: int) -> float:
        return (await self._nc.nc.axis(axis).status()).position if axis else 0.0

    async def path(self, arguments: Arguments) -> dict[str, Sequence[Any]]:
        """Call `channels.path`: where the tool went while a page watched the channel."""
        id = arguments.integer("channel", None, 1, 255)
        return {"points": [list(point) for point in self._paths.get(id, ())]}

    async def _plan_now(self, id: int) -> dict[str, int] | None:
        """Return number, points and current block of the plan; None without that service."""
        try:
            head, _ = await self._plan_from(id, _NO_POINTS)
        except DeviceError:
            return None
        return {"number": head[0], "points": head[2], "block": head[3]}

    async def _plan_from(
        self, id: int, first: int
    ) -> tuple[tuple[int, int, int, int], list[tuple[Any, ...]]]:
        request = first.to_bytes(4, "little")
        data = await self._nc.read_write_raw(_STATES + id, _PLAN, _PLAN_LONGEST, request)
        number, state, count, block = _PLAN_HEAD.unpack_from(data)
        return (number, state, count, block), list(_PLAN_POINT.iter_unpack(data[_PLAN_HEAD.size :]))

    async def plan(self, arguments: Arguments) -> dict[str, Any]:
        """Call `channels.plan`: the path that the loaded program takes: x, y, z, rapid, block."""
        id = arguments.integer("channel", None, 1, 255)
        points: list[tuple[Any, ...]] = []
        begun = None
        while True:
            (number, state, count, _), more = await self._plan_from(id, len(points))
            if begun not in (None, number):  # another program: from its begin
                begun, points = number, []
                continue
            begun = number
            points += more
            if _PLAN_STATES[state] != "unfinished" and len(points) >= count:
                return {"number": number, "state": _PLAN_STATES[state], "points": points}

    async def do(self, arguments: Arguments) -> dict[str, Any]:
        """Call `channels.do`: start, stop, reset, or load a file of the channel's folder."""
        id = arguments.integer("channel", None, 1, 255)
        action = arguments.choice("action", tuple(_ACTIONS))
        data = b""
        if action == "load":
            data = arguments.text("file").encode("cp1252", "replace") + b"\0"
            self._paths.setdefault(id, deque(maxlen=_MOST_PATH)).clear()
        await self._nc.write_raw(_FUNCTIONS + id, _ACTIONS[action], data)
        return {}


def _state(number: int) -> str:
    return _INTERPRETER[number] if number < len(_INTERPRETER) else str(number)
