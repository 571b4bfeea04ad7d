"""EtherCAT buses of a target and the drives on them, as its masters answer for them."""

import asyncio
import contextlib
import struct
from collections.abc import Awaitable
from typing import Any

from achse.ams import AdsError, DeviceError, NetId
from achse.client import Target
from achse.drive import Alarm
from achse.web.arguments import Arguments
from achse.web.drive_axes import axes_of_drives, scale_of
from achse.web.messages import CallError
from achse.web.shared_subscriptions import SharedSubscription
from achse.web.watched import IO_PORT, NC_PORT, WatchedTarget

_MASTER_PORT = 0xFFFF
_DEVICES, _IDS, _NAME, _NET_ID, _BOX_NAME = 0x5000, 1, 1, 5, 6
_MASTER_STATE, _ADDRESSES, _STATES, _FRAMES, _IDENTITY = 0x3, 0x7, 0x9, 0xC, 0x11
_CRC_ERRORS, _DEV_STATE, _TRIPS, _WAY = 0x12, 0x45, 0x101, 0x102
_STATE_OFFSET = 0x100
SDO = 0xF302
"""Index group of a slave's objects; offset: index << 16 | subindex."""

_LONGEST = 0x1_0000
_STATE_NAMES = {1: "INIT", 2: "PREOP", 3: "BOOT", 4: "SAFEOP", 8: "OP"}
_FAULTS = (
    (0x0010, "error"), (0x0020, "wrong slave"), (0x0040, "start command refused"),
    (0x0100, "not present"), (0x0400, "link missing"), (0x0800, "additional link"),
)  # fmt: skip
"""Bits of state and link of a slave, the link's in the upper byte."""

_BUS_FAULTS = (
    (0x0001, "link error"), (0x0004, "second link lost"), (0x0008, "ring is open"),
    (0x0100, "slaves in Init"), (0x0200, "slaves in PreOp"), (0x0400, "slaves in SafeOp"),
    (0x0800, "slaves with errors"), (0x1000, "clocks apart"),
)  # fmt: skip
"""Bits of the state of a bus."""

_DRIVE_STATES = (
    (0x4F, 0x00, "NOT_READY_TO_SWITCH_ON"), (0x4F, 0x40, "SWITCH_ON_DISABLED"),
    (0x6F, 0x21, "READY_TO_SWITCH_ON"), (0x6F, 0x23, "SWITCHED_ON"),
    (0x6F, 0x27, "OPERATION_ENABLED"), (0x6F, 0x07, "QUICK_STOP_ACTIVE"),
    (0x4F, 0x0F, "FAULT_REACTION_ACTIVE"), (0x4F, 0x08, "FAULT"),
)  # fmt: skip
"""Mask and value of the statusword (CiA 402, 6041h)."""

_SHOWN = {
    "error_code": (0x603F, "<H"), "controlword": (0x6040, "<H"), "statusword": (0x6041, "<H"),
    "mode": (0x6061, "<b"), "position": (0x6064, "<i"), "velocity": (0x606C, "<i"),
    "torque": (0x6077, "<h"),
}  # fmt: skip
"""Objects in the table of drives: index, form."""


def drive_state(statusword: int) -> str:
    """State of the drive's machine by its statusword."""
    return next((name for mask, value, name in _DRIVE_STATES if statusword & mask == value), "?")


