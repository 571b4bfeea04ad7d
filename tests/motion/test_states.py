"""The numbers of the axis interface."""

import pytest

from achse.motion import ControlBit, OperationModeBit, StartType, StateBit
from achse.motion.states import OverrideType, choices_of


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


def test_enumerations_by_the_unit_of_a_field() -> None:
    assert choices_of("OverrideType") is OverrideType
    for unit in ("mm/s", "0/1", "", "__all__"):
        assert choices_of(unit) is None
