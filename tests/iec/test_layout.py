"""Where members lie, by the rules of TwinCAT 3 and 2."""

from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.errors import DeclarationError
from achse.iec.layout import TC2_ARM, TC2_X86, TC3_X64, align, overlaid, pack_of, sequential


@dataclass(frozen=True)
class Thing:
    size: int
    alignment: int
    is_bit: bool = False


BOOL, INT, DINT, LREAL = Thing(1, 1), Thing(2, 2), Thing(4, 4), Thing(8, 8)
BIT = Thing(1, 1, is_bit=True)
TEXT = Thing(51, 1)


def offsets(*members: Thing, pack: int = 8) -> list[int]:
    return [spot.offset for spot in sequential(members, pack).spots]


@pytest.mark.parametrize(
    ("pack", "expected", "size"),
    [
        (TC3_X64.pack, [0, 8, 16, 20], 24),  # LREAL to 8, end to 8
        (TC2_ARM.pack, [0, 4, 12, 16], 20),
        (2, [0, 2, 10, 12], 16),
        (TC2_X86.pack, [0, 1, 9, 11], 15),
    ],
)
def test_the_packing_limits_the_alignment(pack: int, expected: list[int], size: int) -> None:
    layout = sequential([BOOL, LREAL, INT, DINT], pack)
    assert [spot.offset for spot in layout.spots] == expected
    assert layout.size == size


def test_a_recorded_structure() -> None:
    # STRING(50), REAL, DATE_AND_TIME: 0, 52, 56, 60 bytes in all
    layout = sequential([TEXT, DINT, DINT], 8)
    assert [spot.offset for spot in layout.spots] == [0, 52, 56]
    assert layout.size == 60


def test_a_recorded_function_block() -> None:
    # TON: table pointer, then BOOL, TIME, BOOL, TIME, BOOL, TIME
    layout = sequential([BOOL, DINT, BOOL, DINT, BOOL, DINT], 8, start=8, alignment=8)
    assert [spot.offset for spot in layout.spots] == [8, 12, 16, 20, 24, 28]
    assert layout.size == 32


def test_bits_share_bytes_until_another_member_comes() -> None:
    layout = sequential([BOOL, *[BIT] * 9, INT, BIT], 8)
    spots = [(spot.offset, spot.bit) for spot in layout.spots]
    assert spots == [(0, None), *[(1, n) for n in range(8)], (2, 0), (4, None), (6, 0)]
    assert layout.size == 8


def test_union_members_start_together() -> None:
    layout = overlaid([BOOL, LREAL, TEXT], 8)
    assert {spot.offset for spot in layout.spots} == {0}
    assert (layout.size, layout.alignment) == (56, 8)


def test_pack_modes() -> None:
    assert [pack_of(mode) for mode in ("0", "1", "2", "3", "4", "6", " 8 ")] == [
        1,
        1,
        2,
        2,
        4,
        4,
        8,
    ]
    with pytest.raises(DeclarationError, match="pack_mode is 0 … 8, got '16'"):
        pack_of("16")


THINGS = st.sampled_from([BOOL, INT, DINT, LREAL, TEXT, BIT])


@given(st.lists(THINGS, max_size=20), st.sampled_from([1, 2, 4, 8]))
def test_members_lie_aligned_in_order_and_apart(members: list[Thing], pack: int) -> None:
    layout = sequential(members, pack)
    taken: set[tuple[int, int]] = set()
    for member, spot in zip(members, layout.spots, strict=True):
        if member.is_bit:
            assert spot.bit is not None
            mine = {(spot.offset, spot.bit)}
        else:
            assert spot.offset % min(member.alignment, pack) == 0
            area = range(spot.offset, spot.offset + member.size)
            mine = {(byte, bit) for byte in area for bit in range(8)}
        assert not taken & mine
        taken |= mine
    assert layout.size == align(max((byte for byte, _ in taken), default=-1) + 1, layout.alignment)
