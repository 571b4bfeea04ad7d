"""I/O structures of encoders and drives, 0x5300 and 0x7300 + ID. Source: 002 §6.4.5.4, §6.4.7.4.

The inputs are those of the simulated hardware. The NC writes its own fields of an output structure
in each cycle; what a client writes stays in all others. The first 12 bytes are the mandatory part,
which is read and written alone too.
"""

import struct
from collections.abc import Callable

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.motion import Axis
from achse.motion.signals import drive_inputs
from achse.motion.states import AxisType, DriveType
from achse.server import READ, WRITE, Layout, Service

__all__ = ["DRIVE_CYCLIC", "DRIVE_IO", "ENCODER_CYCLIC", "ENCODER_IO"]

SHORT_IO_SIZE = 12
IO_SIZE = 40
LONG_IO_SIZE = 80
"""Encoder interface with 64-bit values (NCENCODERSTRUCT_IN3, _OUT3)."""

_DWORD = struct.Struct("<I")
_ENCODER_IN = struct.Struct("<iiBBBBiiiiBBBBii")
_ENCODER_IN_LONG = struct.Struct("<8Q6Hi")
_DRIVE_IN = struct.Struct("<iiBBBBiiiiBBBBii")
_DRIVE_OUT = struct.Struct("<iiBB")
_DRIVE_OUT_REST = struct.Struct("<iiii")

_HIGHEST = 0x7FFF_FFFF

_ABSOLUTE_TIMES = 1 << 0

_ANALOG = {
    DriveType.M2400_DAC1, DriveType.M2400_DAC2, DriveType.M2400_DAC3, DriveType.M2400_DAC4,
    DriveType.MDP_252, DriveType.MDP_252_NONLINEAR, DriveType.UNIVERSAL, DriveType.NC_BACKPLANE,
}  # fmt: skip
_DISCRETE = {DriveType.RAPID_CREEP, DriveType.STEPPER}


def _int32(value: float) -> int:
    """The nearest increment within 32 bits."""
    return round(max(-_HIGHEST - 1.0, min(value, float(_HIGHEST))))


def _io_state(axis: Axis) -> int:
    """Bit 0 the data are invalid (WcState), bit 1 changes with each new value (InputToggle)."""
    return int(axis.owner.simulation_io_invalid) | (axis.owner.set_cycle_counter & 1) << 1


def _time(axis: Axis) -> int:
    """DC time of the inputs, 32 bits signed; relative to the cycle they are taken with it."""
    if not axis.encoder_dead_time_compensation_control & _ABSOLUTE_TIMES:
        return 0
    stamp = axis.owner.dc_time_stamp
    return stamp - 0x1_0000_0000 if stamp > _HIGHEST else stamp


class _EncoderInput:
    """Increments, latched increments, state."""

    size = IO_SIZE
    name = f"NCENCODERSTRUCT_IN2 ({IO_SIZE} bytes)"

    def encode(self, axis: Axis) -> bytes:
        return _ENCODER_IN.pack(
            axis.encoder_hardware_increments,
            _int32(axis.encoder_latch_hardware_increments),
            axis.encoder_latch_active | axis.encoder_latch_valid << 1, 0, 0, _io_state(axis),
            0, 0, 0, 0, 0, 0, 0, 0, _time(axis), 0,
        )  # fmt: skip

    def decode(self, data: bytes) -> tuple[int, ...]:
        return _ENCODER_IN.unpack(data)


class _EncoderInputLong:
    """The same with 64-bit values."""

    size = LONG_IO_SIZE
    name = f"NCENCODERSTRUCT_IN3 ({LONG_IO_SIZE} bytes)"

    def encode(self, axis: Axis) -> bytes:
        return _ENCODER_IN_LONG.pack(
            axis.encoder_hardware_increments & axis.encoder_mask,
            axis.encoder_latch_hardware_increments & axis.encoder_mask,
            0, 0, 0, 0, 0, 0,
            axis.encoder_latch_active | axis.encoder_latch_valid << 1, 0, 0, 0, 0, _io_state(axis),
            _time(axis),
        )  # fmt: skip

    def decode(self, data: bytes) -> tuple[int, ...]:
        return _ENCODER_IN_LONG.unpack(data)


class _DriveInput:
    """Position and torque of the motor, status; bit 7 of status 4 is the fast-stop signal.

    Status 8 shows the digital inputs.
    """

    size = IO_SIZE
    name = f"NCDRIVESTRUCT_IN2 ({IO_SIZE} bytes)"

    def encode(self, axis: Axis) -> bytes:
        torque = axis.drive_actual_torque / (axis.drive_actual_torque_scaling or 1.0)
        ready = axis.owner.simulation_not_ready == 0 and axis.owner.limit_switch == 0
        status = int(ready) | axis.owner.loop_closed << 1
        return _DRIVE_IN.pack(
            axis.encoder_hardware_increments, _int32(torque),
            status, 0, 0, axis.owner.simulation_fast_stop_signal << 7,
            0, 0, 0, 0,
            0, 0, 0, drive_inputs(axis, axis.owner), 0, 0,
        )  # fmt: skip

    def decode(self, data: bytes) -> tuple[int, ...]:
        return _DRIVE_IN.unpack(data)


def _analog(axis: Axis) -> tuple[int, int]:
    """The output of an analog drive: its share of the output mask."""
    percent = (
        axis.drive_output_percent_nonlinear if axis.drive_special else axis.drive_output_percent
    )
    return _int32(percent / 100.0 * axis.drive_output_mask), 0


