"""The station's own ADS service, AMS port 26000: faults, taps, statistics, online changes,
missing conditions, debugging.

No original has it. Texts are UTF-8 without NUL; what has structure is JSON, so that any ADS client
can use it by ReadWrite.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Protocol

from achse.ams import DeviceError, Endpoint
from achse.codes import ReturnCode
from achse.codes.station import MISSING_CONDITION, ONLINE_CHANGE
from achse.devices.debugging import debug_group
from achse.devices.taps import TapService
from achse.plc import PlcRuntime
from achse.router import Router
from achse.router.tap import Taps
from achse.server import Device, RawGroup

FAULTS, STATISTICS = 0xFA01, 0xFA03
"""Index groups."""


class ActiveOne(Protocol):
    """A fault of a list."""

    @property
    def number(self) -> int: ...
    def facts(self) -> dict[str, Any]: ...


class FaultList(Protocol):
    """Faults on demand, of a station or of drives."""

    def __iter__(self) -> Iterator[ActiveOne]: ...
    def add(self, fault: str, /, **fields: Any) -> ActiveOne: ...
    def clear(self, number: int | None = None) -> None: ...


class ServedStation(Protocol):
    """Interface of the station to its service."""

    @property
    def router(self) -> Router: ...
    @property
    def faults(self) -> FaultList: ...
    @property
    def plcs(self) -> Mapping[int, PlcRuntime]: ...
    def source_files(self, port: int) -> Mapping[str, str]:
        """Return the paths of a PLC's own source files, by the names that faults use."""
        ...

    @property
    def drive_faults(self) -> Sequence[FaultList | None]:
        """Fault lists of the buses; None for a bus whose drives are not in this process."""
        ...

    def missing_condition(self, axis_id: int) -> str:
        """Return the reason why an axis on a bus is not ready for operation, empty if it is."""
        ...

    def clock(self) -> int: ...
    def statistics(self) -> Mapping[str, Any]: ...

    def online_change(self, port: int | None = None) -> Mapping[int, int]:
        """Read declarations again; how often each PLC, by its port, has changed so far.

        Raises ValueError for what cannot be read.
        """
        ...


class StationService(Device):
    """Faults, taps, statistics and online changes of one station, by the front door as all else.

    `taps` are those of its router, for all clients together.
    """

    def __init__(self, station: ServedStation, taps: Taps) -> None:
        self._station = station
        self._taps = TapService(taps, lambda: self.request_way)
        self._attached: dict[tuple[bytes, int], Endpoint | None] = {}
        """Ways of the clients that debug a PLC, by client and port of the PLC."""
        super().__init__(
            "achse station",
            (0, 1, 0),
            (
                faults_group(
                    self._faults,
                    0xFFFF,
                    "Read lists, ReadWrite adds, Write clears; offset 0: those of the station,"
                    " n: those of the drives on its bus n.",
                ),
                self._taps.group,
                RawGroup(
                    STATISTICS,
                    "statistics",
                    read=lambda offset, length, client: _json(self._station.statistics()),
                    response="JSON",
                    description="Connections, subscriptions, handles, queues, cycle.",
                    source="achse",
                ),
                RawGroup(
                    ONLINE_CHANGE,
                    "online change",
                    read_write=self._online_change,
                    last_offset=0xFFFF,
                    response="JSON: online changes of each PLC by its port, or the error",
                    description="Offset = AMS port of a PLC (0: all): reads its declarations"
                    " again and goes on with them.",
                    source="achse",
                ),
                RawGroup(
                    MISSING_CONDITION,
                    "missing condition",
                    read=lambda axis_id, length, client: station.missing_condition(
                        axis_id
                    ).encode(),
                    last_offset=0xFFFF,
                    response="text",
                    description="Offset = id of an axis: what keeps its drive on a bus from being"
                    " ready, empty if nothing does.",
                    source="achse",
                ),
                debug_group(station, self._attach),
            ),
            clock=station.clock,
        )

    # faults ----------------------------------------------------------------------------------

    def _faults(self, bus: int) -> FaultList:
        """Return the faults of the station (0), or of the drives on one of its buses (1 …)."""
        if not bus:
            return self._station.faults
        lists = self._station.drive_faults
        faults = lists[bus - 1] if bus <= len(lists) else None
        if faults is None:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"bus {bus} has no drives in this process")
        return faults

    # declarations ----------------------------------------------------------------------------

    def _online_change(self, port: int, length: int, data: bytes, client: bytes) -> bytes:
        try:
            changes = self._station.online_change(port or None)
        except ValueError as failure:
            return _json({"error": str(failure)})
        return _json({str(number): count for number, count in changes.items()})

    # debugging -------------------------------------------------------------------------------

    def _attach(self, client: bytes, port: int) -> None:
        self._attached[client, port] = self.request_way

    def _detach(self, client: bytes, port: int) -> None:
        """Note that a client is gone: what it stopped goes on."""
        del self._attached[client, port]
        plc = self._station.plcs.get(port)
        if plc is not None:
            plc.end_debugging()

    def end_client(self, client: bytes) -> None:
        """Close what a client left open."""
        self._taps.end_client(client)
        for owner, port in list(self._attached):
            if owner == client:
                self._detach(owner, port)
        super().end_client(client)

    def end_way(self, way: Endpoint) -> None:
        """Close what was opened over a connection that is gone."""
        self._taps.end_way(way)
        for (owner, port), attached_by in list(self._attached.items()):
            if attached_by is way:
                self._detach(owner, port)
        super().end_way(way)

    def _clients(self) -> set[bytes]:
        return super()._clients() | self._taps.clients | {owner for owner, _ in self._attached}


def faults_group(
    faults: Callable[[int], FaultList],
    last_offset: int = 0,
    description: str = "Read lists, ReadWrite adds, Write clears.",
) -> RawGroup:
    """Return the service by which faults are listed (Read), added (ReadWrite) and cleared (Write).

    `faults` gives the list for an index offset of 0 to `last_offset`, or raises DeviceError.
    """

    def listed(offset: int, length: int, client: bytes) -> bytes:
        return _json([active.facts() for active in faults(offset)])

    def add(offset: int, length: int, data: bytes, client: bytes) -> bytes:
        known = faults(offset)
        try:
            fields = json.loads(data.rstrip(b"\0"))
            if not isinstance(fields, dict):
                raise ValueError(f"a fault is a JSON object, got {type(fields).__name__}")
            kind = fields.pop("kind", "")
            active = known.add(str(kind), **fields)
        except RecursionError:  # its message depends on the version of Python
            return _json({"error": "a fault is a JSON object, got JSON that is nested too deep"})
        except (ValueError, DeviceError) as failure:
            return _json({"error": str(failure)})
        return _json({"number": active.number})

    def clear(offset: int, data: bytes, client: bytes) -> None:
        if len(data) != 4:
            raise DeviceError(ReturnCode.INVALID_SIZE, f"a number is 4 bytes, got {len(data)}")
        number = int.from_bytes(data, "little")
        try:
            faults(offset).clear(number or None)
        except KeyError:
            raise DeviceError(ReturnCode.NOT_FOUND, f"fault {number}") from None

    return RawGroup(
        FAULTS,
        "faults",
        read=listed,
        read_write=add,
        write=clear,
        last_offset=last_offset,
        request="JSON of a fault, or UINT32 number to clear (0: all)",
        response="JSON: the list; of an addition its number or the error",
        description=description,
        source="achse",
    )


def _json(document: Any) -> bytes:
    return json.dumps(document).encode()
