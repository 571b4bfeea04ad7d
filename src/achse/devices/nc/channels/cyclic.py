"""Cyclic structures of a channel with an interpreter, 0x2300 + ID (002 §6.4.2.4).

The requested length selects the layout of the structures, that of TwinCAT 3 or 2.
"""

import struct

from achse.ams import DeviceError
from achse.codes import NcError, ReturnCode
from achse.codes.nc.table import named_rows
from achse.devices.nc.channels.binding import of_interpreter, show_program
from achse.devices.nc.channels.structures import (
    CHANNEL_TO_PLC_TC2,
    CHANNEL_TO_PLC_TC3,
    PLC_TO_CHANNEL_TC2,
    PLC_TO_CHANNEL_TC3,
    ChannelFromPlc,
)
from achse.devices.nc.layouts import REAL64
from achse.devices.nc.rows import bound
from achse.gcode.errors import WordRefused
from achse.gcode.state.registers import REGISTERS, Registers
from achse.motion.channels.channel import NcChannel
from achse.server import Repeated

_ROWS = named_rows(0x2300)


def _take(channel: NcChannel, values: ChannelFromPlc) -> None:
    target = of_interpreter(channel)
    target.data.skip_mask, target.granted = values.skip_mask, values.granted


class _RegistersFrom(Repeated):
    """R parameters from a number on; an answer ends where its length does."""

    def encode(self, value: tuple[Registers, int]) -> bytes:
        registers, number = value
        whole = [*registers.own, *registers.shared][number:]
        return struct.pack(f"<{len(whole)}d", *whole)


def _registers(channel: NcChannel, number: int) -> tuple[Registers, int]:
    return of_interpreter(channel).data.registers, number


def _set_registers(channel: NcChannel, number: int, values: tuple[float, ...]) -> None:
    """Set all registers or none: behind R999 there are none (0x703)."""
    if number + len(values) > REGISTERS:
        raise DeviceError(ReturnCode.INVALID_OFFSET, f"R{number}, {len(values)} of them")
    registers = of_interpreter(channel).data.registers
    try:
        for each, value in enumerate(values, number):
            registers[each] = value
    except WordRefused as refused:
        raise DeviceError(refused.code.number, refused.message) from None


_FORMS = PLC_TO_CHANNEL_TC3, PLC_TO_CHANNEL_TC2

PROGRAM_CYCLIC = (
    bound(_ROWS["plc_to_nc_structure"], codec=_FORMS, read=of_interpreter),
    bound(
        _ROWS["plc_to_nc_written"], codec=_FORMS, write=_take, code=NcError.REQUEST_PARAMETER.number
    ),
    show_program(
        _ROWS["interpreter_program_display"],
        lambda channel: channel.line_at(channel.interpreter_index),
    ),
    bound(
        _ROWS["nc_to_plc_structure"],
        codec=(CHANNEL_TO_PLC_TC3, CHANNEL_TO_PLC_TC2),
        read=of_interpreter,
    ),
    bound(
        _ROWS["r_parameter"], codec=_RegistersFrom(REAL64), read=_registers, write=_set_registers
    ),
    bound(_ROWS["group_program_display"], read=lambda channel, index: _path_line(channel, index)),
)


def _path_line(channel: NcChannel, index: int) -> str:
    target = of_interpreter(channel)
    return target.line_at(target.path_index) if index == 0 else ""
