"""The numbers of axes and their parts."""

from achse.codes.axis import StateBit
from achse.codes.nc.choices import OverrideType
from achse.motion.states import choices_of


def test_enumerations_by_the_unit_of_a_field() -> None:
    assert choices_of("OverrideType") is OverrideType
    assert choices_of("StateBit") is StateBit
    for unit in ("mm/s", "0/1", "", "IntEnum", "choices"):
        assert choices_of(unit) is None