def _digital(axis: Axis) -> tuple[int, int]:
    """Set position in increments and set velocity, weighted as the drive wants them."""
    owner = axis.owner
    position = owner.set_position - axis.encoder_position_offset - axis.encoder_set_position_offset
    increments = position / axis.encoder_scale * axis.drive_position_scaling
    return _int32(increments), _int32(axis.drive_output * axis.drive_velocity_scaling)


def _further(axis: Axis) -> tuple[int, int, int, int]:
    """Acceleration, torque offset, set torque, following error; each delayed and weighted."""
    owner = axis.owner
    acceleration = owner.set_acceleration - owner.set_jerk * axis.drive_acceleration_output_delay
    torque = owner.set_torque - owner.set_torque_derivative * axis.drive_torque_output_delay
    return (
        _int32(acceleration * axis.drive_acceleration_scaling),
        _int32(owner.set_torque_offset * axis.drive_torque_offset_scaling),
        _int32(torque * axis.drive_set_torque_scaling),
        _int32(owner.following_error / axis.encoder_scale * axis.drive_dsc_xerr_scaling),
    )


def _drive_output(axis: Axis) -> bytes:
    """The whole structure: what clients wrote, and above it what the NC writes."""
    image = bytearray(b"".join(_DWORD.pack(word) for word in axis.drive_output_image))
    kind = axis.drive_type
    if kind in _DISCRETE or axis.owner.axis_type == AxisType.DISCRETE_RAPID_CREEP:
        outputs = 0, 0
        control = axis.drive_control_byte, axis.drive_extended_control_byte
    else:
        outputs = _analog(axis) if kind in _ANALOG else _digital(axis)
        control = axis.owner.loop_closed, image[9]
    _DRIVE_OUT.pack_into(image, 0, *outputs, *control)
    if kind not in _ANALOG and kind not in _DISCRETE:
        _DRIVE_OUT_REST.pack_into(image, 12, *_further(axis))
    return bytes(image)


def _encoder_output(axis: Axis) -> bytes:
    return b"".join(_DWORD.pack(word) for word in axis.encoder_output_image)


class _Output:
    """An output structure of `size` bytes."""

    def __init__(self, name: str, size: int, read: Callable[[Axis], bytes]) -> None:
        self.name = f"{name} ({size} bytes)"
        self.size = size
        self._read = read

    def encode(self, axis: Axis) -> bytes:
        return self._read(axis)[: self.size]

    def decode(self, data: bytes) -> bytes:
        return data


def _write(field: str) -> Callable[[Axis, bytes], None]:
    def write(axis: Axis, data: bytes) -> None:
        image = getattr(axis, field)
        for i in range(len(data) // 4):
            image[i] = _DWORD.unpack_from(data, 4 * i)[0]

    return write


def _write_bits(field: str) -> Callable[[Axis, tuple[int, int, int]], None]:
    """Change the bits of a mask in the double word at a byte offset; bytes beyond are cut."""

    def write(axis: Axis, access: tuple[int, int, int]) -> None:
        offset, mask, value = access
        if offset >= IO_SIZE:
            raise DeviceError(ReturnCode.INVALID_DATA, f"byte offset {offset}, expected 0..39")
        image = getattr(axis, field)
        words = IO_SIZE // 4
        content = bytearray(b"".join(_DWORD.pack(image[i]) for i in range(words)) + bytes(4))
        (before,) = _DWORD.unpack_from(content, offset)
        _DWORD.pack_into(content, offset, before & ~mask | value & mask)
        for i in range(words):
            image[i] = _DWORD.unpack_from(content, 4 * i)[0]

    return write


def _output(codecs: tuple[_Output, ...], field: str, description: str) -> Service:
    return Service(
        0x00,
        "output_structure",
        READ | WRITE,
        codecs,
        description,
        read=lambda axis: axis,
        write=_write(field),
    )


def _bits(field: str) -> Service:
    return Service(
        0x01,
        "output_structure_bit_access",
        WRITE,
        Layout("<III"),
        "byte offset, bits to change, their values: writes single bits of the output structure",
        write=_write_bits(field),
    )


_ENCODER_OUT = (
    _Output("NCENCODERSTRUCT_OUT", SHORT_IO_SIZE, _encoder_output),
    _Output("NCENCODERSTRUCT_OUT2", IO_SIZE, _encoder_output),
)
_ENCODER_OUT_LONG = _Output("NCENCODERSTRUCT_OUT3", LONG_IO_SIZE, _encoder_output)
_DRIVE_OUTPUTS = (
    _Output("NCDRIVESTRUCT_OUT", SHORT_IO_SIZE, _drive_output),
    _Output("NCDRIVESTRUCT_OUT2", IO_SIZE, _drive_output),
)


def _input(
    codecs: tuple[_EncoderInput | _EncoderInputLong | _DriveInput, ...], what: str
) -> Service:
    return Service(0x80, "input_structure", READ, codecs, what, read=lambda axis: axis)


ENCODER_IO = (
    _output(_ENCODER_OUT, "encoder_output_image", "outputs of the encoder"),
    _input((_EncoderInput(),), "inputs of the encoder"),
)
"""As the axis shows them."""

ENCODER_CYCLIC = (
    _output((*_ENCODER_OUT, _ENCODER_OUT_LONG), "encoder_output_image", "outputs of the encoder"),
    _bits("encoder_output_image"),
    _input((_EncoderInput(), _EncoderInputLong()), "inputs of the encoder"),
)

DRIVE_IO = (
    _output(_DRIVE_OUTPUTS, "drive_output_image", "outputs of the drive"),
    _input((_DriveInput(),), "inputs of the drive"),
)

DRIVE_CYCLIC = (*DRIVE_IO, _bits("drive_output_image"))
