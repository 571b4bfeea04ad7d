"""What all types have in common."""

from achse.iec.elementary import INT
from achse.iec.errors import IecValueError
from achse.iec.types import Adst, IecType, derived_guid


def test_derived_guids_are_stable_and_distinct() -> None:
    assert derived_guid("ST_A 8").hex() == "f01522690b44171a62df203852375c4e"
    assert derived_guid("ST_A 8") != derived_guid("ST_A 16")
    assert len(derived_guid("")) == 16


def test_rejecting_names_type_expectation_and_value() -> None:
    error = INT.reject(1.5)
    assert isinstance(error, IecValueError)
    assert str(error) == "INT takes an integer in -32768..32767, got 1.5"


def test_a_type_shows_its_name() -> None:
    assert repr(IecType("T_Any", 4, 4, Adst.BIGTYPE)) == "<IecType T_Any>"
    assert IecType("T_Any", 4, 4, Adst.BIGTYPE).default == bytes(4)
