"""Parameters of a channel with an interpreter, 0x2000 + ID (002 §6.4.2.1)."""

from collections.abc import Callable
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError, ReturnCode
from achse.devices.nc.channels.binding import of_interpreter, program_value, show_program
from achse.devices.nc.layouts import REAL64, UINT16, UINT32
from achse.gcode.compensation import BottleneckMode
from achse.gcode.mfunctions import MAX_CLEARED, NO_RULE
from achse.gcode.offsets import ZeroShift
from achse.gcode.tool_table import ToolParameter
from achse.motion.channels.channel import NcChannel
from achse.motion.channels.program_channel import LOAD_BUFFER, ProgramChannel
from achse.motion.channels.technology import M_FUNCTIONS
from achse.server import READ, READ_WRITE, WRITE, Layout, Repeated, Service

__all__ = ["PROGRAM_PARAMETERS"]

_TOOLS = 50
"""Tools that have rows; programs reach 255."""

_TOOL_STEP = 0x100
_TOOL_PARAMETERS = 14
_BALLS = 9

_NO_M = -1
"""An empty place in the list of M functions that one clears."""


def _m_rules(channel: NcChannel, request: tuple[int, int]) -> list[tuple[int, ...]]:
    first, count = request
    if first >= M_FUNCTIONS or not 1 <= count <= M_FUNCTIONS - first:
        raise DeviceError(NcError.CHANNEL_M_FUNCTION_INDEX.number, f"M{first}, {count} of them")
    rules = of_interpreter(channel).data.m_rules
    found = []
    for number in range(first, first + count):
        rule = rules.get(number, NO_RULE)
        clears = [*rule.clears, *(_NO_M,) * (MAX_CLEARED - len(rule.clears))]
        found.append((int(rule.mask), *clears))
    return found


def _shift_row(axis: int) -> Service:
    """0x00010K0L: K is the axis from 1 on, L the entry."""

    def read(channel: NcChannel, index: int) -> float:
        return of_interpreter(channel).data.shifts[ZeroShift(index + 1), axis]

    def write(channel: NcChannel, index: int, value: float) -> None:
        of_interpreter(channel).data.shifts[ZeroShift(index + 1), axis] = value

    return Service(
        *(0x1_0001 + 0x100 * (axis + 1), "zero_offset", READ | WRITE, REAL64),
        f"zero shift of {'XYZ'[axis]}: G54 fine, coarse, G55 …, G58, G59",
        "e.g. mm",
        read=read,
        write=write,
        count=len(ZeroShift),
    )


