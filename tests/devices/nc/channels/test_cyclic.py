"""Cyclic structures of a channel, in both lengths and both directions."""

import struct
from typing import Any

C = 0x2301


def test_the_structure_to_the_plc(programs: Any) -> None:
    """Offsets of the public pages: 160 bytes, and 150 packed ones of TwinCAT 2."""
    (programs.folder / "3.nc").write_text("N70 G01 X50 F6000 M7 S900 T5 H-2\nM30\n")
    programs.put(0x2201, 0x01, "<I", 3)
    programs.write(0x2201, 0x02)
    programs.run(0.3)
    whole = programs.read(C, 0x80, 160)
    assert len(whole) == 160
    assert struct.unpack_from("<I5I", whole, 0) == (70, 1 << 7, 0, 0, 0, 0)
    assert struct.unpack_from("<iHH", whole, 28) == (-2, 900, 5)
    assert struct.unpack_from("<d", whole, 88)[0] > 1.0
    assert struct.unpack_from("<IHHIHH", whole, 96) == (3, 0, 9, 0, 1, 11)
    assert struct.unpack_from("<8B", whole, 120) == (1, 2, 3, 0, 0, 0, 0, 0)
    short = programs.read(C, 0x80, 150)
    assert len(short) == 150
    assert short[:36] == whole[:36]
    assert struct.unpack_from("<IHHH", short, 132) == (3, 0, 9, 0)


def test_the_structure_from_the_plc(programs: Any, refused: Any) -> None:
    assert struct.unpack_from("<HHHHII", programs.read(C, 0x00, 128)) == (
        *(0, 0, 0, 0, 1_000_000, 1_000_000),
    )
    programs.write(C, 0x00, struct.pack("<HHHHII112x", 5, 1, 1, 0, 0, 0))
    assert struct.unpack_from("<HHHHII", programs.read(C, 0x00, 150)) == (
        *(5, 0, 1, 0, 1_000_000, 1_000_000),
    )
    with refused(0x705):
        programs.write(C, 0x00, bytes(127))
    programs.put(C, 0x02, "<I", 500_000)
    programs.put(C, 0x03, "<I", 250_000)
    assert struct.unpack_from("<II", programs.read(C, 0x00, 128), 8) == (500_000, 250_000)
    with refused(0x42CE):
        programs.put(C, 0x02, "<I", 1_000_001)


def test_r_parameters(programs: Any, refused: Any) -> None:
    for number in (0, 899, 900, 999):
        programs.put(C, 0x1000_0000 + number, "<d", number + 0.5)
        assert programs.get(C, 0x1000_0000 + number, "<d") == number + 0.5
    with refused(0x703):
        programs.get(C, 0x1000_0000 + 1000, "<d")


def test_r_parameters_in_a_row(programs: Any, refused: Any) -> None:
    """As many as the length says; a write is taken whole or not at all."""
    programs.write(C, 0x1000_0000 + 898, struct.pack("<4d", 1.5, 2.5, 3.5, 4.5))
    assert struct.unpack("<4d", programs.read(C, 0x1000_0000 + 898, 32)) == (1.5, 2.5, 3.5, 4.5)
    assert len(programs.read(C, 0x1000_0000, 8000)) == 8000
    assert programs.read(C, 0x1000_0000 + 998, 32) == bytes(16)
    with refused(0x703):
        programs.write(C, 0x1000_0000 + 999, struct.pack("<2d", 7.0, 8.0))
    assert programs.get(C, 0x1000_0000 + 999, "<d") == 0.0
    with refused(0x705):
        programs.write(C, 0x1000_0000, bytes(12))
    with refused(0x706):
        programs.write(C, 0x1000_0000, struct.pack("<2d", 1.0, float("nan")))


def test_program_displays(programs: Any) -> None:
    (programs.folder / "a.nc").write_text("N1 G01 X5 F600\nN2 X6\nM30\n")
    programs.write(0x2201, 0x04, b"a.nc")
    assert programs.read(C, 0x01, 100) == b"N1 G01 X5 F600\0"
    programs.write(0x2201, 0x02)
    programs.run(0.1)
    assert programs.read(C, 0x2000_0001, 100) == b"N1 G01 X5 F600\0"
    assert programs.read(C, 0x01, 100) == b"M30\0"
    assert programs.read(C, 0x2000_0002, 100) == b"\0"
