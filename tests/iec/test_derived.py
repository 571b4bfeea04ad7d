"""Aliases, sub-ranges, pointers."""

import pytest

from achse.iec.derived import (
    AliasType,
    InterfaceType,
    PointerType,
    ReferenceType,
    SubrangeType,
    resolved,
)
from achse.iec.elementary import BIT, INT, LREAL, USINT
from achse.iec.errors import DeclarationError, IecDecodeError, IecValueError


def test_an_alias_has_the_values_of_its_base() -> None:
    alias = AliasType("T_Length", LREAL)
    memory = bytearray(8)
    alias.write(memory, 0, 2.5)
    assert alias.read(memory, 0) == alias.decode(memory) == 2.5
    assert alias.encode(2.5) == memory
    assert (alias.size, alias.adst, alias.default) == (8, 5, bytes(8))
    assert alias.guid != LREAL.guid
    assert AliasType("B", BIT).is_bit
    assert resolved(AliasType("T_2", alias)) is LREAL


def test_a_sub_range_checks_writes() -> None:
    percent = SubrangeType(USINT, 10, 90)
    assert percent.name == "USINT (10..90)"
    assert percent.default == b"\x0a"
    assert percent.decode(percent.encode(90)) == 90
    memory = bytearray(b"\x0b")
    for value in (9, 91, 300, "x"):
        with pytest.raises(IecValueError, match=r"takes an integer in 10..90"):
            percent.encode(value)
        with pytest.raises(IecValueError, match=r"takes an integer in 10..90"):
            percent.write(memory, 0, value)
    assert memory == b"\x0b"
    assert SubrangeType(INT, -5, -2).default == INT.encode(-2)
    with pytest.raises(DeclarationError, match=r"5..300 is not a sub-range of USINT"):
        SubrangeType(USINT, 5, 300)


def test_pointers_are_addresses() -> None:
    pointer = PointerType(INT)
    assert (pointer.name, pointer.size, pointer.adst) == ("POINTER TO INT", 8, 65)
    assert ReferenceType(INT, 4).name == "REFERENCE TO INT"
    assert ReferenceType(INT, 4).size == 4
    assert pointer.decode(pointer.encode(2**64 - 1)) == 2**64 - 1
    memory = bytearray(8)
    pointer.write(memory, 0, 258)
    assert pointer.read(memory, 0) == 258
    with pytest.raises(IecValueError, match="an address of 64 bits"):
        pointer.encode(-1)
    with pytest.raises(IecDecodeError):
        pointer.decode(b"abc")
    with pytest.raises(DeclarationError, match="a pointer has 4 or 8 bytes, got 1"):
        PointerType(INT, 1)


def test_a_target_may_come_later() -> None:
    pointer = PointerType(lambda: LREAL, target_name="LREAL")
    assert pointer.name == "POINTER TO LREAL"
    assert pointer.target is LREAL


def test_an_interface_is_a_pointer_with_a_name_of_its_own() -> None:
    assert InterfaceType("I_Motor").name == "I_Motor"
    assert InterfaceType("I_Motor").size == 8
