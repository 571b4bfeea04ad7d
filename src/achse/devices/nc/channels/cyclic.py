"""Cyclic structures of a channel with an interpreter, 0x2300 + ID (002 §6.4.2.4).

Which layout of the structures is meant, that of TwinCAT 3 or 2, tells the length asked for.
"""

import struct

from achse.ams import DeviceError
from achse.codes import NcError, ReturnCode
from achse.devices.nc.channels.binding import LineText, of_interpreter, show_program
from achse.devices.nc.channels.structures import (
    CHANNEL_TO_PLC_TC2,
    CHANNEL_TO_PLC_TC3,
    PLC_TO_CHANNEL_TC2,
    PLC_TO_CHANNEL_TC3,
    ChannelFromPlc,
)
from achse.devices.nc.layouts import REAL64
from achse.gcode.errors import WordRefused
from achse.gcode.registers import REGISTERS, Registers
from achse.motion.channels.channel import NcChannel
from achse.server import READ, WRITE, Repeated, Service

__all__ = ["PROGRAM_CYCLIC"]

_DISPLAYS = 9


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
    """All or none: behind R999 there are none (0x703)."""
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
    Service(
        *(0x00, "plc_to_nc_structure", READ, _FORMS, "cyclic structure from the PLC"),
        read=of_interpreter,
    ),
    Service(
        *(0x00, "plc_to_nc_written", WRITE, _FORMS),
        "the same written: its skip mask and granted M function count",
        write=_take,
        code=NcError.REQUEST_PARAMETER.number,
    ),
    show_program(
        *(0x01, LineText(), "interpreter_program_display", "line that was interpreted last"),
        lambda channel: channel.line_at(channel.interpreter_index),
    ),
    Service(
        *(0x80, "nc_to_plc_structure", READ, (CHANNEL_TO_PLC_TC3, CHANNEL_TO_PLC_TC2)),
        "cyclic structure to the PLC",
        read=of_interpreter,
    ),
    Service(
        *(0x1000_0000, "r_parameter", READ | WRITE, _RegistersFrom(REAL64)),
        *("R parameter by its number, and those behind it as far as the length goes", "1"),
        read=_registers,
        write=_set_registers,
        count=REGISTERS,
    ),
    Service(
        *(0x2000_0001, "group_program_display", READ, LineText()),
        "line that the path of a group is on",
        read=lambda channel, index: _path_line(channel, index),
        count=_DISPLAYS,
    ),
)


def _path_line(channel: NcChannel, index: int) -> str:
    target = of_interpreter(channel)
    return target.line_at(target.path_index) if index == 0 else ""
