"""Binding of channel rows to channels: by attribute, some only to channels with an interpreter."""

from collections.abc import Callable
from enum import IntEnum
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError, ReturnCode
from achse.codes.nc.row import NcRow
from achse.devices.nc.functions.calling import carry_out
from achse.devices.nc.rows import bound
from achse.motion.channels.channel import NcChannel
from achse.motion.channels.program_channel import ProgramChannel
from achse.server import Service


def of_interpreter(channel: NcChannel) -> ProgramChannel:
    """Return the channel, if it has an interpreter; raises DeviceError 0x703 for others."""
    if not isinstance(channel, ProgramChannel):
        raise DeviceError(ReturnCode.INVALID_OFFSET, f"channel {channel.channel_id} runs nothing")
    return channel


def only_interpreters(channel: NcChannel) -> None:
    of_interpreter(channel)


def show_program(row: NcRow, read: Callable[[ProgramChannel], Any]) -> Service:
    """Return the service that shows a value of a channel with an interpreter."""
    return bound(row, read=lambda channel: read(of_interpreter(channel)))


def program_value(row: NcRow, path: str, *, choices: type[IntEnum] | None = None) -> Service:
    """Return the service of an attribute (`data.inch`) of a channel with an interpreter."""
    *owners, field = path.split(".")

    def owner(channel: NcChannel) -> Any:
        target: Any = of_interpreter(channel)
        for each in owners:
            target = getattr(target, each)
        return target

    return bound(
        row,
        read=lambda channel: getattr(owner(channel), field),
        write=lambda channel, value: setattr(owner(channel), field, value),
        guard=only_interpreters,
        code=NcError.CHANNEL_START_PARAMETER.number,
        choices=choices,
    )


def channel_function(row: NcRow, call: Callable[..., int]) -> Service:
    """Return the service that is written with the arguments of `call`, a function of the
    interpreter."""

    def write(channel: NcChannel, data: Any) -> None:
        target = of_interpreter(channel)
        carry_out(call(target, *data) if isinstance(data, tuple) else call(target, data))

    return bound(row, write=write, non_finite=True)
