"""Functions of a channel with an interpreter, 0x2200 + ID (002 §6.4.2.3)."""

from achse.codes import NcError
from achse.devices.nc.channels.binding import LineText, channel_function
from achse.devices.nc.layouts import NO_DATA, UINT16, UINT32, request
from achse.motion.channels.program_channel import ProgramChannel
from achse.motion.channels.technology import M_FUNCTIONS
from achse.server import Codec, Layout, Service

__all__ = ["PROGRAM_FUNCTIONS"]

_NAME = LineText()
_SNAPSHOT = Layout("<32sI")
_RETRACE = Layout("<II8d")
_SEARCH = request(mode="I", dry_run="I", wanted="I", reserved="I", percent="d")


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


def _plain(offset: int, name: str, call: object, description: str) -> Service:
    return channel_function(offset, name, call, NO_DATA, description)  # type: ignore[arg-type]


def _files(offset: int, name: str, method: str, description: str) -> Service:
    return _plain(offset, name, lambda channel: getattr(channel.files, method)(), description)


_FORWARD, _BACKWARD = 1, 2
_CODECS: tuple[Codec, ...] = (UINT16, UINT32)

PROGRAM_FUNCTIONS = (
    channel_function(
        *(0x01, "load_program_by_number", ProgramChannel.load_number, UINT32),
        "load the program <number>.nc",
    ),
    _plain(0x02, "start_interpreter", ProgramChannel.start, "start, or go on with a single block"),
    channel_function(
        *(0x04, "load_program_by_name", ProgramChannel.load, _NAME),
        "load a program of the channel's folder",
    ),
    channel_function(
        *(0x05, "set_interpreter_operation_mode", ProgramChannel.set_operation_mode, _CODECS),
        "0, single blocks of the path (1) or of the interpreter (0x4000)",
    ),
    channel_function(
        *(0x06, "set_subroutine_path"),
        lambda channel, name: channel.files.store.set_subroutine_path(name),
        *(_NAME, "folder in which subroutines are searched first; empty: none"),
    ),
    _plain(0x12, "retry", ProgramChannel.retry, "after a fault, run the block at fault again"),
    _plain(0x13, "skip", ProgramChannel.skip, "after a fault, go on behind the block at fault"),
    channel_function(
        *(0x14, "enable_retrace", _retrace, _RETRACE),
        "after an emergency stop, follow the path forward (1) or back (2); entry 0, 8 positions",
    ),
    _plain(0x15, "disable_retrace", _end_retrace, "go forward again, and on with the program"),
    channel_function(
        *(0x18, "enable_block_search", _search, _SEARCH),
        "begin the next start with a search for a block",
    ),
    _plain(
        *(0x19, "step_on_after_block_search", ProgramChannel.step_on_after_search),
        "go on with the found block, where the axes are to be",
    ),
    _files(0x20, "save_zero_offsets", "save_shifts", "write zero shifts into their file"),
    _files(0x21, "load_zero_offsets", "load_shifts", "read zero shifts from their file"),
    _files(0x22, "save_tool_compensations", "save_tools", "write tools into their file"),
    _files(0x23, "load_tool_compensations", "load_tools", "read tools from their file"),
    channel_function(
        *(0x24, "save_interpreter_snapshot", _save, _SNAPSHOT),
        "write R parameters (1), zero shifts (2), tools (4) into a file",
    ),
    channel_function(
        *(0x25, "load_interpreter_snapshot", _load, _SNAPSHOT), "read them from a file"
    ),
    _plain(0x26, "clear_tool_parameters", _clear_tools, "all tools are 0"),
    _plain(0x27, "clear_zero_offsets", _clear_shifts, "all zero shifts are 0"),
    _plain(0x30, "go_ahead", ProgramChannel.go_ahead, "go on behind @717"),
    _plain(
        *(0x40, "delete_distance_to_go", ProgramChannel.delete_distance_to_go),
        "end a move with DelDTG where it is",
    ),
    channel_function(
        *(0x60, "reset_fast_m_function", _reset_fast, UINT16), "clear the bit of a fast M function"
    ),
)
