"""The firmware of a drive: programmed in its time, whole or not at all."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import FileRefusal
from achse.drive.firmware import LONGEST_FIRMWARE, Firmware


@given(st.binary(min_size=1, max_size=500), st.lists(st.integers(0, 3_000_000), max_size=20))
def test_programming_takes_its_time(content: bytes, steps: list[int]) -> None:
    firmware = Firmware(content=b"old")
    firmware.program(content)
    passed = 0
    for step in steps:
        firmware.advance(step)
        passed += step
        if passed >= len(content) * 10_000:
            assert (firmware.content, firmware.programming, firmware.write_count) == (
                content,
                None,
                1,
            )
        else:
            assert firmware.content == b"old"
            assert firmware.programming == (passed // 10_000, len(content))


def test_a_drive_that_is_switched_off_has_the_old_one() -> None:
    firmware = Firmware(content=b"old")
    firmware.program(b"new")
    firmware.abandon()
    firmware.advance(10**9)
    assert (firmware.content, firmware.write_count) == (b"old", 0)


def test_refusals() -> None:
    firmware = Firmware("a.bin", password=3)
    firmware.check("a.bin", 3)
    with pytest.raises(FileRefusal, match=r"0x8001 not found the file is a\.bin"):
        firmware.check("b.bin", 3)
    with pytest.raises(FileRefusal, match="0x800A no rights wrong password"):
        firmware.check("a.bin", 0)
    with pytest.raises(FileRefusal, match="0x800B program error the file is empty"):
        firmware.program(b"")
    with pytest.raises(FileRefusal, match="0x8003 disk full"):
        firmware.program(bytes(LONGEST_FIRMWARE + 1))
