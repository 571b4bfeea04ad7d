"""Groups and masters over ADS."""

import struct
from typing import Any

import pytest

F = 0x4201


@pytest.mark.parametrize("form", ["<II5dI3d", "<II5dI4x3d"], ids=["76 bytes", "80 bytes"])
def test_uncoupling_an_axis_that_is_not_coupled(bench: Any, refused: Any, form: str) -> None:
    with refused(0x424D):
        bench.exchange(F, 0x17, 4, struct.pack(form, 1, 0, 10.0, 100.0, *[0.0] * 3, 0, *[0.0] * 3))
    assert bench.axis.set_motion_phase == 0


def test_return_to_the_ptp_group(bench: Any) -> None:
    bench.write(F, 0x70)
    assert bench.get(0x4301, 0x81, "<I") >> 25 & 1


@pytest.mark.parametrize("offset", [0x2E, 0x2F])
def test_reserved_functions_are_none(bench: Any, refused: Any, offset: int) -> None:
    with refused(0x703):
        bench.write(F, offset)
