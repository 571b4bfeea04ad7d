"""Parameters of a channel with an interpreter, 0x2000 + ID (002 §6.4.2.1)."""

from collections.abc import Callable
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError, ReturnCode
from achse.codes.nc.row import NcRow
from achse.codes.nc.table import named_rows, rows_of
from achse.devices.nc.channels.binding import (
    of_interpreter,
    only_interpreters,
    program_value,
    show_program,
)
from achse.devices.nc.rows import bound
from achse.gcode.geometry.compensation import BottleneckMode
from achse.gcode.state.mfunctions import MAX_CLEARED, NO_RULE
from achse.gcode.state.offsets import ZeroShift
from achse.gcode.state.tool_table import ToolParameter
from achse.motion.channels.channel import NcChannel
from achse.motion.channels.program_channel import LOAD_BUFFER, ProgramChannel
from achse.motion.channels.technology import M_FUNCTIONS
from achse.server import Service

_ROWS = named_rows(0x2000)
_ZERO_OFFSETS = [row for row in rows_of(0x2000) if row.name == "zero_offset"]


_TOOL_STEP = 0x100
_TOOL_PARAMETERS = 14

_NO_M = -1
"""An empty place in the list of M functions that one clears."""


def _m_rules(channel: NcChannel, request: tuple[int, int]) -> list[tuple[int, ...]]:
    first, count = request
    if first >= M_FUNCTIONS or not 1 <= count <= M_FUNCTIONS - first:
        raise DeviceError(NcError.CHANNEL_M_FUNCTION_INDEX.number, f"M{first}, {count} of them")
    rules = of_interpreter(channel).data.m_rules
    pairs = []
    for number in range(first, first + count):
        rule = rules.get(number, NO_RULE)
        clears = [*rule.clears, *(_NO_M,) * (MAX_CLEARED - len(rule.clears))]
        pairs.append((int(rule.mask), *clears))
    return pairs


def _shift_service(axis: int, row: NcRow) -> Service:
    """0x00010K0L: K is the axis from 1 on, L the entry."""

    def read(channel: NcChannel, index: int) -> float:
        return of_interpreter(channel).data.shifts[ZeroShift(index + 1), axis]

    def write(channel: NcChannel, index: int, value: float) -> None:
        of_interpreter(channel).data.shifts[ZeroShift(index + 1), axis] = value

    return bound(row, read=read, write=write)


def _tool_service(row: NcRow, parameter: Callable[[int], int | None]) -> Service:
    """0x000xww00 + n: ww is the tool; `parameter` of the low byte, None if there is none."""

    def place(channel: NcChannel, index: int) -> tuple[Any, int]:
        service = parameter(index % _TOOL_STEP)
        data = of_interpreter(channel).data
        if service is None:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"{row.name} {index % _TOOL_STEP}")
        return data.tools[index // _TOOL_STEP + 1], service

    def read(channel: NcChannel, index: int) -> float:
        tool, number = place(channel, index)
        value = tool[number]
        return value if row.layout == "REAL64" else int(value)

    def write(channel: NcChannel, index: int, value: float) -> None:
        tool, number = place(channel, index)
        tool[number] = float(value)

    return bound(row, read=read, write=write)


def _only(parameter: int) -> Callable[[int], int | None]:
    return lambda low: None if low else parameter


def _numbered(low: int) -> int | None:
    return low + 1 if low < _TOOL_PARAMETERS else None


def _ball(channel: NcChannel, index: int) -> float:
    return of_interpreter(channel).tolerance_balls[index]


def _set_ball(channel: NcChannel, index: int, radius: float) -> None:
    of_interpreter(channel).tolerance_balls[index] = radius


def _number(channel: ProgramChannel) -> int:
    return channel.program_number


def _offsets(row: NcRow, field: str) -> Service:
    """Return up to four group states that the cyclic interface shows."""

    def write(channel: NcChannel, values: tuple[int, ...]) -> None:
        if len(values) != 4:
            raise DeviceError(ReturnCode.INVALID_SIZE, "four offsets")
        setattr(of_interpreter(channel), field, values)

    return bound(
        row,
        read=lambda channel: getattr(of_interpreter(channel), field),
        write=write,
        guard=only_interpreters,
    )


PROGRAM_PARAMETERS = (
    show_program(_ROWS["program_load_buffer_size"], lambda channel: LOAD_BUFFER),
    show_program(_ROWS["program_number"], _number),
    program_value(_ROWS["load_log_mode"], "load_log_mode"),
    program_value(_ROWS["trace_mode"], "trace_mode"),
    program_value(_ROWS["feeder_log_enable"], "feeder_log_enable"),
    program_value(_ROWS["nc_logger_level"], "nc_logger_level"),
    bound(_ROWS["m_function_rules"], exchange=_m_rules),
    program_value(_ROWS["g70_factor"], "data.inch"),
    program_value(_ROWS["g71_factor"], "data.metric"),
    program_value(_ROWS["default_g_code_enable"], "default_g_code"),
    program_value(_ROWS["bottleneck_reaction"], "data.bottleneck.mode", choices=BottleneckMode),
    program_value(_ROWS["bottleneck_look_ahead"], "data.bottleneck.look_ahead"),
    program_value(_ROWS["interpolation_rule_readout_enable"], "readout"),
    program_value(_ROWS["retrace_enable"], "retrace_enable"),
    _offsets(_ROWS["cyclic_interface_uint32_offsets"], "whole_offsets"),
    _offsets(_ROWS["cyclic_interface_real64_offsets"], "real_offsets"),
    *map(_shift_service, range(3), _ZERO_OFFSETS),
    _tool_service(_ROWS["tool_number"], _only(ToolParameter.NUMBER)),
    _tool_service(_ROWS["tool_type"], _only(ToolParameter.TYPE)),
    _tool_service(_ROWS["tool_parameter"], _numbered),
    bound(
        _ROWS["tolerance_ball_radius"],
        read=_ball,
        write=_set_ball,
        code=NcError.NCI_TOLERANCE_SPHERE.number,
    ),
)
