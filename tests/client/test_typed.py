"""Typed symbols: dataclasses, enumerations and lists from values of a target, and back."""
# ruff: noqa: N801, N815 (IEC names)

from dataclasses import dataclass
from enum import IntEnum

import pytest

from achse.client.typed import built, flattened, iec_name
from achse.iec import ARRAY, INT, UINT, Enumeration, Struct, iec_type, plain, var


class E_Mode(Enumeration, base=UINT):
    OFF = 0
    ON = 3


class ST_Inner(Struct):
    eMode = var(E_Mode)
    from_ = var(INT, name="from")


class ST_Outer(Struct):
    aInner = var(ARRAY(ST_Inner, (1, 2)))
    aGrid = var(ARRAY(INT, (0, 1), (0, 1)))


class Mode(IntEnum):
    OFF = 0
    ON = 3


@dataclass(kw_only=True)
class Inner:
    eMode: Mode | int
    from_: int = iec_name("from")


@dataclass(kw_only=True)
class Outer:
    aInner: list[Inner]
    aGrid: list[list[int]]


VALUE = {"aInner": [{"eMode": 3, "from": 1}, {"eMode": 9, "from": 2}], "aGrid": [[1, 2], [3, 4]]}


def test_a_record_becomes_dataclasses_and_comes_back() -> None:
    type = iec_type(ST_Outer)
    record = type.decode(type.encode(VALUE))
    outer = built(Outer, record)
    assert outer == Outer(
        aInner=[Inner(eMode=Mode.ON, from_=1), Inner(eMode=9, from_=2)], aGrid=[[1, 2], [3, 4]]
    )
    assert isinstance(outer.aInner[0].eMode, Mode)
    assert plain(type.decode(type.encode(flattened(outer)))) == VALUE


@pytest.mark.parametrize(
    ("kind", "value", "expected"),
    [(int, 3, 3), (list[list[int]], [[1], [2]], [[1], [2]]), (Mode, 3, Mode.ON), (Mode, 4, 4)],
)
def test_plain_values(kind: object, value: object, expected: object) -> None:
    assert built(kind, value) == expected
    assert flattened(expected) == value
