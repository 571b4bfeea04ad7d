"""Axis functions, 0x4200 + ID: commands to an axis.

Each row decodes its request and calls the command of the same name in `achse.motion.commands`; a
refusal travels as the result. Forms without reserved words are those of TwinCAT 2.
Source: 002 §6.4.4.3.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from achse.ams import DeviceError
from achse.devices.nc.binding import per_element
from achse.devices.nc.layouts import UINT32
from achse.motion import Axis, CommandState, commands
from achse.server import READ_WRITE, WRITE, Codec, Layout, Service

__all__ = ["AXIS_FUNCTIONS", "STOP_INFORMATION"]


class _NoData:
    """Functions without data; some clients send a byte all the same, which is passed over."""

    name = "VOID"
    size = None

    def encode(self, value: Any) -> bytes:
        return b""

    def decode(self, data: bytes) -> None:
        return None


class StopDynamics(NamedTuple):
    """Deceleration (mm/s²) and jerk (mm/s³)."""

    deceleration: float
    jerk: float


class TypedPosition(NamedTuple):
    """How a position (mm) is meant, and the position."""

    position_type: int
    position: float


class NewEndPositionAndVelocity(NamedTuple):
    command_type: int
    position_type: int
    position: float
    velocity: float
    switch_position: float


class NewDynamics(NamedTuple):
    acceleration: float
    deceleration: float
    jerk: float


class Start(NamedTuple):
    start_type: int
    end_position: float
    velocity: float


class ExtendedStart(NamedTuple):
    """Start with own dynamics; where `use_default_…` is not 0 the axis default counts."""

    start_type: int
    end_position: float
    velocity: float
    use_default_acceleration: int
    acceleration: float
    use_default_deceleration: int
    deceleration: float
    use_default_jerk: int
    jerk: float


class UniversalStart(NamedTuple):
    start_type: int
    control_mask: int
    end_position: float
    velocity: float
    acceleration: float
    deceleration: float
    jerk: float
    buffer_mode: int
    blending_position: float
    segment_start_velocity: float
    segment_end_velocity: float


def _carried_out(code: int) -> None:
    if code:
        raise DeviceError(code)


def _command(
    offset: int,
    name: str,
    codec: Codec | tuple[Codec, ...],
    description: str,
    call: Callable[[Axis, Any], int],
    *,
    port: int | None = None,
) -> Service:
    return Service(
        offset,
        name,
        WRITE,
        codec,
        description,
        write=lambda axis, request: _carried_out(call(axis, request)),
        port=port,
        non_finite=True,  # the command says what is wrong with a number, by an NC code
    )


def _plain(offset: int, name: str, description: str, call: Callable[[Axis], int]) -> Service:
    return _command(offset, name, _NoData(), description, lambda axis, _: call(axis))


def _start_extended(axis: Axis, request: ExtendedStart) -> int:
    return commands.start(
        axis,
        request.start_type,
        request.end_position,
        request.velocity,
        None if request.use_default_acceleration else request.acceleration,
        None if request.use_default_deceleration else request.deceleration,
        None if request.use_default_jerk else request.jerk,
    )


def _universal_start(axis: Axis, request: UniversalStart) -> tuple[int, int]:
    _carried_out(
        commands.universal_start(
            axis,
            request.start_type,
            request.end_position,
            request.velocity,
            request.acceleration,
            request.deceleration,
            request.jerk,
            request.buffer_mode,
            request.blending_position,
            request.segment_start_velocity,
            request.segment_end_velocity,
        )
    )
    number = axis.command_counter
    active = axis.set_command_number == number
    return number, axis.set_command_state if active else CommandState.BUFFERED


_STOP = Layout("<dd", StopDynamics)

AXIS_FUNCTIONS = (
    _plain(0x01, "reset", "reset the axis", commands.reset),
    _plain(0x02, "stop", "stop with the running deceleration", commands.stop),
    _command(
        0x04,
        "emergency_stop",
        _STOP,
        "stop at least as hard as the running motion",
        lambda axis, request: commands.emergency_stop(axis, *request),
    ),
    _command(
        0x05,
        "parameterized_stop",
        _STOP,
        "stop with the given ramp",
        lambda axis, request: commands.parameterized_stop(axis, *request),
    ),
    _command(
        0x11,
        "new_end_position",
        (Layout("<Id", TypedPosition), Layout("<I4xd", TypedPosition)),
        "change the target of the running move",
        lambda axis, request: commands.new_end_position(axis, *request),
    ),
    _command(
        0x12,
        "new_end_position_and_velocity",
        Layout("<IIddd", NewEndPositionAndVelocity),
        "change target, velocity or both, at once or from a switch position on",
        lambda axis, request: commands.new_end_position_and_velocity(axis, *request),
    ),
    _command(
        0x15,
        "new_dynamics",
        Layout("<ddd", NewDynamics),
        "change the dynamics of the running move",
        lambda axis, request: commands.new_dynamics(axis, *request),
    ),
    Service(
        0x16,
        "universal_axis_start",
        READ_WRITE,
        (
            Layout("<IIdddddIddd", UniversalStart),
            Layout("<IIdddddI4xddd", UniversalStart),
        ),
        "start, stop or halt with buffer mode; answers command number and state",
        exchange=_universal_start,
        response=Layout("<HH"),
        port=501,
        non_finite=True,
    ),
    _plain(0x18, "release_motion_lock", "release 'stop and lock'", commands.release_lock),
    _command(
        0x19,
        "set_external_axis_error",
        UINT32,
        "put the axis into an error",
        commands.set_external_error,
    ),
    *per_element(
        (
            _command(
                0x1A,
                "set_actual_position",
                (Layout("<Id", TypedPosition), Layout("<I4xd", TypedPosition)),
                "give the present position another value",
                lambda axis, request: commands.set_actual_position(axis, *request),
                port=501,
            ),
            _command(0x1B, "set_homed_flag", UINT32, "set the homed flag", commands.set_homed_flag),
        )
    ),
    _command(
        0x20,
        "start",
        (Layout("<Idd", Start), Layout("<I4xdd", Start)),
        "standard start with the axis defaults",
        lambda axis, request: commands.start(axis, *request),
    ),
    _command(
        0x21,
        "start_extended",
        (
            Layout("<IddIdIdId", ExtendedStart),
            Layout("<I4xddI4xdI4xdI4xd", ExtendedStart),
        ),
        "start with own acceleration, deceleration and jerk",
        _start_extended,
    ),
    _plain(0x50, "disable", "disable the complete axis", commands.disable),
    _plain(0x51, "enable", "enable the complete axis", commands.enable),
    _plain(
        0x60,
        "disable_drive_output",
        "switch the drive output off",
        lambda axis: commands.set_drive_output(axis, False),
    ),
    _plain(
        0x61,
        "enable_drive_output",
        "switch the drive output on",
        lambda axis: commands.set_drive_output(axis, True),
    ),
)

STOP_INFORMATION = Service(
    0x18,
    "stop_information",
    READ_WRITE,
    _STOP,
    "distance (mm) and time (s) of a stop begun now",
    exchange=lambda axis, request: commands.stop_information(axis, *request),
    response=Layout("<dd"),
    port=501,
    source="002 §6.4.4.2",
)
