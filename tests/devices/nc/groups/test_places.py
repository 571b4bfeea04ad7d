"""Which axes belong to a group, over ADS."""

import struct
from typing import Any

import pytest

PTP_MODE = 1 << 25
FUNCTION_NOT_ALLOWED = 0x4257


def ids(bench: Any, group: int) -> tuple[int, ...]:
    data = bench.read(0x3100 + group, 0x552, 64)
    return struct.unpack(f"<{len(data) // 4}I", data)


def test_axes_go_into_a_group_and_back(groups: Any, refused: Any) -> None:
    assert groups.get(0x4001, 0x54, "<I") == 1
    groups.put(0x320B, 0x50, "<3I", 1, 2, 0)
    groups.run(0.02)
    assert ids(groups, 11) == (1, 2, 0, 0, 0, 0, 0, 0)
    assert groups.read(0x310B, 0x550, 12) == struct.pack("<3I", 1, 2, 0)
    owner = [groups.get(0x4001, offset, "<I") for offset in (0x51, 0x53, 0x54, 0x56)]
    assert owner == [1, 2, 11, 4]
    assert groups.get(0x310B, 0x02, "<I") == 2
    assert not groups.nc.axis(1).state_dword & PTP_MODE
    with refused(FUNCTION_NOT_ALLOWED):
        groups.start(10.0, 50.0)
    groups.put(0x320B, 0x51, "<2I", 3, 7)
    assert ids(groups, 11) == (1, 2, 0, 0, 0, 0, 0, 3)
    groups.write(0x4202, 0x70)
    assert ids(groups, 11) == (1, 0, 0, 0, 0, 0, 0, 3)
    groups.write(0x320B, 0x53)
    groups.run(0.02)
    assert ids(groups, 11) == (0,) * 8
    assert groups.get(0x4001, 0x54, "<I") == 1
    assert groups.nc.axis(1).state_dword & PTP_MODE
    groups.start(10.0, 50.0)


@pytest.mark.parametrize(
    ("request_", "error"),
    [
        ((0x50, 9, 0, 0), 0x4012),
        ((0x50, 1, 1, 0), 0x421C),
        ((0x50, 3, 0, 0), 0x421C),
        ((0x51, 1, 8), 0x4202),
        ((0x51, 0, 1), 0x4012),
        ((0x51, 1, 5), 0x42F0),
        ((0x52, 1, 2, 0), 0x4202),
        ((0x50, 2, 0, 0), 0x4220),
        ((0x50, 4, 0, 0), 0x4267),
    ],
)
def test_what_cannot_be_assigned(
    groups: Any, refused: Any, request_: tuple[int, ...], error: int
) -> None:
    """Unknown, twice, in another group, at no place, Q without X, moving, a slave: nothing is."""
    groups.put(0x320C, 0x52, "<2I", 3, 0)
    groups.start(100.0, 10.0, axis=2)
    groups.put(0x4204, 0x40, "<4I4d", 1, 1, 0, 0, 1.0, 0.0, 0.0, 0.0)
    groups.run(0.1)
    offset, *numbers = request_
    with refused(error):
        groups.put(0x320B, offset, f"<{len(numbers)}I", *numbers)
    assert ids(groups, 11) == (0,) * 8
    assert ids(groups, 12) == (3, 0)


def test_a_group_of_another_kind_answers_0x703(groups: Any, refused: Any) -> None:
    for group, offset in ((0x3101, 0x552), (0x310C, 0x550), (0x300B, 0x701), (0x310B, 0x553)):
        with refused(0x703):
            groups.read(group, offset, 8)
    for group, offset in ((0x3201, 0x53), (0x320D, 0x51), (0x320B, 0x701), (0x320C, 0x54)):
        with refused(0x703):
            groups.write(group, offset, bytes(72 if offset == 0x54 else 8 * (offset == 0x51)))


def test_a_ptp_group_takes_its_own_axis_back(groups: Any, refused: Any) -> None:
    groups.put(0x320B, 0x50, "<3I", 1, 2, 0)
    with refused(0x421C):
        groups.put(0x3201, 0x50, "<3I", 2, 0, 0)
    groups.put(0x3201, 0x51, "<2I", 1, 0)
    assert ids(groups, 11) == (0, 2, 0, 0, 0, 0, 0, 0)
    with refused(0x4202):
        groups.put(0x3202, 0x51, "<2I", 2, 1)