def _tool_row(
    offset: int, name: str, codec: Any, description: str, parameter: Callable[[int], int | None]
) -> Service:
    """0x000xww00 + n: ww is the tool; `parameter` of the low byte, None if there is none."""

    def place(channel: NcChannel, index: int) -> tuple[Any, int]:
        found = parameter(index % _TOOL_STEP)
        data = of_interpreter(channel).data
        if found is None:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"{name} {index % _TOOL_STEP}")
        return data.tools[index // _TOOL_STEP + 1], found

    def read(channel: NcChannel, index: int) -> float:
        tool, number = place(channel, index)
        value = tool[number]
        return value if codec is REAL64 else int(value)

    def write(channel: NcChannel, index: int, value: float) -> None:
        tool, number = place(channel, index)
        tool[number] = float(value)

    return Service(
        *(offset, name, READ | WRITE, codec, description),
        read=read,
        write=write,
        count=_TOOLS * _TOOL_STEP,
    )


def _only(parameter: int) -> Callable[[int], int | None]:
    return lambda low: None if low else parameter


def _numbered(low: int) -> int | None:
    return low + 1 if low < _TOOL_PARAMETERS else None


def _ball(channel: NcChannel, index: int) -> float:
    return of_interpreter(channel).tolerance_balls[index]


def _set_ball(channel: NcChannel, index: int, radius: float) -> None:
    of_interpreter(channel).tolerance_balls[index] = radius


def _offsets(offset: int, name: str, field: str, what: str) -> Service:
    return program_value(
        *(offset, Repeated(UINT32), name, f"up to four group states, shown as {what}", field)
    )


def _number(channel: ProgramChannel) -> int:
    return channel.program_number


def _set_offsets(name: str, row: Service) -> Service:
    def write(channel: NcChannel, values: tuple[int, ...]) -> None:
        if len(values) != 4:
            raise DeviceError(ReturnCode.INVALID_SIZE, "four offsets")
        setattr(of_interpreter(channel), name, values)

    return Service(
        *(row.offset, row.name, row.access, row.codec, row.description),
        read=row.read,
        write=write,
        guard=row.guard,
    )


PROGRAM_PARAMETERS = (
    show_program(
        *(0x05, UINT32, "program_load_buffer_size", "longest program, bytes"),
        lambda channel: LOAD_BUFFER,
    ),
    show_program(0x06, UINT32, "program_number", "number of the program, 0 by name", _number),
    program_value(
        *(0x07, UINT32, "load_log_mode", "log while loading: 1 source, 2 compiled too"),
        "load_log_mode",
        minimum=0,
        maximum=2,
    ),
    program_value(
        *(0x08, UINT32, "trace_mode", "log while running: 1 line numbers, 2 source lines"),
        "trace_mode",
        minimum=0,
        maximum=2,
    ),
    program_value(
        *(0x0A, UINT32, "feeder_log_enable", "log every command of the feeder"),
        "feeder_log_enable",
        minimum=0,
        maximum=1,
    ),
    program_value(
        *(0x0B, UINT32, "nc_logger_level", "messages of the channel: 0 errors, 1 all"),
        "nc_logger_level",
        minimum=0,
        maximum=1,
    ),
    Service(
        *(0x10, "m_function_rules", READ_WRITE, Layout("<II")),
        "rule mask and cleared M functions, -1 = none, from a number on",
        exchange=_m_rules,
        response=Repeated(Layout("<B10i")),
    ),
    program_value(
        *(0x12, REAL64, "g70_factor", "mm for a length of 1 behind G70", "data.inch"),
        minimum=1e-9,
        maximum=1e9,
    ),
    program_value(
        *(0x13, REAL64, "g71_factor", "mm for a length of 1 behind G71", "data.metric"),
        minimum=1e-9,
        maximum=1e9,
    ),
    program_value(
        *(0x15, (UINT16, UINT32), "default_g_code_enable", "run the default G-code first"),
        "default_g_code",
        minimum=0,
        maximum=1,
    ),
    program_value(
        *(0x50, UINT32, "bottleneck_reaction", "0 error, 1 notice and repair, 2 notice"),
        "data.bottleneck.mode",
        choices=BottleneckMode,
    ),
    program_value(
        *(0x51, UINT32, "bottleneck_look_ahead", "elements that are looked at together"),
        "data.bottleneck.look_ahead",
        minimum=1,
        maximum=24,
    ),
    program_value(
        *(0x53, UINT32, "interpolation_rule_readout_enable", "states 0x13 … 0x15 are shown"),
        "readout",
        minimum=0,
        maximum=1,
    ),
    program_value(
        *(0x54, UINT32, "retrace_enable", "the path of the next start is kept for a way back"),
        "retrace_enable",
        minimum=0,
        maximum=1,
    ),
    _set_offsets(
        "whole_offsets",
        _offsets(0x55, "cyclic_interface_uint32_offsets", "whole_offsets", "IntParams"),
    ),
    _set_offsets(
        "real_offsets",
        _offsets(0x56, "cyclic_interface_real64_offsets", "real_offsets", "DoubleParams"),
    ),
    *(_shift_row(axis) for axis in range(3)),
    _tool_row(0x2_0100, "tool_number", UINT16, "number of tool ww", _only(ToolParameter.NUMBER)),
    _tool_row(0x3_0100, "tool_type", UINT16, "type of tool ww", _only(ToolParameter.TYPE)),
    _tool_row(0x4_0101, "tool_parameter", REAL64, "parameter nn of tool ww", _numbered),
    Service(
        *(0x5_0001, "tolerance_ball_radius", READ | WRITE, REAL64),
        "radius in which auxiliary axes of group gg may leave the path",
        "e.g. mm",
        read=_ball,
        write=_set_ball,
        minimum=0.0,
        code=NcError.NCI_TOLERANCE_SPHERE.number,
        count=_BALLS,
    ),
)
