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


def bits(bench: Any) -> int:
    """Channel state: 8 the path is where it has been, 16 backwards, 32 at the first segment."""
    (value,) = struct.unpack_from("<I", bench.read(C, 0x80, 160), 36)
    return int(value) & 0x3C


def test_the_way_back(programs: Any, refused: Any) -> None:
    """0x54 keeps the path, 0x14 goes back and forward, 0x15 on; M functions are not repeated."""
    back, forward = (struct.pack("<II8d", n, 0, *(0.0,) * 8) for n in (2, 1))
    with refused(0x4109):
        programs.write(F, 0x14, back)
    programs.put(0x2001, 0x54, "<I", 1)
    load(programs, "N10 G01 X10 Y0 F6000\nN20 M7\nN30 Y20 H5\nN40 M9\nN50 X0\nM30\n")
    programs.write(F, 0x02)
    programs.until(lambda: programs.axes(2)[0] > 1.0)
    with refused(0x4109):
        programs.write(F, 0x14, back)
    programs.write(0x320B, 0x04, struct.pack("<dd", 1e5, 1e7))
    programs.until(lambda: programs.get(0x310B, 0x502, "<d") == 0.0)
    assert programs.get(S, 0x12, "<II260s")[1] > 0
    with refused(0x4108):
        programs.write(F, 0x14, struct.pack("<II8d", 3, 0, *(0.0,) * 8))
    with refused(0x4172):
        programs.write(F, 0x14, struct.pack("<II8d", 2, 9, *(0.0,) * 8))
    fast = programs.read(C, 0x80, 160)[4:24]
    assert fast[0] == 1 << 7
    assert bits(programs) == 4
    assert 1.0 < programs.axes(2)[0] < 19.0
    programs.write(F, 0x14, back)
    assert bits(programs) == 24
    programs.until(lambda: bits(programs) == 56)
    assert programs.axes(1, 2) == pytest.approx([0.0, 0.0])
    assert programs.get(0x310B, 0x0D, "<I") == 10
    assert programs.read(C, 0x80, 160)[4:24] == fast
    programs.write(F, 0x14, forward)
    assert bits(programs) == 8
    programs.until(lambda: programs.axes(1)[0] > 5.0)
    programs.write(0x320B, 0x04, struct.pack("<dd", 1e5, 1e7))
    programs.until(lambda: programs.get(0x310B, 0x502, "<d") == 0.0)
    programs.write(F, 0x15)
    programs.until(lambda: state(programs) is State.READY)
    assert programs.axes(1, 2) == pytest.approx([0.0, 20.0])
    assert bits(programs) == 0


def test_what_is_ahead_on_the_path(programs: Any) -> None:
    """State 0x532 of the group: what is left of this segment, then those behind it."""
    load(programs, "N10 H4\nN20 G01 X100 F6000\nN30 Y20 H-2\nN40 G04 X0.5\nN50 X70\nM30\n")
    assert programs.read(0x310B, 0x532, 300)[8:] == bytes(264)
    programs.write(F, 0x02)
    programs.until(lambda: programs.axes(1)[0] > 40.0)
    data = programs.read(0x310B, 0x532, 300)
    assert len(data) == 272
    lines = list(struct.iter_unpack("<dIIII", data[8:]))
    x = 100.0 - lines[0][0]
    assert 40.0 < x < 60.0
    assert lines[0][1:] == (20, 4, 1, 0)
    assert lines[1] == (20.0, 30, 0xFFFF_FFFE, 2, 0)
    assert lines[2] == (30.0, 50, 0xFFFF_FFFE, 4, 0)
    assert lines[3:] == [(0.0, 0, 0, 0, 0)] * 8
    later = programs.read(0x310B, 0x532, 300)
    programs.run(0.01)
    assert programs.read(0x310B, 0x532, 300)[:4] != later[:4]