class BusHandlers:
    """Handlers of page calls about buses and drives."""

    def __init__(self, watched: WatchedTarget) -> None:
        self._watched = watched
        self._io = watched.device(IO_PORT)

    async def _masters(self) -> list[tuple[int, Target]]:
        data = await self._io.read_raw(_DEVICES, _IDS, 2 + 2 * 64)
        count = int.from_bytes(data[:2], "little")
        ids = struct.unpack_from(f"<{min(count, (len(data) - 2) // 2)}H", data, 2)
        masters = []
        for id in ids:
            net_id = NetId(await self._io.read_raw(_DEVICES + id, _NET_ID, 6))
            masters.append((id, self._io.at_port(_MASTER_PORT, net_id)))
        return masters

    async def there(self) -> bool:
        """Return True if the target has a bus."""
        try:
            return bool(await self._masters())
        except (AdsError, ValueError, struct.error):
            return False

    async def watch_bus(self, subscription: SharedSubscription, arguments: Arguments) -> None:
        """Publish topic `bus`: each bus with its slaves."""
        every = arguments.number("every", 0.5, 0.1, 10.0)
        while True:
            wrong = await self._wrong_counters()
            subscription.show(
                [await self._bus(id, master, wrong) for id, master in await self._masters()]
            )
            await subscription.pause(every)

    async def _wrong_counters(self) -> dict[str, int]:
        """Cyclic frames with another working counter than expected, by bus: achse stations."""
        try:
            figures = await self._watched.statistics()
        except AdsError:
            return {}
        return {bus["name"]: bus["frames_wrong"] for bus in figures.get("buses", [])}

    async def _bus(self, id: int, master: Target, wrong: dict[str, int]) -> dict[str, Any]:
        data = await self._io.read_raw(_DEVICES + id, _NAME, 256)
        name = data.split(b"\0", 1)[0].decode("cp1252", "replace")
        lowest = int.from_bytes(await master.read_raw(_MASTER_STATE, _STATE_OFFSET, 2), "little")
        return {
            "name": name,
            "net_id": str(master.address.net_id),
            "state": _STATE_NAMES.get(lowest & 0xF, "none"),
            **await self._frames(master),
            "wrong": wrong.get(name),
            "slaves": await self._slaves(id, master),
        }

    async def _frames(self, master: Target) -> dict[str, Any]:
        """Frames since the last reset, round trips in s, and what is wrong; None: not reported."""
        counters: dict[str, Any] = dict.fromkeys(
            ("cycles", "lost", "round_trip", "round_trip_99", "round_trip_largest")
        )
        counters["faults"] = []
        frames = await _maybe(master.read_raw(_FRAMES, 0, 20), "<5I")
        if frames is not None:
            counters["cycles"], counters["lost"] = frames[1], frames[2] + frames[4]
        bits = await _maybe(master.read_raw(_DEV_STATE, 0, 2), "<H")
        if bits is not None:
            counters["faults"] = [text for bit, text in _BUS_FAULTS if bits[0] & bit]
        trips = await _maybe(master.read_raw(_TRIPS, 0, 48), "<6Q")
        if trips is not None and trips[0]:
            names = ("round_trip", "round_trip_99", "round_trip_largest")
            counters.update(zip(names, (each / 1e9 for each in trips[3:]), strict=True))
        with contextlib.suppress(AdsError):
            trouble = (await master.read_raw(_WAY, 1, _LONGEST)).rstrip(b"\0").decode()
            counters["faults"] += [trouble] if trouble else []
        return counters

    async def _stations(self, master: Target) -> tuple[int, ...]:
        data = await master.read_raw(_ADDRESSES, 0, _LONGEST)
        return struct.unpack(f"<{len(data) // 2}H", data)

    async def _slaves(self, id: int, master: Target) -> list[dict[str, Any]]:
        stations = await self._stations(master)
        states = await master.read_raw(_STATES, 0, _LONGEST)
        errors = await _maybe(master.read_raw(_CRC_ERRORS, 0, _LONGEST), f"<{len(stations)}I")
        slaves = []
        for number, station in enumerate(stations):
            identity = struct.unpack("<4I", await master.read_raw(_IDENTITY, station, 16))
            word = int.from_bytes(states[2 * number : 2 * number + 2], "little")
            slaves.append(
                {
                    "station": station,
                    "name": await self._box_name(id, station),
                    "state": _STATE_NAMES.get(word & 0xF, "none"),
                    "faults": [text for bit, text in _FAULTS if word & bit],
                    "errors": None if errors is None else errors[number],
                    **dict(zip(("vendor", "product", "revision", "serial"), identity, strict=True)),
                }
            )
        return slaves

    async def _box_name(self, id: int, station: int) -> str:
        request = station.to_bytes(2, "little")
        name = await self._io.read_write_raw(_DEVICES + id, _BOX_NAME, 256, request)
        return name.rstrip(b"\0").decode("cp1252", "replace")

    # drives ------------------------------------------------------------------------------------

    async def drives(self, arguments: Arguments) -> list[dict[str, Any]]:
        """Call `drives.list`: slaves that answer as drives do (CiA 402).

        `position` and `velocity` are in increments, `scaled_position` and `scaled_velocity` in
        the `unit` of the axis; None for a drive without an axis.
        """
        drives = []
        nc = self._watched.device(NC_PORT)
        axes = await axes_of_drives(nc)
        for id, master in await self._masters():
            net_id = bytes(master.address.net_id)
            for station in await self._stations(master):
                slave = master.at_port(station)
                values = await _values(slave)
                if values["statusword"] is None:
                    continue
                word = values["statusword"]
                axis = axes.get((net_id, station))
                scale = None if axis is None else await scale_of(nc, axis)
                error = values.pop("error_code") or 0
                alarm = Alarm.of(error)
                bus_state = await self.state(master, station)
                drives.append(
                    {
                        "drive": station,
                        "name": await self._box_name(id, station),
                        "axis": None if axis is None else axis.name,
                        "axis_id": None if axis is None else axis.id,
                        "unit": "" if axis is None else axis.unit,
                        "state": drive_state(word),
                        **values,
                        "scaled_position": None
                        if scale is None or values["position"] is None
                        else scale.position_of(values["position"]),
                        "scaled_velocity": None
                        if scale is None or values["velocity"] is None
                        else values["velocity"] * scale.factor,
                        "error": error,
                        "error_text": f"{alarm.panel} {alarm.text}"
                        if alarm
                        else (f"0x{error:04X}" if error else ""),
                        "error_link": None,
                        "bus_state": bus_state,
                    }
                )
        return drives

    async def watch_drives(self, subscription: SharedSubscription, arguments: Arguments) -> None:
        """Publish topic `drives`: the rows of `drives`, in each interval."""
        every = arguments.number("every", 0.5, 0.1, 10.0)
        while True:
            subscription.show(await self.drives(arguments))
            await subscription.pause(every)

    async def state(self, master: Target, station: int) -> str | None:
        """Return the state of a slave on its bus; None if the master does not report it."""
        states = await _maybe(master.read_raw(_STATES, station, 2), "<2B")
        return None if states is None else _STATE_NAMES.get(states[0] & 0xF, "none")

    async def slave(self, station: int) -> tuple[Target, Target]:
        """Return the master and the slave of that address. Raises CallError without one."""
        for _, master in await self._masters():
            if station in await self._stations(master):
                return master, master.at_port(station)
        raise CallError(f"drive: no slave has the address {station}")


async def _maybe(reading: Awaitable[bytes], form: str) -> tuple[Any, ...] | None:
    """Return the unpacked data of a read; None if the target has no such service."""
    try:
        data = await reading
    except DeviceError:
        return None
    return struct.unpack(form, data) if len(data) == struct.calcsize(form) else None


async def _values(slave: Target) -> dict[str, Any]:
    """Values of the objects shown by name; None for those that the slave does not have."""

    async def read(index: int, form: str) -> int | None:
        size = struct.calcsize(form)
        try:
            data = await slave.read_raw(SDO, index << 16, size)
        except AdsError:
            return None
        return int(struct.unpack(form, data)[0]) if len(data) == size else None

    values = await asyncio.gather(*(read(*each) for each in _SHOWN.values()))
    return dict(zip(_SHOWN, values, strict=True))
