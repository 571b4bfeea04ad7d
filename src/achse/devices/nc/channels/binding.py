"""How channel rows refer to channels: by attribute, and for those with an interpreter alone."""

from collections.abc import Callable
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError, ReturnCode
from achse.devices.nc.functions.calling import carry_out
from achse.motion.channels.channel import NcChannel
from achse.motion.channels.program_channel import ProgramChannel
from achse.server import READ, WRITE, Codec, Service

__all__ = ["LineText", "channel_function", "of_interpreter", "program_value", "show_program"]


class LineText:
    """A text of any length, with NUL at its end, in cp1252."""

    name = "STRING[n]"
    size: int | None = None

    def encode(self, value: str) -> bytes:
        return value.encode("cp1252", "replace") + b"\0"

    def decode(self, data: bytes) -> str:
        return data.split(b"\0", 1)[0].decode("cp1252", "replace")


def of_interpreter(channel: NcChannel) -> ProgramChannel:
    """The channel, if it has an interpreter; raises DeviceError 0x703 for others."""
    if not isinstance(channel, ProgramChannel):
        raise DeviceError(ReturnCode.INVALID_OFFSET, f"channel {channel.channel_id} runs nothing")
    return channel


def _only_interpreters(channel: NcChannel) -> None:
    of_interpreter(channel)


def show_program(
    offset: int,
    codec: Codec,
    name: str,
    description: str,
    read: Callable[[ProgramChannel], Any],
    unit: str = "1",
) -> Service:
    """A row that shows a value of a channel with an interpreter."""
    return Service(
        *(offset, name, READ, codec, description, unit),
        read=lambda channel: read(of_interpreter(channel)),
    )


def program_value(
    offset: int,
    codec: Codec | tuple[Codec, ...],
    name: str,
    description: str,
    path: str,
    error: NcError = NcError.CHANNEL_START_PARAMETER,
    unit: str = "1",
    **limits: Any,
) -> Service:
    """A row that shows and sets an attribute (`data.inch`) of a channel with an interpreter."""
    *owners, field = path.split(".")

    def owner(channel: NcChannel) -> Any:
        found: Any = of_interpreter(channel)
        for each in owners:
            found = getattr(found, each)
        return found

    return Service(
        *(offset, name, READ | WRITE, codec, description, unit),
        read=lambda channel: getattr(owner(channel), field),
        write=lambda channel, value: setattr(owner(channel), field, value),
        guard=_only_interpreters,
        code=error.number,
        **limits,
    )


def channel_function(
    offset: int,
    name: str,
    call: Callable[..., int],
    codec: Codec | tuple[Codec, ...],
    description: str,
) -> Service:
    """A row that is written with the arguments of `call`, a function of the interpreter."""

    def write(channel: NcChannel, data: Any) -> None:
        target = of_interpreter(channel)
        carry_out(call(target, *data) if isinstance(data, tuple) else call(target, data))

    return Service(*(offset, name, WRITE, codec, description), write=write, non_finite=True)
