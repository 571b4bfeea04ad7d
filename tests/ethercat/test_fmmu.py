"""FMMUs as bit ranges."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ethercat.fmmu import Fmmu, Transfer

fmmus = st.builds(
    Fmmu,
    logical=st.integers(0, 300),
    length=st.integers(1, 40),
    start_bit=st.integers(0, 7),
    stop_bit=st.integers(0, 7),
    physical=st.integers(0x1000, 0x1100),
    physical_bit=st.integers(0, 7),
    direction=st.integers(0, 3),
    active=st.integers(0, 1),
)


def test_the_registers() -> None:
    registers = bytes.fromhex("00000100 0400 00 07 0011 00 02 01 000000")
    fmmu = Fmmu.decode(registers)
    assert fmmu == Fmmu(0x10000, 4, 0, 7, 0x1100, 0, 2, 1)
    assert fmmu.writes
    assert not fmmu.reads
    assert fmmu.encode() == registers


def test_whole_bytes() -> None:
    fmmu = Fmmu(0x100, 4, 0, 7, 0x1100, 0, 1, 1)
    assert fmmu.transfer(0x100, 4) == Transfer(0, 0x1100 * 8, 32)
    assert fmmu.transfer(0xFE, 4) == Transfer(16, 0x1100 * 8, 16)
    assert fmmu.transfer(0x102, 4) == Transfer(0, 0x1102 * 8, 16)
    assert fmmu.transfer(0x104, 4) is None
    assert fmmu.transfer(0x90, 0x70) is None


def test_single_bits() -> None:
    fmmu = Fmmu(0x100, 1, 3, 4, 0x1100, 6, 1, 1)
    assert fmmu.transfer(0x100, 1) == Transfer(3, 0x1100 * 8 + 6, 2)
    assert not Transfer(3, 0x1100 * 8 + 6, 2).in_bytes


def test_an_inactive_or_empty_fmmu_maps_nothing() -> None:
    assert not Fmmu(0, 4, 0, 7, 0x1000, 0, 3, 0).reads
    assert not Fmmu(0, 4, 0, 7, 0x1000, 0, 3, 0).writes
    assert Fmmu(0, 0, 0, 7, 0x1000, 0, 3, 1).transfer(0, 100) is None


@pytest.mark.parametrize("active", [0, 1, 2, 3])
@pytest.mark.parametrize("direction", range(8))
def test_direction_and_activity_are_single_bits(direction: int, active: int) -> None:
    fmmu = Fmmu(0, 4, 0, 7, 0x1000, 0, direction, active)
    is_active = active in (1, 3)
    assert fmmu.reads is (is_active and direction in (1, 3, 5, 7))
    assert fmmu.writes is (is_active and direction in (2, 3, 6, 7))


def test_bits_are_3_bits_wide() -> None:
    fmmu = Fmmu.decode(bytes.fromhex("00000100 0400 0b 0f 0011 0a ff ff 000000"))
    assert fmmu == Fmmu(0x10000, 4, 3, 7, 0x1100, 2, 0xFF, 0xFF)


@pytest.mark.parametrize("part", range(3))
@pytest.mark.parametrize("value", [1, 4, 7, 8, 9])
def test_transfer_of_whole_bytes_needs_no_shift(part: int, value: int) -> None:
    numbers = [8, 16, 24]
    numbers[part] = value
    assert Transfer(*numbers).in_bytes is (value == 8)


@given(fmmus, st.integers(0, 340), st.integers(0, 60))
def test_a_transfer_is_the_bits_that_both_have(fmmu: Fmmu, address: int, length: int) -> None:
    first = fmmu.logical * 8 + fmmu.start_bit
    last = (fmmu.logical + fmmu.length - 1) * 8 + fmmu.stop_bit
    memory = {
        bit: fmmu.physical * 8 + fmmu.physical_bit + bit - first for bit in range(first, last + 1)
    }
    both = [bit for bit in range(address * 8, (address + length) * 8) if bit in memory]
    transfer = fmmu.transfer(address, length)
    if not both:
        assert transfer is None
    else:
        assert transfer == Transfer(both[0] - address * 8, memory[both[0]], len(both))
