"""Axes by the drives that they have, and increments of a drive in units of its axis."""

import struct
from typing import NamedTuple

from achse.ams import AdsError, DecodeError
from achse.ams.commands import ReadRequest
from achse.client import Target
from achse.client.nc import RemoteAxis
from achse.client.nc.services import PARAMETERS, STATES, NcService, named

_HARDWARE = 0x31
"""Offset of the parameter of an axis that names its drive: NetId of the bus, address, channel."""

_COUNTS = 1 << 32
"""Values of the object 6064h; it begins again behind the last."""

DriveKey = tuple[bytes, int]
"""NetId of the bus, station address."""


class DriveAxis(NamedTuple):
    """An axis that has a drive."""

    id: int
    name: str
    unit: str
    """Unit of positions, such as mm; empty if the NC does not say it."""


class AxisScale(NamedTuple):
    """The position of an axis and its drive's count in the same cycle, and units per increment."""

    position: float
    counter: int
    factor: float
    """Units per increment; negative for a drive that counts against the axis."""

    def position_of(self, count: int) -> float:
        """Return where the axis is at a count of its drive, with all offsets that the NC has."""
        way = (count - self.counter + _COUNTS // 2) % _COUNTS - _COUNTS // 2
        return self.position + way * self.factor


async def axes_of_drives(nc: Target) -> dict[DriveKey, DriveAxis]:
    """Return the axes of an NC by their drives; none without an NC."""
    linked: dict[DriveKey, DriveAxis] = {}
    try:
        for axis in await nc.nc.axes():
            id = await axis.id()
            try:
                data = await nc.read_raw(PARAMETERS + id, _HARDWARE, 10)
                net_id, station, _ = struct.unpack("<6sHH", data)
            except (AdsError, struct.error):
                continue  # the NC has no such parameter, or the axis no drive
            if station:
                linked[net_id, station] = DriveAxis(id, str(axis), await _unit(axis))
    except AdsError:
        pass  # no NC: no axes
    return linked


async def _unit(axis: RemoteAxis) -> str:
    try:
        return await axis.unit()
    except AdsError:
        return ""


def _services() -> tuple[NcService, ...]:
    states = ("encoder_actual_position", "encoder_hardware_increments")
    parameters = ("encoder_scaling_factor", "encoder_count_direction")
    return (
        *(named((STATES,), name) for name in states),
        *(named((PARAMETERS,), name) for name in parameters),
    )


async def scale_of(nc: Target, axis: DriveAxis) -> AxisScale | None:
    """Return the scale of an axis now; None if the NC does not say it."""
    services = _services()
    parts = [ReadRequest(*each.place(axis.id), each.layout.size) for each in services]
    try:
        outcomes = await nc.send_each(parts)
        position, count, factor, inverted = (
            service.layout.decode(outcome.data)
            for service, outcome in zip(services, outcomes, strict=True)
        )
    except (AdsError, DecodeError):
        return None
    return AxisScale(position, count, -factor if inverted else factor)
