"""Types of values in registers."""

import pytest

from achse.iec.elementary import BOOL, BYTE, DINT, INT, LREAL, LWORD, REAL, SINT, ULINT
from achse.iec.strings import StringType
from achse.iec.times import DATE, LTIME, TIME
from achse.iec.types import IecType
from achse.native import backend
from achse.plc.machine.values import is_packed, machine_type


@pytest.mark.parametrize(
    ("type", "expected"),
    [
        (BOOL, backend.BOOL),
        (BYTE, backend.U8),
        (SINT, backend.I8),
        (INT, backend.I16),
        (DINT, backend.I32),
        (LWORD, backend.U64),
        (ULINT, backend.U64),
        (REAL, backend.F32),
        (LREAL, backend.F64),
        (TIME, backend.U32),
        (DATE, backend.U32),
        (LTIME, backend.U64),
    ],
)
def test_each_type_has_its_width_and_sign(type: IecType[object], expected: object) -> None:
    assert machine_type(type) is expected


def test_a_text_is_not_packed() -> None:
    assert not is_packed(StringType(5))
