"""Time service of the system service: the time of day of the station (group 400).

Offset 1 serves NT_GetTime of the PLC libraries, offset 6 FB_GetTimeZoneInformation. Which
offsets and layouts they have is in no manual at hand; the zone is laid out as the library's type.
"""

import struct
from collections.abc import Callable, Iterable
from datetime import UTC, datetime, timedelta

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.server import IndexGroup, RawGroup

_DATE_AND_TIME = 1
_TIME_ZONE = 6
_SYSTEM_TIME = struct.Struct("<8H")
_ZONE = struct.Struct("<Ii32s16xi32s16xi")
"""Time zone structure: season (0: the zone has no summer time), bias in minutes; then name, rule
and bias of winter, and of summer."""
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


class TimeService:
    """The local time of a station, which is UTC. It is not set: Writes answer 0x701."""

    def __init__(self, clock: Callable[[], int]) -> None:
        self._clock = clock

    def groups(self) -> Iterable[IndexGroup]:
        yield RawGroup(
            400,
            "time services",
            read=self._read,
            write=self._refuse,
            response="UINT year, month, day of the week (0 Sunday), day, hour, minute, second, ms",
            last_offset=0xFFFF_FFFF,
            description="Offset 1: local time of the station, which is UTC; 6: its time zone."
            " Others: 0x701.",
        )

    def _read(self, offset: int, length: int, client: bytes) -> bytes:
        if offset == _TIME_ZONE:
            return _ZONE.pack(0, 0, b"UTC", 0, b"UTC", 0)
        if offset != _DATE_AND_TIME:
            raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, f"time service {offset}")
        now = _EPOCH + timedelta(milliseconds=self._clock() // 1_000_000)
        return _SYSTEM_TIME.pack(
            *(now.year, now.month, now.isoweekday() % 7, now.day),
            *(now.hour, now.minute, now.second, now.microsecond // 1000),
        )

    def _refuse(self, offset: int, data: bytes, client: bytes) -> None:
        raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, "the time of a station is not set")
