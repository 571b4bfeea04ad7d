"""Channels, 0x2000 … 0x2300 + ID: one standard channel, which has the PTP groups of all axes.

Channels with an interpreter are not built yet. Source: 002 §6.4.2.
"""

from collections.abc import Callable
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError
from achse.devices.nc.groups import CHANNEL_ID, CHANNEL_NAME, ChannelType, group_ids
from achse.devices.nc.layouts import INT32, NO_DATA, UINT32, Text
from achse.motion import Axis, Nc, commands
from achse.server import READ, WRITE, Codec, IndexGroup, ObjectGroup, Repeated, Service

__all__ = [
    "CHANNEL_FUNCTIONS",
    "CHANNEL_PARAMETERS",
    "CHANNEL_STATES",
    "channel_groups",
    "channel_ids",
]

_HIGHEST_ID = 255


def channel_ids(nc: Nc) -> list[int]:
    """Ids of all channels: one, if there are axes."""
    return [CHANNEL_ID] if len(nc) else []


def _row(
    offset: int, codec: Codec, name: str, description: str, read: Callable[[Nc], Any]
) -> Service:
    return Service(offset, name, READ, codec, description, "1", read=read)


def _of_all(offset: int, name: str, command: Callable[[Axis], int], description: str) -> Service:
    """A function that every axis of the channel carries out; the first refusal is answered."""

    def write(nc: Nc, _: Any) -> None:
        answers = [command(axis) for axis in nc]
        if code := next(filter(None, answers), 0):
            raise DeviceError(code)

    return Service(offset, name, WRITE, NO_DATA, description, write=write)


CHANNEL_PARAMETERS = (
    _row(0x01, UINT32, "channel_id", "id of the channel", lambda nc: CHANNEL_ID),
    _row(0x02, Text(31), "channel_name", "name of the channel", lambda nc: CHANNEL_NAME),
    _row(
        *(0x03, UINT32, "channel_type", "type of the channel: standard"),
        lambda nc: ChannelType.STANDARD,
    ),
    _row(0x04, UINT32, "interpreter_type", "type of the interpreter: 0, none", lambda nc: 0),
    _row(
        *(0x21, UINT32, "group_id", "id of the first of its groups"),
        lambda nc: group_ids(nc)[0],
    ),
)

CHANNEL_STATES = (
    _row(0x01, INT32, "error_code", "error of the channel itself: it has none", lambda nc: 0),
    _row(0x02, UINT32, "group_count", "number of its groups", lambda nc: len(group_ids(nc))),
    _row(
        *(0x100, Repeated(UINT32), "axis_ids", "ids of its axes"),
        lambda nc: [axis.axis_id for axis in nc],
    ),
)

CHANNEL_FUNCTIONS = (
    _of_all(0x10, "reset", commands.reset, "reset all axes"),
    _of_all(0x11, "stop", commands.stop, "stop all axes with their running deceleration"),
)

_CHANNEL_GROUPS = (
    (0x2000, CHANNEL_PARAMETERS),
    (0x2100, CHANNEL_STATES),
    (0x2200, CHANNEL_FUNCTIONS),
    (0x2300, ()),
)
"""Index group + id, rows; the cyclic structures are of an interpreter."""


def channel_groups(nc: Nc) -> list[IndexGroup]:
    """The index groups of channels; an id that no channel has is 0x4010."""

    def find(id: int) -> Nc:
        if id not in channel_ids(nc):
            raise DeviceError(NcError.CHANNEL_ID.number, f"id {id}")
        return nc

    return [ObjectGroup(base, _HIGHEST_ID, find, rows) for base, rows in _CHANNEL_GROUPS]
