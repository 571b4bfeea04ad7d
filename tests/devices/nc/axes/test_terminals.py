"""Registers of terminals behind an axis, through the I/O structures of drive and encoder."""

import struct
from typing import Any

import pytest

from achse.codes.nc.choices import DriveType, EncoderType
from achse.devices.nc.axes.terminals import RegisterTerminal, note_output, shown_input, terminal_of

FUNCTION, ENCODER, DRIVE, BITS, INPUT = 0x4201, 0x5301, 0x7301, 0x01, 0x80
STEPPER = {"drive_type": DriveType.KL2531_KL2541}
PULSES = {"drive_type": DriveType.MDP_252}
SSI = {"encoder_type": EncoderType.MDP_500_501}


def _read(bench: Any, group: int) -> tuple[int, int]:
    """Status byte and first word of an input structure."""
    data = bench.read(group, INPUT, 40)
    return data[8], struct.unpack_from("<H", data)[0]


@pytest.mark.parametrize(
    ("kinds", "control", "data", "type"),
    [(STEPPER, DRIVE, 4, 2541), (PULSES, ENCODER, 0, 2502), (SSI, ENCODER, 0, 5001)],
)
def test_registers_of_each_kind(
    make_bench: Any, kinds: dict[str, Any], control: int, data: int, type: int
) -> None:
    bench = make_bench(**kinds)
    before = _read(bench, ENCODER), _read(bench, DRIVE)

    def access(byte: int, word: int = 0) -> int:
        bench.put(control, BITS, "<III", 8, 0xFF, byte & ~0x40)  # chosen before data change
        bench.put(DRIVE, BITS, "<III", data, 0xFFFF, word)
        bench.put(control, BITS, "<III", 8, 0xFF, byte)
        assert _read(bench, control)[0] == 0x80 | byte & 0x3F
        return _read(bench, ENCODER)[1]

    bench.put(DRIVE, BITS, "<III", data, 0xFFFF, 1)
    bench.put(control, BITS, "<III", 8, 0xFF, 0x88)
    assert (_read(bench, ENCODER), _read(bench, DRIVE)) == before  # the NC has the outputs
    bench.put(FUNCTION, 0x60, "")
    assert access(0x80 | 8) == type
    assert access(0xC0 | 8, 7) == type  # the manufacturer's
    assert access(0xC0 | 40, 1234) == 0  # locked
    assert access(0xC0 | 31, 0x1235) == 0x1235
    assert access(0xC0 | 40, 1234) == 1234
    assert access(0xC0 | 31, 0) == 0
    assert access(0xC0 | 40, 9) == access(0x80 | 40) == 1234
    bench.put(control, BITS, "<III", 8, 0xFF, 0)
    assert (_read(bench, ENCODER), _read(bench, DRIVE)) == before
    bench.put(FUNCTION, 0x61, "")
    bench.put(control, BITS, "<III", 8, 0xFF, 0x80 | 40)
    assert (_read(bench, ENCODER), _read(bench, DRIVE)) == before


def test_other_drives_have_no_terminal(make_bench: Any) -> None:
    axis = make_bench(drive_type=DriveType.KL2532_KL2542).axis
    assert terminal_of(axis) is None
    axis.drive_output_disabled = 1
    note_output(axis.drive)
    assert shown_input(axis.drive, bytes(40)) == bytes(40)


def test_a_terminal_stays_with_its_axis_until_its_kind_changes(make_bench: Any) -> None:
    axis = make_bench(**STEPPER).axis
    terminal = terminal_of(axis)
    assert isinstance(terminal, RegisterTerminal)
    assert terminal_of(axis) is terminal
    axis.drive.type = DriveType.MDP_252
    other = terminal_of(axis)
    assert isinstance(other, RegisterTerminal)
    assert (other.registers[8], other.in_drive) == (2502, False)
