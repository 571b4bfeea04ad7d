"""Calls of commands by function rows: the request is the arguments, a refusal the result."""

from collections.abc import Callable
from typing import Any

from achse.ams import DeviceError
from achse.codes.nc.row import NcRow
from achse.devices.nc.rows import bound
from achse.motion import Axis, CommandState
from achse.server import Service


def carry_out(code: int) -> None:
    """Raise what a command answered, if it refused."""
    if code:
        raise DeviceError(code)


def numbered(axis: Axis, code: int) -> tuple[int, int]:
    """Number and state of the command that just answered `code`; raises if it refused."""
    carry_out(code)
    number = axis.command_counter
    active = axis.set_command_number == number
    return number, axis.set_command_state if active else CommandState.BUFFERED


def function(row: NcRow, call: Callable[..., int]) -> Service:
    """Return the service that is written with the arguments of `call`, an axis command."""

    def write(axis: Axis, data: Any) -> None:
        carry_out(call(axis, *data) if isinstance(data, tuple) else call(axis, data))

    # the command says what is wrong with a number, by an NC code
    return bound(row, write=write, non_finite=True)
