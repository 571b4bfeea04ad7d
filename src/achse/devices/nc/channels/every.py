"""Rows of every channel: identity, group, reset, stop, overrides."""

from collections.abc import Callable

from achse.codes import NcError
from achse.codes.nc.row import NcRow
from achse.codes.nc.table import named_rows
from achse.devices.nc.functions.calling import carry_out
from achse.devices.nc.rows import bound
from achse.motion.channels.channel import NcChannel
from achse.server import Service

_PARAMETERS = named_rows(0x2000)
_STATES = named_rows(0x2100)
_FUNCTIONS = named_rows(0x2200)
_CYCLIC = named_rows(0x2300)


def _function(row: NcRow, call: Callable[[NcChannel], int]) -> Service:
    return bound(row, write=lambda channel, _: carry_out(call(channel)))


def _override(row: NcRow, field: str) -> Service:
    return bound(
        row,
        read=lambda channel: getattr(channel, field),
        write=lambda channel, value: setattr(channel, field, value),
        code=NcError.OVERRIDE_INVALID.number,
    )


EVERY_PARAMETER = (
    bound(_PARAMETERS["channel_id"], read=lambda channel: channel.channel_id),
    bound(_PARAMETERS["channel_name"], read=lambda channel: channel.name),
    bound(_PARAMETERS["channel_type"], read=lambda channel: channel.type),
    bound(_PARAMETERS["interpreter_type"], read=lambda channel: channel.interpreter_type),
    bound(_PARAMETERS["group_id"], read=lambda channel: next(iter(channel.group_ids), 0)),
)

EVERY_STATE = (
    bound(_STATES["error_code"], read=lambda channel: channel.error_code),
    bound(_STATES["group_count"], read=lambda channel: len(channel.group_ids)),
    bound(_STATES["axis_ids"], read=lambda channel: channel.axis_ids),
)

EVERY_FUNCTION = (
    _function(_FUNCTIONS["reset"], lambda channel: channel.reset()),
    _function(_FUNCTIONS["stop"], lambda channel: channel.stop()),
)

EVERY_CYCLIC = (
    _override(_CYCLIC["channel_velocity_override"], "override"),
    _override(_CYCLIC["spindle_velocity_override"], "spindle_override"),
)
