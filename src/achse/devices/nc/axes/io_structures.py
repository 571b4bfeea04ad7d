"""I/O structures of encoders and drives, 0x5300 and 0x7300 + ID. Source: 002 §6.4.5.4, §6.4.7.4.

What the hardware port carries (`achse.motion.port`). The NC writes its own fields of an output
structure in each cycle; what a client writes stays in all others. The first 12 bytes are the
mandatory part, which is read and written alone too.
"""

import struct
from collections.abc import Callable
from typing import Any

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.codes.nc.choices import AxisType
from achse.codes.nc.row import NcRow
from achse.codes.nc.table import named_rows
from achse.devices.nc.axes.terminals import note_output, shown_input
from achse.devices.nc.rows import bound
from achse.motion.parts import AxisDrive, AxisEncoder, AxisPart
from achse.motion.states import DISCRETE_DRIVES
from achse.server import Service

_ENCODER = named_rows(0x5300)
_DRIVE = named_rows(0x7300)

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
_ENCODER_OUT_REST = struct.Struct("<BBBB")
_ENCODER_OUT_LONG = struct.Struct("<HHHH")

_HIGHEST = 0x7FFF_FFFF

_ABSOLUTE_TIMES = 1 << 0

_UPPER = 0x8000_0000
_FULL = 0xFFFF_FFFF
_WIDE = 0xFFFF_FFFF_FFFF_FFFF


def _signed(count: int) -> int:
    """Return the lower double word of a count, with its sign."""
    return ((count & _FULL) ^ _UPPER) - _UPPER


def _io_state(part: AxisPart, state: int) -> int:
    """State 4: bit 0 the data are invalid (WcState), bit 1 changes with each new value."""
    return state | (part.owner.set_cycle_counter & 1) << 1


def _time(encoder: AxisEncoder) -> int:
    """DC time of the inputs, 32 bits signed; relative to the cycle they are taken with it."""
    if not encoder.dead_time_compensation_control & _ABSOLUTE_TIMES:
        return 0
    stamp = encoder.owner.dc_time_stamp
    return stamp - 0x1_0000_0000 if stamp > _HIGHEST else stamp


class _EncoderInput:
    """Increments, latched increments, state."""

    size = IO_SIZE
    name = f"NCENCODERSTRUCT_IN2 ({IO_SIZE} bytes)"

    def encode(self, encoder: AxisEncoder) -> bytes:
        io = encoder.io
        data = _ENCODER_IN.pack(
            _signed(io.data_in1), _signed(io.data_in2),
            io.state1, io.state2, io.state3, _io_state(encoder, io.state4),
            *map(_signed, (io.data_in3, io.data_in4, io.data_in5, io.data_in6)),
            io.state5, io.state6, io.state7, io.state8, _time(encoder), 0,
        )  # fmt: skip
        return shown_input(encoder, data)

    def decode(self, data: bytes) -> tuple[int, ...]:
        return _ENCODER_IN.unpack(data)


class _EncoderInputLong:
    """The same with 64-bit values."""

    size = LONG_IO_SIZE
    name = f"NCENCODERSTRUCT_IN3 ({LONG_IO_SIZE} bytes)"

    def encode(self, encoder: AxisEncoder) -> bytes:
        io = encoder.io
        probes = (io.data_in3, io.data_in4, io.data_in5, io.data_in6)
        return _ENCODER_IN_LONG.pack(
            io.data_in1 & _FULL, io.data_in2 & _FULL, *(each & _WIDE for each in probes), 0, 0,
            io.state1, io.state2, io.state5 | io.state6 << 8, io.state7 | io.state8 << 8, 0,
            _io_state(encoder, io.state4), _time(encoder),
        )  # fmt: skip

    def decode(self, data: bytes) -> tuple[int, ...]:
        return _ENCODER_IN_LONG.unpack(data)


class _DriveInput:
    """Position, torque and velocity of the motor, status, digital inputs."""

    size = IO_SIZE
    name = f"NCDRIVESTRUCT_IN2 ({IO_SIZE} bytes)"

    def encode(self, drive: AxisDrive) -> bytes:
        io = drive.io
        data = _DRIVE_IN.pack(
            _signed(io.data_in1), io.data_in2,
            io.state1, io.state2, io.state3, _io_state(drive, io.state4),
            io.data_in3, 0, 0, 0, 0, 0, 0, io.state8, 0, 0,
        )  # fmt: skip
        return shown_input(drive, data)

    def decode(self, data: bytes) -> tuple[int, ...]:
        return _DRIVE_IN.unpack(data)


def _drive_output(drive: AxisDrive) -> bytes:
    """Return the whole structure: what clients wrote, and above it what the NC writes.

    While the output is switched off (0x60) the NC writes nothing: registers of a terminal are read
    and written meanwhile (004 §3.3).
    """
    image = bytearray(b"".join(_DWORD.pack(word) for word in drive.output_image))
    if drive.owner.drive_output_disabled:
        return bytes(image)
    io = drive.io
    if drive.type in DISCRETE_DRIVES or drive.owner.axis_type == AxisType.DISCRETE_RAPID_CREEP:
        _DRIVE_OUT.pack_into(image, 0, 0, 0, io.ctrl1, io.ctrl2)
        return bytes(image)
    digital = drive.digital
    control2 = io.ctrl2 if digital else image[9]
    _DRIVE_OUT.pack_into(image, 0, io.data_out1, io.data_out2, io.ctrl1, control2)
    if digital:
        image[10] = io.ctrl3
        _DRIVE_OUT_REST.pack_into(image, 12, io.data_out3, io.data_out4, io.data_out5, io.data_out6)
    return bytes(image)


