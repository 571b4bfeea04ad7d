"""States of a channel: modal words, shifts, rotation, while they are asked for."""

from typing import Any

from achse.motion.channels.states import InterpreterState as State

S = 0x2101


def test_what_is_valid_now(programs: Any, refused: Any) -> None:
    for offset in (0x13, 0x14, 0x15):
        with refused(0x4162):
            programs.read(S, offset, 100)
    programs.put(0x2001, 0x53, "<I", 1)
    words = programs.get(S, 0x13, "<18I")
    assert words[:7] == (1, 17, 40, 53, 0, 71, 90)
    programs.put(0x2001, 0x1_0101, "<d", 1.5)
    (programs.folder / "a.nc").write_text(
        "N1 G54\nN2 G58 X2\nN3 ROT Z30\nN4 G18 G91 G60\nN5 G04 X1\nM30\n"
    )
    programs.write(0x2201, 0x04, b"a.nc")
    programs.write(0x2201, 0x02)
    programs.until(lambda: programs.get(S, 0x03, "<I") == State.END)
    words = programs.get(S, 0x13, "<18I")
    assert (words[1], words[3], words[4], words[6]) == (18, 54, 60, 91)
    shifts = programs.get(S, 0x14, "<II9d")
    assert (shifts[0], shifts[2], shifts[5]) == (6, 1.5, 2.0)
    assert programs.get(S, 0x15, "<II3d")[2:] == (0.0, 0.0, 30.0)


def test_names_and_numbers_of_programs(programs: Any) -> None:
    assert programs.read(S, 0x07, 101) == b"\0"
    (programs.folder / "12.nc").write_text("M30\n")
    programs.put(0x2201, 0x01, "<I", 12)
    assert programs.get(S, 0x05, "<I") == programs.get(0x2001, 0x06, "<I") == 12
    assert programs.get(S, 0x08, "<I") == programs.get(S, 0x04, "<I") == 0
