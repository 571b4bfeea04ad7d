"""Register access of terminals behind an axis: KL2502, KL2541, KL5001 (004 §3.3).

A program that has switched the drive output off (0x60) talks to the terminal through the I/O
structures of drive and encoder. The control byte says what: bit 7 register access, bit 6 write,
bits 0 … 5 the register; the status byte answers with bit 7 and the register, the data word with its
value. Registers 0 … 30 are the manufacturer's and stay as they are; those from 32 on take values
while register 31 has the code word. They last as long as the station.

Control and status byte of a stepper terminal are in the drive, of the others in the encoder. Data
out is output word 2 of the drive for the former, word 1 for the latter; data in is input word 1 of
the encoder.
"""

from weakref import WeakKeyDictionary

from achse.codes.nc.choices import DriveType, EncoderType
from achse.motion import Axis
from achse.motion.parts import AxisDrive, AxisEncoder, AxisPart

_ACCESS = 1 << 7
_WRITE = 1 << 6
_NUMBER = 0x3F
_BYTE = 0xFF
_WORD = 0xFFFF

_COUNT = 64
_TYPE_REGISTER = 8
_CODE_REGISTER = 31
_CODE_WORD = 0x1235
_CONTROL = 2
"""Word of an output structure whose lowest byte is the control byte."""
_STATUS_AT = 8
"""Byte of an input structure that is the status byte."""


class RegisterTerminal:
    """The registers of one terminal, `type` is its number (2541)."""

    def __init__(self, type: int, *, in_drive: bool) -> None:
        self.registers = [0] * _COUNT
        self.registers[_TYPE_REGISTER] = type
        self.in_drive = in_drive
        """True if the control and status bytes are in the drive, else they are in the encoder."""
        self.status = 0
        self.value = 0

    def take(self, control: int, data: int) -> None:
        """Execute the register access of the control byte; without bit 7 the terminal shows its
        process data."""
        self.status = self.value = 0
        if not control & _ACCESS:
            return
        number = control & _NUMBER
        open_ = number == _CODE_REGISTER or self.registers[_CODE_REGISTER] == _CODE_WORD
        if control & _WRITE and number >= _CODE_REGISTER and open_:
            self.registers[number] = data
        self.status, self.value = _ACCESS | number, self.registers[number]


_TERMINALS: WeakKeyDictionary[Axis, RegisterTerminal] = WeakKeyDictionary()


def _kind(axis: Axis) -> tuple[int, bool] | None:
    if axis.drive.type == DriveType.KL2531_KL2541:
        return 2541, True
    if axis.encoder.type == EncoderType.MDP_500_501:
        return 5001, False
    if axis.drive.type == DriveType.MDP_252 or axis.encoder.type == EncoderType.MDP_510:
        return 2502, False
    return None


def terminal_of(axis: Axis) -> RegisterTerminal | None:
    """Return the terminal by the kinds of drive and encoder; None if these name none."""
    kind = _kind(axis)
    if kind is None:
        return None
    terminal = _TERMINALS.get(axis)
    if terminal is None or (terminal.registers[_TYPE_REGISTER], terminal.in_drive) != kind:
        terminal = _TERMINALS[axis] = RegisterTerminal(kind[0], in_drive=kind[1])
    return terminal


def note_output(part: AxisPart) -> None:
    """Note that a client has changed the output structure of this part."""
    axis = part.owner
    terminal = terminal_of(axis) if axis.drive_output_disabled else None
    if terminal is not None:
        place = axis.drive if terminal.in_drive else axis.encoder
        data = axis.drive.output_image[1 if terminal.in_drive else 0] & _WORD
        terminal.take(place.output_image[_CONTROL] & _BYTE, data)


def shown_input(part: AxisPart, data: bytes) -> bytes:
    """Return the input structure of this part, with what its terminal shows of a register."""
    axis = part.owner
    terminal = terminal_of(axis) if axis.drive_output_disabled else None
    if terminal is None or not terminal.status:
        return data
    image = bytearray(data)
    if isinstance(part, AxisDrive if terminal.in_drive else AxisEncoder):
        image[_STATUS_AT] = terminal.status
    if isinstance(part, AxisEncoder):
        image[0:4] = terminal.value.to_bytes(4, "little")
    return bytes(image)
