"""Type classes, and the records that ANY inputs get."""

from enum import IntEnum
from typing import Any

import pytest

from achse.iec.arrays import ArrayType, Bounds
from achse.iec.derived import AliasType, InterfaceType, PointerType, ReferenceType, SubrangeType
from achse.iec.elementary import BOOL, INT, LREAL
from achse.iec.enums import EnumType
from achse.iec.strings import STRING, WSTRING
from achse.iec.structs import StructType
from achse.iec.times import DT, LTIME, TIME
from achse.iec.types import IecType
from achse.st.check.anytype import type_class

COLOUR: Any = IntEnum("COLOUR", {"Red": 0})
RECORD: StructType[Any] = StructType("ST", [])


@pytest.mark.parametrize(
    ("type", "number"),
    [
        (BOOL, 0), (INT, 7), (LREAL, 15), (STRING(), 16), (WSTRING(), 17), (TIME, 18), (DT, 20),
        (PointerType(INT), 22), (ReferenceType(INT), 23), (SubrangeType(INT, 0, 1), 24),
        (EnumType(COLOUR), 25), (ArrayType(INT, [Bounds(0, 1)]), 26), (RECORD, 28), (LTIME, 37),
        (InterfaceType("I_A"), 28), (AliasType("T", INT), 7),
    ],
)  # fmt: skip
def test_type_classes(type: IecType[Any], number: int) -> None:
    assert type_class(type) == number
