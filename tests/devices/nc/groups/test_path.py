"""Parameters of 3D groups over ADS: each is kept, each out of its range has its error."""

from typing import Any

import pytest

P = 0x300B


@pytest.mark.parametrize(
    ("offset", "form", "good", "bad", "error"),
    [
        (0x500, "<i", (0, 1, 2), (3, -1), 0x42A9),
        (0x501, "<d", (0.0, 0.5, 1.0), (-0.1, 1.1), 0x42A1),
        (0x502, "<d", (0.0, 1.0), (-0.1, 1.1), 0x42A1),
        (0x507, "<d", (0.0, 1.0), (-0.1, 1.1), 0x42A1),
        (0x503, "<d", (0.0, 180.0), (-0.1, 180.1), 0x42A2),
        (0x504, "<d", (0.0, 180.0), (-0.1, 180.1), 0x42A2),
        (0x505, "<d", (0.0, 100.0), (-0.1,), 0x42AA),
        (0x508, "<H", (0, 1), (2,), 0x42E0),
        (0x508, "<I", (0, 1), (2,), 0x42E0),
        (0x509, "<H", (0, 1), (2,), 0x42E0),
        (0x50A, "<I", (0, 1, 2), (3,), 0x426C),
        (0x50B, "<H", (0, 1), (2,), 0x42E0),
        (0x514, "<I", (1, 20), (0, 21), 0x42E0),
    ],
)
def test_a_parameter_of_the_path(
    groups: Any,
    refused: Any,
    offset: int,
    form: str,
    good: tuple[float, ...],
    bad: tuple[float, ...],
    error: int,
) -> None:
    for value in good:
        groups.put(P, offset, form, value)
        assert groups.get(P, offset, form) == value
    for value in bad:
        with refused(error):
            groups.put(P, offset, form, value)
    assert groups.get(P, offset, form) == good[-1]
    for other in (0x3001, 0x300C, 0x300D):
        with refused(0x703):
            groups.get(other, offset, form)


def test_the_table_of_segments(groups: Any) -> None:
    assert groups.get(P, 0x50C, "<I") == groups.get(P, 0x0C, "<I") == 128


def test_the_divisor_of_the_cycle_is_that_of_a_path(groups: Any, refused: Any) -> None:
    for value in (32, 2, 1):
        groups.put(P, 0x10, "<I", value)
        assert groups.get(P, 0x10, "<I") == value
    for value in (0, 33, 0xFFFF_FFFF):
        with refused(0x4205):
            groups.put(P, 0x10, "<I", value)
    for other in (0x300C, 0x300D):  # a FIFO, a kinematic group
        groups.put(other, 0x10, "<I", 1)
        with refused(0x4205):
            groups.put(other, 0x10, "<I", 2)
        assert groups.get(other, 0x10, "<I") == 1
