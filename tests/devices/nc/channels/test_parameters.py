"""Parameters of a channel with an interpreter: kept, in their ranges, where they are meant."""

import struct
from typing import Any

import pytest

P = 0x2001


@pytest.mark.parametrize(
    ("offset", "form", "good", "bad"),
    [
        (0x07, "<I", (0, 2), (3,)),
        (0x08, "<I", (0, 2), (3,)),
        (0x0A, "<I", (0, 1), (2,)),
        (0x0B, "<I", (0, 1), (2,)),
        (0x12, "<d", (25.4, 10.0), (0.0, -1.0)),
        (0x13, "<d", (1.0, 2.0), (0.0,)),
        (0x15, "<H", (0, 1), (2,)),
        (0x15, "<I", (0, 1), (2,)),
        (0x50, "<I", (0, 1, 2), (3,)),
        (0x51, "<I", (1, 24), (0, 25)),
        (0x53, "<I", (0, 1), (2,)),
        (0x54, "<I", (0, 1), (2,)),
    ],
)
def test_a_parameter(
    programs: Any, refused: Any, offset: int, form: str, good: Any, bad: Any
) -> None:
    for value in good:
        programs.put(P, offset, form, value)
        assert programs.get(P, offset, form) == value
    for value in bad:
        with refused(0x4108):
            programs.put(P, offset, form, value)
    for channel in (0x2002, 0x2003, 0x2004):
        with refused(0x703):
            programs.get(channel, offset, form)


def test_rules_of_m_functions(programs: Any, refused: Any) -> None:
    """41 bytes each: mask, ten cleared M functions, -1 for none."""
    data = programs.exchange(P, 0x10, 1000, struct.pack("<II", 7, 3))
    seven, eight, nine = (struct.unpack_from("<B10i", data, 41 * n) for n in range(3))
    assert (seven[0], eight[0], nine[0]) == (4, 0, 0)
    assert nine[1:4] == (7, 8, -1)
    assert programs.exchange(P, 0x10, 41, struct.pack("<II", 40, 1))[0] == 1
    for first, count in ((0, 0), (160, 1), (159, 2), (0, 161)):
        with refused(0x4104):
            programs.exchange(P, 0x10, 41, struct.pack("<II", first, count))


def test_places_of_tools_and_shifts(programs: Any, refused: Any) -> None:
    programs.put(P, 0x2_3200, "<H", 9)
    programs.put(P, 0x3_3200, "<H", 20)
    programs.put(P, 0x4_3201, "<d", 10.0)
    assert programs.get(P, 0x3_3200, "<H") == 10
    assert programs.get(P, 0x2_3200, "<H") == 9
    for offset in (0x2_3300, 0x2_0101, 0x4_010F, 0x4_0100, 0x1_0100, 0x1_010B, 0x1_0401):
        with refused(0x703):
            programs.get(P, offset, "<d")
    programs.put(P, 0x1_030A, "<d", 7.0)
    assert programs.get(P, 0x1_030A, "<d") == 7.0
    with refused(0x706):
        programs.put(P, 0x1_030A, "<d", float("nan"))


def test_the_tolerance_ball_of_each_group(programs: Any, refused: Any) -> None:
    programs.put(P, 0x5_0009, "<d", 0.5)
    assert programs.get(P, 0x5_0009, "<d") == 0.5
    with refused(0x42A3):
        programs.put(P, 0x5_0001, "<d", -0.5)
    with refused(0x703):
        programs.put(P, 0x5_000A, "<d", 0.5)


def test_group_states_in_the_cyclic_structure(programs: Any, refused: Any) -> None:
    """0x55, 0x56: SafEntries as IntParams[0], the override as DoubleParams[3]."""
    programs.put(P, 0x55, "<4I", 0x0F, 0, 0, 0)
    programs.put(P, 0x56, "<4I", 0, 0, 0, 0x50A)
    assert programs.get(P, 0x55, "<4I") == (0x0F, 0, 0, 0)
    whole = programs.read(0x2301, 0x80, 160)
    assert struct.unpack_from("<4I", whole, 40) == (128, 0, 0, 0)
    assert struct.unpack_from("<4d", whole, 56)[3] == 100.0
    with refused(0x705):
        programs.put(P, 0x55, "<3I", 1, 2, 3)
