"""States of a channel with an interpreter, 0x2100 + ID (002 §6.4.2.2)."""

import struct
from collections.abc import Callable
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError
from achse.codes.nc.table import named_rows
from achse.codes.program_place import ProgramPlaceRow
from achse.devices.nc.channels.binding import of_interpreter, show_program
from achse.devices.nc.rows import bound
from achse.motion.channels.channel import NcChannel
from achse.motion.channels.planned_path import PlanState
from achse.motion.channels.program_channel import ProgramChannel
from achse.motion.channels.states import InterpreterState

_ROWS = named_rows(0x2100)

_FROM_PATH, _FROM_INTERPRETER, _FROM_ERROR = 1, 2, 3


def _line(channel: NcChannel, index: int) -> str:
    return of_interpreter(channel).line_at(index)


def _program_info(channel: ProgramChannel) -> tuple[int, int, bytes]:
    """Return the block that the path is on; where it is, one at fault; else that of the
    interpreter."""
    if channel.state in (InterpreterState.ABORTING, InterpreterState.ABORTED):
        source, index = _FROM_ERROR, channel.text_index
    elif channel.feeder is not None and channel.feeder.origin is not None:
        source, index = _FROM_PATH, channel.path_index
    else:
        source, index = _FROM_INTERPRETER, channel.interpreter_index
    return source, index, channel.program_name.encode("cp1252", "replace")[:259]


def _readout(read: Callable[[ProgramChannel], Any]) -> Callable[[ProgramChannel], Any]:
    """Only while parameter 0x53 is 1; else 0x4162."""

    def get(channel: ProgramChannel) -> Any:
        if not channel.readout:
            raise DeviceError(NcError.G_STATE_UNKNOWN.number, "parameter 0x53 is 0")
        return read(channel)

    return get


def _words(channel: ProgramChannel) -> tuple[int, ...]:
    return channel.modal.words(channel.data.skip_mask)


def _shifts(channel: ProgramChannel) -> tuple[float, ...]:
    shifts, number = channel.data.shifts, channel.modal.shift
    adjustable = shifts.adjustable(number) if number != 53 else (0.0, 0.0, 0.0)
    return (
        *(channel.block_counter, 0, *adjustable),
        *(*shifts.programmed(58), *shifts.programmed(59)),
    )


def _rotation(channel: ProgramChannel) -> tuple[float, ...]:
    return (channel.block_counter, 0, *channel.modal.rotation)


def _place(channel: ProgramChannel) -> tuple[Any, ...]:
    place = channel.place
    if place is None:
        return ProgramPlaceRow(0).fields
    origin = place.origin
    number = origin.line, origin.block, origin.counter
    return ProgramPlaceRow(place.kind, *number, place.position, origin.program).fields


class _PlannedPart:
    """A part of a planned path: how far the plan is, and points from one on."""

    name = "{plan:UINT32; state:UINT32; count:UINT32; present:UINT32; points:{x:REAL64; y:REAL64;"
    name += " z:REAL64; rapid:UINT32; block:UINT32}[n]}"
    size: int | None = None

    def encode(self, value: tuple[ProgramChannel, int]) -> bytes:
        channel, first = value
        path = channel.planned_path()
        if path is None:
            return _PLAN.pack(channel.plans, PlanState.WHOLE, 0, 0)
        if first != _NO_POINTS and first + _POINTS_AT_ONCE > len(path.points):
            path.go_on()
        points = path.points[first : first + _POINTS_AT_ONCE]
        head = _PLAN.pack(channel.plans, path.state, len(path.points), channel.path_block)
        return head + b"".join(_POINT.pack(*point) for point in points)

    def decode(self, data: bytes) -> tuple[tuple[int, ...], list[tuple[float, ...]]]:
        return _PLAN.unpack_from(data), list(_POINT.iter_unpack(data[_PLAN.size :]))


_PLAN, _POINT = struct.Struct("<4I"), struct.Struct("<3dII")
_POINTS_AT_ONCE = 256
_NO_POINTS = 0xFFFF_FFFF
"""Length of a request for the first four numbers alone."""


PROGRAM_STATES = (
    show_program(_ROWS["interpreter_state"], lambda channel: channel.state),
    show_program(_ROWS["interpreter_operation_mode"], lambda channel: channel.operation_mode),
    show_program(_ROWS["loaded_program_number"], lambda channel: channel.program_number),
    show_program(_ROWS["loaded_program_name"], lambda channel: channel.program_name),
    show_program(_ROWS["interpreter_simulation_mode"], lambda channel: 0),
    show_program(_ROWS["text_index"], lambda channel: channel.text_index),
    bound(_ROWS["program_line"], exchange=_line),
    show_program(_ROWS["current_program_info"], _program_info),
    show_program(_ROWS["active_g_code"], _readout(_words)),
    show_program(_ROWS["active_zero_offsets"], _readout(_shifts)),
    show_program(_ROWS["active_rotation"], _readout(_rotation)),
    bound(_ROWS["program_place"], read=lambda channel: _place(of_interpreter(channel))),
    bound(
        _ROWS["planned_path"],
        exchange=lambda channel, first: (of_interpreter(channel), first),
        response=_PlannedPart(),
    ),
)
