"""Enumerations."""

from enum import IntEnum
from typing import Any

import pytest

from achse.iec.elementary import BYTE, INT, UDINT
from achse.iec.enums import Enumeration, EnumType
from achse.iec.errors import DeclarationError, IecDecodeError, IecValueError


class Empty(IntEnum):
    pass


class Big(IntEnum):
    Large = 256


class State(Enumeration, base=UDINT, name="E_State", comment="of a drive"):
    Idle = 1
    Run = 5
    Running = 5
    Error = 0xFFFF_FFFF


STATE = State.__iec__


def test_a_class_is_a_type() -> None:
    assert (STATE.name, STATE.size, STATE.adst, STATE.base) == ("E_State", 4, 19, UDINT)
    assert STATE.comment == "of a drive"
    assert STATE.numbers == {"Idle": 1, "Run": 5, "Running": 5, "Error": 0xFFFF_FFFF}


def test_members_come_back_as_members() -> None:
    for member in State:
        assert STATE.decode(STATE.encode(member)) is member
    memory = bytearray(4)
    STATE.write(memory, 0, State.Run)
    assert STATE.read(memory, 0) is State.Run


def test_numbers_that_are_no_member_stay_numbers() -> None:
    assert STATE.decode(STATE.encode(7)) == 7
    assert STATE.member(7) == 7
    assert STATE.member(1) is State.Idle


def test_names_are_taken_without_case() -> None:
    assert STATE.encode("run") == STATE.encode("E_State.Running") == STATE.encode(5)


@pytest.mark.parametrize("value", [-1, 2**32, 1.0, "stop", None])
def test_what_does_not_fit_is_refused(value: object) -> None:
    with pytest.raises(IecValueError, match="E_State takes one of Idle, Run, Running, Error, or"):
        STATE.encode(value)
    with pytest.raises(IecDecodeError):
        STATE.decode(b"\0")


def test_the_default_is_the_first_member_or_as_declared() -> None:
    class Plain(Enumeration):
        A = 3
        B = 4

    class Declared(Enumeration, initial=4):
        A = 3
        B = 4

    assert Plain.__iec__.base is INT
    assert Plain.__iec__.default == b"\3\0"
    assert Declared.__iec__.default == b"\4\0"
    assert EnumType(Empty).default == b"\0\0"


def test_members_must_fit_the_base() -> None:
    with pytest.raises(DeclarationError, match=r"E_Big.Large = 256 is not a BYTE"):
        EnumType(Big, BYTE, name="E_Big")


def test_long_enumerations_are_named_in_part() -> None:
    members = IntEnum("E_Many", {f"M{n}": n for n in range(50)})  # type: ignore[misc]
    many: EnumType[Any] = EnumType(members)
    with pytest.raises(IecValueError, match="M7, …, or an integer") as caught:
        many.encode("x")
    assert len(str(caught.value)) < 200
