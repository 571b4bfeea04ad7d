"""Groups that mean the same on every device."""

from achse.codes import PlcGroup, ReservedGroup
from achse.codes.groups import NAMED, SUMS


def test_groups_are_in_the_ranges_of_the_manuals() -> None:
    assert all(0xF000 <= group <= 0xF1FF for group in ReservedGroup)
    assert all(0x4020 <= group <= 0x405F for group in PlcGroup)


def test_groups_that_clients_meet() -> None:
    assert (ReservedGroup.SYMBOL_HANDLE_BY_NAME, ReservedGroup.DEVICE) == (0xF003, 0xF100)
    assert list(SUMS) == [group for group in ReservedGroup if group.name.startswith("SUM_")]
    assert sorted(NAMED) == [group for group in ReservedGroup if group.name.endswith("BY_NAME")]
