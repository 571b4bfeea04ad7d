"""The numbers of the axis interface."""

import pytest

from achse.codes.axis import ControlBit, JogType, OperationModeBit, StartType, StateBit


@pytest.mark.parametrize("bits", [StateBit, ControlBit, OperationModeBit])
def test_masks_are_single_bits_of_a_double_word(bits: type[StateBit]) -> None:
    for bit in bits:
        assert bit.bit_count() == 1
        assert bit < 1 << 32


def test_the_status_double_word_names_every_bit() -> None:
    assert sum(StateBit) == 0xFFFF_FFFF


def test_directed_modulo_starts_carry_their_direction_in_the_high_byte() -> None:
    directed = [StartType.MODULO_SHORTEST, StartType.MODULO_POSITIVE, StartType.MODULO_NEGATIVE]
    assert [(kind & 0xFF, kind >> 8) for kind in directed] == [(5, 1), (5, 2), (5, 3)]


def test_jogs_distinguish_endless_ones_from_steps_and_leave_the_direction_open() -> None:
    endless = {JogType.SLOW, JogType.FAST, JogType.RAPID}
    assert {kind for kind in JogType if kind & 0xF0 == 0x10} == endless
    assert not any(kind & 1 for kind in JogType)