def _encoder_image(encoder: AxisEncoder) -> bytearray:
    return bytearray(b"".join(_DWORD.pack(word) for word in encoder.output_image))


def _encoder_output(encoder: AxisEncoder) -> bytes:
    """Return the image that clients wrote, with the control bytes of latches while they are
    armed."""
    image = _encoder_image(encoder)
    if encoder.armed:
        io = encoder.io
        image[8] = io.ctrl1
        _ENCODER_OUT_REST.pack_into(image, 28, io.ctrl5, io.ctrl6, io.ctrl7, io.ctrl8)
    return bytes(image)


def _encoder_output_long(encoder: AxisEncoder) -> bytes:
    """Return the same with the controls of the 64-bit structure, two touch probes in each."""
    image = _encoder_image(encoder)
    if encoder.armed:
        io = encoder.io
        probes = io.ctrl5 | io.ctrl6 << 8, io.ctrl7 | io.ctrl8 << 8
        _ENCODER_OUT_LONG.pack_into(image, 64, io.ctrl1, 0, *probes)
    return bytes(image)


class _Output:
    """An output structure of `size` bytes."""

    def __init__(self, name: str, size: int, read: Callable[[Any], bytes]) -> None:
        self.name = f"{name} ({size} bytes)"
        self.size = size
        self._read = read

    def encode(self, part: Any) -> bytes:
        return self._read(part)[: self.size]

    def decode(self, data: bytes) -> bytes:
        return data


def _write(field: str) -> Callable[[Any, bytes], None]:
    def write(part: Any, data: bytes) -> None:
        image = getattr(part, field)
        for i in range(len(data) // 4):
            image[i] = _DWORD.unpack_from(data, 4 * i)[0]
        note_output(part)

    return write


def _write_bits(field: str) -> Callable[[Any, tuple[int, int, int]], None]:
    """Change the bits of a mask in the double word at a byte offset; bytes beyond are cut."""

    def write(part: Any, access: tuple[int, int, int]) -> None:
        offset, mask, value = access
        if offset >= IO_SIZE:
            raise DeviceError(ReturnCode.INVALID_DATA, f"byte offset {offset}, expected 0..39")
        image = getattr(part, field)
        words = IO_SIZE // 4
        content = bytearray(b"".join(_DWORD.pack(image[i]) for i in range(words)) + bytes(4))
        (before,) = _DWORD.unpack_from(content, offset)
        _DWORD.pack_into(content, offset, before & ~mask | value & mask)
        for i in range(words):
            image[i] = _DWORD.unpack_from(content, 4 * i)[0]
        note_output(part)

    return write


def _output(row: NcRow, codecs: tuple[_Output, ...], field: str) -> Service:
    return bound(row, codec=codecs, read=lambda part: part, write=_write(field))


def _bits(row: NcRow, field: str) -> Service:
    return bound(row, write=_write_bits(field))


_ENCODER_OUT = (
    _Output("NCENCODERSTRUCT_OUT", SHORT_IO_SIZE, _encoder_output),
    _Output("NCENCODERSTRUCT_OUT2", IO_SIZE, _encoder_output),
)
_ENCODER_OUTPUT_LONG = _Output("NCENCODERSTRUCT_OUT3", LONG_IO_SIZE, _encoder_output_long)
_DRIVE_OUTPUTS = (
    _Output("NCDRIVESTRUCT_OUT", SHORT_IO_SIZE, _drive_output),
    _Output("NCDRIVESTRUCT_OUT2", IO_SIZE, _drive_output),
)


def _input(row: NcRow, *codecs: _EncoderInput | _EncoderInputLong | _DriveInput) -> Service:
    return bound(row, codec=codecs, read=lambda part: part)


ENCODER_IO = (
    _output(_ENCODER["output_structure"], _ENCODER_OUT, "encoder_output_image"),
    _input(_ENCODER["input_structure"], _EncoderInput()),
)
"""As the axis shows them."""

ENCODER_CYCLIC = (
    _output(
        _ENCODER["output_structure"], (*_ENCODER_OUT, _ENCODER_OUTPUT_LONG), "encoder_output_image"
    ),
    _bits(_ENCODER["output_structure_bit_access"], "encoder_output_image"),
    _input(_ENCODER["input_structure"], _EncoderInput(), _EncoderInputLong()),
)

DRIVE_IO = (
    _output(_DRIVE["output_structure"], _DRIVE_OUTPUTS, "drive_output_image"),
    _input(_DRIVE["input_structure"], _DriveInput()),
)

DRIVE_CYCLIC = (*DRIVE_IO, _bits(_DRIVE["output_structure_bit_access"], "drive_output_image"))
