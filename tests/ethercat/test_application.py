"""The interface between a slave controller and what sits behind it."""

from achse.codes import DataType
from achse.ethercat import Application, Loopback, ObjectAccess, ObjectCode


def test_an_application_is_one_by_its_form() -> None:
    """Type checkers hold this line to the protocol."""
    application: Application = Loopback()
    assert application.input_size == len(application.read_inputs())


def test_access_words() -> None:
    assert ObjectAccess.READ == 0x0007
    assert ObjectAccess.READ | ObjectAccess.WRITE == 0x003F
    assert ObjectAccess.READ | ObjectAccess.WRITE_PREOP == 0x000F


def test_numbers_of_kinds_and_types() -> None:
    assert [int(code) for code in ObjectCode] == [2, 7, 8, 9]
    assert (DataType.I32, DataType.U32, DataType.VISIBLE_STRING) == (4, 7, 9)
    assert (DataType.I64, DataType.U64) == (0x15, 0x1B)
