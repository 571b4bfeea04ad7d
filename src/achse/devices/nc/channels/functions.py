"""Functions of a channel with an interpreter, 0x2200 + ID (002 §6.4.2.3)."""

from achse.codes import NcError
from achse.codes.nc.row import NcRow
from achse.codes.nc.table import named_rows
from achse.devices.nc.channels.binding import channel_function
from achse.motion.channels.program_channel import ProgramChannel
from achse.motion.channels.technology import M_FUNCTIONS
from achse.server import Service

_ROWS = named_rows(0x2200)


def _text(name: bytes) -> str:
    return name.split(b"\0", 1)[0].decode("cp1252", "replace")


def _search(
    channel: ProgramChannel, mode: int, dry_run: int, wanted: int, reserved: int, percent: float
) -> int:
    return channel.enable_search(mode, dry_run, wanted, percent)


def _retrace(channel: ProgramChannel, direction: int, entry: int, *places: float) -> int:
    """Direction 1 forward, 2 back; the place to begin at is always the present one: entry 0."""
    if direction not in (_FORWARD, _BACKWARD):
        return NcError.CHANNEL_START_PARAMETER
    return NcError.RETRACE_INDEX if entry else channel.retrace(direction == _BACKWARD)


def _end_retrace(channel: ProgramChannel) -> int:
    return channel.retrace(backwards=False)


def _save(channel: ProgramChannel, name: bytes, mask: int) -> int:
    return channel.files.save_snapshot(_text(name), mask)


def _load(channel: ProgramChannel, name: bytes, mask: int) -> int:
    return channel.files.load_snapshot(_text(name), mask)


def _clear_tools(channel: ProgramChannel) -> int:
    channel.data.tools.clear()
    return 0


def _clear_shifts(channel: ProgramChannel) -> int:
    channel.data.shifts.clear()
    return 0


def _reset_fast(channel: ProgramChannel, number: int) -> int:
    if number >= M_FUNCTIONS:
        return NcError.CHANNEL_M_FUNCTION_INDEX
    return channel.reset_fast(number)


def _files(row: NcRow, method: str) -> Service:
    return channel_function(row, lambda channel: getattr(channel.files, method)())


_FORWARD, _BACKWARD = 1, 2

PROGRAM_FUNCTIONS = (
    channel_function(_ROWS["load_program_by_number"], ProgramChannel.load_number),
    channel_function(_ROWS["start_interpreter"], ProgramChannel.start),
    channel_function(_ROWS["load_program_by_name"], ProgramChannel.load),
    channel_function(_ROWS["set_interpreter_operation_mode"], ProgramChannel.set_operation_mode),
    channel_function(
        _ROWS["set_subroutine_path"],
        lambda channel, name: channel.files.store.set_subroutine_path(name),
    ),
    channel_function(_ROWS["retry"], ProgramChannel.retry),
    channel_function(_ROWS["skip"], ProgramChannel.skip),
    channel_function(_ROWS["enable_retrace"], _retrace),
    channel_function(_ROWS["disable_retrace"], _end_retrace),
    channel_function(_ROWS["enable_block_search"], _search),
    channel_function(_ROWS["step_on_after_block_search"], ProgramChannel.step_on_after_search),
    _files(_ROWS["save_zero_offsets"], "save_shifts"),
    _files(_ROWS["load_zero_offsets"], "load_shifts"),
    _files(_ROWS["save_tool_compensations"], "save_tools"),
    _files(_ROWS["load_tool_compensations"], "load_tools"),
    channel_function(_ROWS["save_interpreter_snapshot"], _save),
    channel_function(_ROWS["load_interpreter_snapshot"], _load),
    channel_function(_ROWS["clear_tool_parameters"], _clear_tools),
    channel_function(_ROWS["clear_zero_offsets"], _clear_shifts),
    channel_function(_ROWS["go_ahead"], ProgramChannel.go_ahead),
    channel_function(_ROWS["delete_distance_to_go"], ProgramChannel.delete_distance_to_go),
    channel_function(_ROWS["reset_fast_m_function"], _reset_fast),
)
