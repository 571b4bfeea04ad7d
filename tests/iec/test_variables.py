"""Declared variables and their addresses."""

import contextlib
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.elementary import BIT, INT, UDINT
from achse.iec.errors import DeclarationError
from achse.iec.strings import STRING
from achse.iec.types import IecType
from achse.iec.variables import Address, Section, Variable


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("%MD4", Address("M", "D", 4)),
        ("%ix0.3", Address("I", "X", 0, 3)),
        ("%Q12.7", Address("Q", "", 12, 7)),
        ("%QB1000", Address("Q", "B", 1000)),
        ("%I*", Address("I")),
        (" %ML8 ", Address("M", "L", 8)),
    ],
)
def test_addresses(text: str, address: Address) -> None:
    assert Address.parse(text) == address
    assert str(address) == text.strip().upper()


@pytest.mark.parametrize(
    "text", ["", "MD4", "%XD4", "%MD", "%MD4.1", "%MX4", "%MX4.8", "%M-1", "%M*.1", "%MD4 %MD5"]
)
def test_texts_that_are_no_address(text: str) -> None:
    with pytest.raises(DeclarationError, match=r"an address is like|has a bit"):
        Address.parse(text)


@given(st.text())
def test_any_text_is_an_address_or_refused(text: str) -> None:
    with contextlib.suppress(DeclarationError):
        assert Address.parse(str(Address.parse(text))) == Address.parse(text)


def test_a_variable_reports_all_that_was_declared() -> None:
    variable: Variable[int, int] = Variable(
        UDINT,
        5,
        name="nCount",
        section=Section.OUTPUT,
        at="%QD4",
        retain=True,
        comment="pieces",
        attributes={"x": "1"},
    )
    placed = variable.placed("nother", 8, None, apart=True)
    assert (placed.name, placed.offset, placed.apart) == ("nCount", 8, True)
    assert (placed.section, placed.address) == (Section.OUTPUT, Address("Q", "D", 4))
    assert (placed.retain, placed.comment, placed.attributes) == (True, "pieces", {"x": "1"})
    assert placed.initial_bytes() == b"\5\0\0\0"
    assert repr(placed) == "<Variable nCount AT %QD4 : UDINT>"


def test_a_variable_is_that_of_its_first_record_and_copied_for_others() -> None:
    variable: Variable[int, int] = Variable(UDINT, 5)
    first = variable.placed("a", 4, None)
    second = variable.placed("b", 8, None)
    assert first is variable
    assert (first.name, first.offset, second.name, second.offset) == ("a", 4, "a", 8)
    third = variable.copy()
    assert third.placed("c", 12, None) is third
    assert (variable.offset, third.offset, third.initial) == (4, 12, 5)


@pytest.mark.parametrize("type", [BIT, INT, STRING(9)])
def test_copy_has_every_field_of_the_declaration(type: IecType[Any]) -> None:
    variable: Variable[Any, Any] = Variable(
        type,
        name="x",
        section=Section.STATIC,
        at="%MX4.1",
        retain=True,
        persistent=True,
        constant=True,
        comment="pieces",
        attributes={"TcNoSymbol": ""},
        offset=8,
        bit=3,
    )
    variable.apart = True
    fields = set(Variable.__slots__) - {"_is_placed", "_shared"}
    copies = [
        (getattr(item, field, None) for field in fields) for item in (variable, variable.copy())
    ]
    assert all(mine is copied for mine, copied in zip(*copies, strict=True))


def test_an_initial_value_must_fit() -> None:
    with pytest.raises(DeclarationError, match="initial value of n: INT takes"):
        Variable(INT, 1 << 20, name="n").initial_bytes()
    assert Variable(INT, name="n").initial_bytes() == b"\0\0"


def test_utf_8_strings_say_so() -> None:
    assert Variable(STRING(8, "utf-8")).attributes == {"TcEncoding": "UTF-8"}
    assert Variable(STRING(8)).attributes == {}


def test_a_bit_leaves_its_neighbours_alone() -> None:
    memory = bytearray(b"\0\xaa\0")
    bit: Variable[bool, bool] = Variable(BIT, offset=1, bit=2)
    assert bit.fetch(memory, 0) is False
    bit.store(memory, 0, True)
    assert memory == b"\0\xae\0"
    assert bit.fetch(memory, 0) is True
    bit.store(memory, 0, False)
    assert memory == b"\0\xaa\0"
