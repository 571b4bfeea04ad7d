"""What every channel has: who it is, its groups, reset, stop, overrides."""

from collections.abc import Callable
from typing import Any

from achse.codes import NcError
from achse.devices.nc.functions.calling import carry_out
from achse.devices.nc.layouts import INT32, NO_DATA, UINT32, Text
from achse.motion.channels.channel import NcChannel
from achse.motion.groups.group import FULL_OVERRIDE
from achse.server import READ, WRITE, Codec, Repeated, Service

__all__ = ["EVERY_CYCLIC", "EVERY_FUNCTION", "EVERY_PARAMETER", "EVERY_STATE"]


def _row(
    offset: int, codec: Codec, name: str, description: str, read: Callable[[NcChannel], Any]
) -> Service:
    return Service(offset, name, READ, codec, description, "1", read=read)


def _function(
    offset: int, name: str, call: Callable[[NcChannel], int], description: str
) -> Service:
    return Service(
        *(offset, name, WRITE, NO_DATA, description),
        write=lambda channel, _: carry_out(call(channel)),
    )


def _override(offset: int, name: str, field: str, description: str) -> Service:
    return Service(
        *(offset, name, READ | WRITE, UINT32, description, "%"),
        read=lambda channel: getattr(channel, field),
        write=lambda channel, value: setattr(channel, field, value),
        minimum=0,
        maximum=FULL_OVERRIDE,
        code=NcError.OVERRIDE_INVALID.number,
    )


EVERY_PARAMETER = (
    _row(0x01, UINT32, "channel_id", "id of the channel", lambda channel: channel.channel_id),
    _row(0x02, Text(31), "channel_name", "name of the channel", lambda channel: channel.name),
    _row(0x03, UINT32, "channel_type", "type of the channel", lambda channel: channel.type),
    _row(
        *(0x04, UINT32, "interpreter_type", "type of the interpreter, 0 = none"),
        lambda channel: channel.interpreter_type,
    ),
    _row(
        *(0x21, UINT32, "group_id", "id of the first of its groups, 0 = none"),
        lambda channel: next(iter(channel.group_ids), 0),
    ),
)

EVERY_STATE = (
    _row(0x01, INT32, "error_code", "error of the channel", lambda channel: channel.error_code),
    _row(
        *(0x02, UINT32, "group_count", "number of its groups"),
        lambda channel: len(channel.group_ids),
    ),
    _row(
        *(0x100, Repeated(UINT32), "axis_ids", "ids of its axes"),
        lambda channel: channel.axis_ids,
    ),
)

EVERY_FUNCTION = (
    _function(0x10, "reset", lambda channel: channel.reset(), "reset its groups"),
    _function(0x11, "stop", lambda channel: channel.stop(), "stop its groups"),
)

EVERY_CYCLIC = (
    _override(0x02, "channel_velocity_override", "override", "velocity override of its groups"),
    _override(
        *(0x03, "spindle_velocity_override", "spindle_override"), "velocity override of the spindle"
    ),
)
