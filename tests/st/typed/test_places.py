"""Storages: flat types, and places that compare without where they were written."""

from enum import IntEnum
from typing import Any

import pytest

from achse.iec.derived import AliasType, PointerType, SubrangeType
from achse.iec.elementary import BOOL, DINT, INT, UINT
from achse.iec.enums import EnumType
from achse.iec.types import IecType
from achse.st.typed.places import FrameBase, Storage, flat

STATES: Any = IntEnum("STATES", {"Idle": 0, "Run": 1})
STATE: EnumType[Any] = EnumType(STATES, UINT)
POINTER = PointerType(INT)


@pytest.mark.parametrize(
    ("type", "expected"),
    [
        (BOOL, BOOL),
        (AliasType("T_Count", DINT), DINT),
        (AliasType("T_Twice", AliasType("T_Count", DINT)), DINT),
        (SubrangeType(INT, 0, 9), INT),
        (STATE, UINT),
        (AliasType("T_State", STATE), UINT),
        (POINTER, POINTER),
    ],
)
def test_types_are_flat(type: IecType[object], expected: IecType[object]) -> None:
    assert flat(type) is expected


def test_where_something_was_written_does_not_count() -> None:
    assert Storage(FrameBase(), 4, INT, at=3) == Storage(FrameBase(), 4, INT, at=9)
    assert Storage(FrameBase(), 4, INT) != Storage(FrameBase(), 6, INT)
