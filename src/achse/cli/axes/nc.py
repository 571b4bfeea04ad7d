"""The axes that a command names, as the client has them, with what commands print of them."""

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from achse.ams.states import TransmissionMode
from achse.client import Subscription, Target
from achse.client.nc import AxisRefused, RemoteAxis, RemoteNc, UnknownAxis
from achse.client.nc.controller import MAX_AXES
from achse.client.nc.services import CYCLIC, named
from achse.client.nc.status import plc_open_state
from achse.codes import NcError
from achse.iec.nearest import did_you_mean


def motion_state(state_dword: int) -> str:
    """Return the PLCopen state of an axis."""
    return plc_open_state(state_dword).value


@dataclass(frozen=True)
class NcAxis:
    """The client's axis, and what lines begin and end with: its name, its unit."""

    remote: RemoteAxis
    axis_id: int
    name: str
    unit: str

    async def online(self) -> dict[str, Any]:
        """Return the online structure (002, 0x4100 + id: 0), by field."""
        online: dict[str, Any] = await self.remote.states["axis_online_structure"]
        return online

    def samples(self, cycle_time: float) -> Subscription:
        """Return the cyclic structure (0x4300 + id: 0x80) each `cycle_time` seconds, as bytes."""
        service = named((CYCLIC,), "nc_to_plc_structure")
        return self.remote.nc.subscribe_as(
            *service.place(self.axis_id),
            service.layout.size,
            cycle_time=cycle_time,
            mode=TransmissionMode.SERVER_CYCLE,
        )

    def sample(self, data: bytes) -> dict[str, Any]:
        """Return the fields of a sample of `samples`."""
        values: dict[str, Any] = named((CYCLIC,), "nc_to_plc_structure").layout.decode(data)
        return values

    def __str__(self) -> str:
        return self.name or f"axis {self.axis_id}"


async def axes_of(nc: Target) -> list[NcAxis]:
    """Return all axes of the NC, by id."""
    return await _axes(nc, await RemoteNc(nc).ids())


async def chosen(nc: Target, wanted: Sequence[str]) -> list[NcAxis]:
    """The axes with these ids or names (without case), all of them if none is wanted.

    Raises UnknownAxis.
    """
    ids = [int(word) for word in wanted if word.isdecimal() and 0 < int(word) <= MAX_AXES]
    if wanted and len(ids) == len(wanted):
        try:
            return await _axes(nc, ids)
        except AxisRefused as refusal:
            if refusal.code != NcError.AXIS_ID:
                raise
    axes = await axes_of(nc)
    known = {axis.name.lower(): axis for axis in reversed(axes)}
    known |= {str(axis.axis_id): axis for axis in axes}
    for word in wanted:
        if word.lower() not in known:
            names = ", ".join(f"{axis.axis_id} {axis.name}".strip() for axis in axes)
            near = did_you_mean(word, (axis.name for axis in axes if axis.name))
            what = f"no such axis at {nc.address}; there are: {names or 'none'}{near}"
            raise UnknownAxis(0, repr(word), what)
    return [known[word.lower()] for word in wanted] or axes


async def _axes(nc: Target, ids: Sequence[int]) -> list[NcAxis]:
    async def known(axis: RemoteAxis, axis_id: int) -> NcAxis:
        name, unit = await asyncio.gather(axis.name(), axis.unit())
        return NcAxis(axis, axis_id, name, unit)

    controller = RemoteNc(nc)
    return list(await asyncio.gather(*(known(controller.axis(each), each) for each in ids)))
