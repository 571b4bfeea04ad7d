"""Faults on demand of an achse station: which there are, which are at work, and how to set them."""

import json
import re
from typing import Any

from achse.ams import AdsError
from achse.faults.drives import DRIVE_FAULTS
from achse.faults.fault import FaultKinds
from achse.faults.kinds import STATION_FAULTS
from achse.station.configuration.schema import descriptions_of
from achse.web.arguments import Arguments
from achse.web.messages import CallError
from achse.web.shared_subscriptions import SharedSubscription
from achse.web.watched import LONGEST_TEXT, STATION_PORT, WatchedTarget

_FAULTS = 0xFA01

_BUS = "Which bus of the station, counted from 1."

_OF_DRIVE = re.compile(r"bus (\d{1,4}): (\d{1,9})")
"""Pattern for the key of a drive fault on pages; the key of a station fault is its number."""


class FaultHandlers:
    """Handlers of page calls about faults: of the station, and of the drives on its own buses."""

    def __init__(self, watched: WatchedTarget) -> None:
        self._watched = watched
        self._device = watched.device(STATION_PORT)
        self._buses: list[int] = []
        self._looked_at = -1

    async def _with_drives(self) -> list[int]:
        """The buses with drives in the station's process, counted from 1."""
        losses = self._watched.client.session.losses
        if self._looked_at != losses:
            try:
                buses = (await self._watched.statistics())["buses"]
            except AdsError:
                return []
            self._buses = [n for n, bus in enumerate(buses, 1) if not bus["interface"]]
            self._looked_at = losses
        return self._buses

    async def kinds(self, arguments: Arguments) -> list[dict[str, Any]]:
        """Call `faults.list`: kinds with their parameters, their meanings and defaults."""
        rows = _rows_of(STATION_FAULTS, "station")
        if await self._with_drives():
            rows += _rows_of(DRIVE_FAULTS, "drive")
        return rows

    async def active(self) -> list[dict[str, Any]]:
        """Faults that wait for their time or are at work."""
        faults = []
        for bus in (0, *await self._with_drives()):
            data = await self._device.read_raw(_FAULTS, bus, LONGEST_TEXT)
            for each in json.loads(data):
                fields, number = each["fault"], each["number"]
                fault = (DRIVE_FAULTS if bus else STATION_FAULTS).of(fields)
                faults.append(
                    {
                        "number": f"bus {bus}: {number}" if bus else number,
                        "state": each["state"],
                        "hits": each["hits"],
                        "kind": fields["kind"],
                        "fields": {**fields, **({"bus": bus} if bus else {})},
                        "text": str(fault),
                    }
                )
        return faults

    async def watch(self, subscription: SharedSubscription, arguments: Arguments) -> None:
        """Publish topic `faults`: number, state, hits and text of each."""
        every = arguments.number("every", 0.5, 0.1, 10.0)
        while True:
            subscription.show(await self.active())
            await subscription.pause(every)

    async def set(self, arguments: Arguments) -> dict[str, Any]:
        """Call `faults.set`: let something go wrong; the answer is its number."""
        fields = {
            name: value for name, value in arguments.fields.items() if value not in (None, "")
        }
        bus = 0
        if fields.get("kind") in list(DRIVE_FAULTS):
            bus = Arguments(fields).integer("bus", 1, 1, 0xFFFF)
            fields.pop("bus", None)
            request = DRIVE_FAULTS.of(fields).fields()
        else:
            request = STATION_FAULTS.of(fields).fields()
        data = json.dumps(request).encode()
        answer = json.loads(await self._device.read_write_raw(_FAULTS, bus, LONGEST_TEXT, data))
        if "error" in answer:
            raise CallError(answer["error"])
        number = answer["number"]
        return {"number": f"bus {bus}: {number}" if bus else number}

    async def clear(self, arguments: Arguments) -> dict[str, Any]:
        """Call `faults.clear`: end one, or all."""
        key = arguments.fields.get("number")
        match = _OF_DRIVE.fullmatch(key) if isinstance(key, str) else None
        if match is not None:
            places = [(int(match[1]), int(match[2]))]
        elif key is None:
            places = [(bus, 0) for bus in (0, *await self._with_drives())]
        else:
            places = [(0, arguments.integer("number", None, 1, 0xFFFF_FFFF))]
        for bus, number in places:
            await self._device.write_raw(_FAULTS, bus, number.to_bytes(4, "little"))
        return {}


def _rows_of(kinds: FaultKinds[Any], family: str) -> list[dict[str, Any]]:
    """Return the kinds of a family as pages know them."""
    rows = []
    for kind in kinds:
        model = kinds.kinds[kind]
        meanings = descriptions_of(model)
        types = {"at": "number", **kinds.types(kind)}
        fields = [
            {
                "name": name,
                "type": type,
                "unit": kinds.unit(kind, name),
                "meaning": meanings.get(name),
                "default": None
                if model.model_fields[name].is_required()
                else model.model_fields[name].default or None,
            }
            for name, type in types.items()
        ]
        if family == "drive":
            bus = {"name": "bus", "type": "integer", "unit": "", "meaning": _BUS, "default": 1}
            fields.append(bus)
        rows.append(
            {
                "kind": kind,
                "meaning": kinds.description(kind),
                "fields": fields,
                "family": family,
            }
        )
    return rows
