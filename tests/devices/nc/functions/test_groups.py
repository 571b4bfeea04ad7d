"""Groups over ADS."""

from typing import Any

import pytest

F = 0x4201


def test_return_to_the_ptp_group(bench: Any) -> None:
    bench.write(F, 0x70)
    assert bench.get(0x4301, 0x81, "<I") >> 25 & 1


@pytest.mark.parametrize("offset", [0x2E, 0x2F])
def test_reserved_functions_are_none(bench: Any, refused: Any, offset: int) -> None:
    with refused(0x703):
        bench.write(F, offset)
