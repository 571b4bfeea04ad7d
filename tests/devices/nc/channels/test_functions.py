"""Functions of a channel: a part program by the documented services."""

import struct
from typing import Any

import pytest

from achse.motion.channels.states import InterpreterState as State

F, S, C = 0x2201, 0x2101, 0x2301

PROGRAM = "N10 G01 X10 Y0 F6000\nN20 G02 X20 Y10 I10 J0\nN30 M40\nN40 G01 X0\nN50 M30\n"


def state(bench: Any) -> State:
    return State(bench.get(S, 0x03, "<I"))


def load(bench: Any, text: str, name: str = "part.nc") -> None:
    (bench.folder / name).write_text(text)
    bench.write(F, 0x04, f"C:\\CNC\\{name}".encode() + b"\0")


def handshake(bench: Any) -> tuple[int, int]:
    number, request = struct.unpack_from("<HH", bench.read(C, 0x80, 160), 24)
    return number, request


def test_load_start_handshake_stop_reset(programs: Any, refused: Any) -> None:
    with refused(0x4050):
        programs.write(F, 0x02)
    load(programs, PROGRAM)
    assert state(programs) is State.READY
    assert programs.read(S, 0x07, 101) == b"part.nc\0"
    programs.write(F, 0x02)
    with refused(0x4109):
        programs.write(F, 0x04, b"part.nc")
    programs.until(lambda: handshake(programs) == (40, 1))
    assert programs.axes(1, 2, 3) == pytest.approx([20.0, 10.0, 0.0])
    assert programs.get(S, 0x12, "<II260s")[:2] == (1, PROGRAM.index("N20"))
    programs.write(C, 0x00, struct.pack("<HHH122x", 0, 0, 1))
    programs.until(lambda: handshake(programs)[1] == 0)
    programs.write(C, 0x00, bytes(150))
    programs.until(lambda: state(programs) is State.READY)
    assert programs.axes(1, 2) == pytest.approx([0.0, 10.0])
    programs.write(F, 0x02)
    programs.run(0.2)
    programs.write(F, 0x11)
    assert state(programs) is State.STOPPING
    programs.until(lambda: state(programs) is State.IDLE)
    with refused(0x42C5):
        programs.write(F, 0x02)
    programs.write(F, 0x10)
    programs.run(0.01)
    load(programs, PROGRAM)


def test_the_place_of_a_fault(programs: Any) -> None:
    load(programs, "N10 G01 X1 F600\nN20 G999\n")
    programs.write(F, 0x02)
    programs.until(lambda: state(programs) is State.ABORTED)
    index = programs.get(S, 0x10, "<I")
    assert index == 16
    line = programs.exchange(S, 0x11, 64, struct.pack("<I", index))
    assert line.split(b"\0")[0] == b"N20 G999"
    source, offset, _ = programs.get(S, 0x12, "<II260s")
    assert (source, offset) == (3, 16)
    assert programs.get(S, 0x01, "<i") != 0


def test_what_functions_refuse(programs: Any, refused: Any) -> None:
    for offset, data, code in (
        (0x04, b"none.nc", 0x4110),
        (0x04, b"x" * 101, 0x4119),
        (0x01, struct.pack("<I", 5), 0x4110),
        (0x05, struct.pack("<H", 3), 0x4108),
        (0x06, b"nowhere", 0x4110),
        (0x12, b"", 0x4109),
        (0x13, b"", 0x4109),
        (0x18, struct.pack("<4Id", 7, 0, 0, 0, 0.0), 0x4108),
        (0x18, struct.pack("<4Id", 1, 0, 0, 0, 101.0), 0x4108),
        (0x19, b"", 0x4109),
        (0x21, b"", 0x4110),
        (0x23, b"", 0x4110),
        (0x25, struct.pack("<32sI", b"none", 1), 0x4110),
        (0x24, struct.pack("<32sI", b"../x", 1), 0x4108),
        (0x30, b"", 0x410A),
        (0x40, b"", 0x42D4),
        (0x60, struct.pack("<H", 160), 0x4104),
    ):
        with refused(code):
            programs.write(F, offset, data)
    for channel in (0x2202, 0x2203, 0x2204):
        with refused(0x703):
            programs.write(channel, 0x02)


def test_tools_shifts_and_snapshots(programs: Any) -> None:
    programs.put(0x2001, 0x4_0302, "<d", 55.5)
    programs.put(0x2001, 0x1_0203, "<d", -3.0)
    programs.put(C, 0x1000_0011, "<d", 8.25)
    for offset in (0x20, 0x22):
        programs.write(F, offset)
    programs.write(F, 0x24, struct.pack("<32sI", b"all", 7))
    for offset in (0x26, 0x27):
        programs.write(F, offset)
    programs.put(C, 0x1000_0011, "<d", 0.0)
    assert programs.get(0x2001, 0x4_0302, "<d") == programs.get(0x2001, 0x1_0203, "<d") == 0.0
    for offset in (0x21, 0x23):
        programs.write(F, offset)
    assert programs.get(0x2001, 0x4_0302, "<d") == 55.5
    assert programs.get(0x2001, 0x1_0203, "<d") == -3.0
    programs.write(F, 0x25, struct.pack("<32sI", b"all", 1))
    assert programs.get(C, 0x1000_0011, "<d") == 8.25
