"""Function rows: what they take, and that they are written only."""

from typing import Any

import pytest

F = 0x4201


TC2, TC3 = "TwinCAT 2", "TwinCAT 3"


@pytest.mark.parametrize("data", [b"", b"\0", bytes(8)], ids=["none", "a byte", "more"])
@pytest.mark.parametrize("offset", [0x01, 0x02, 0x18, 0x50, 0x51, 0x60, 0x61])
def test_functions_without_data_pass_over_what_comes(bench: Any, offset: int, data: bytes) -> None:
    bench.write(F, offset, data)


@pytest.mark.parametrize("size", [1, 19, 21, 23, 25, 80])
def test_a_wrong_length_is_refused(bench: Any, refused: Any, size: int) -> None:
    with refused(0x705):
        bench.write(F, 0x20, bytes(size))
    with refused(0x705):
        bench.exchange(F, 0x16, 4, bytes(size + 1 if size == 80 else size))


def test_functions_are_not_read(bench: Any, refused: Any) -> None:
    for offset in (0x01, 0x16, 0x20):
        with refused(0x704):
            bench.read(F, offset, 4)
    with refused(0x704):
        bench.write(F, 0x16, bench.universal(1, 1.0, 1.0))
    with refused(0x703):
        bench.write(F, 0x7F)
