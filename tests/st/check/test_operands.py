"""Operands: constants with and without a certain type, references that are followed."""

from achse.iec.derived import PointerType, ReferenceType
from achse.iec.elementary import BYTE, INT, LREAL, REAL, USINT
from achse.iec.strings import STRING, WSTRING
from achse.st.check.operands import address_of, constant_operand, followed_value, read
from achse.st.typed.expressions import AddressOf, Known, Read
from achse.st.typed.places import FrameBase, PointerBase, Storage
from achse.st.values.values import Constant


def test_a_plain_number_takes_the_type_it_meets() -> None:
    operand = constant_operand(Constant(5), 0)
    assert (operand.value, operand.loose, operand.is_bits) == (Known(5, USINT), True, False)
    bits = constant_operand(Constant(255, BYTE), 0, is_bits=True)
    assert (bits.type, bits.loose, bits.is_bits) == (BYTE, True, True)
    typed = constant_operand(Constant(5, INT), 0)
    assert (typed.type, typed.loose) == (INT, False)


def test_reals() -> None:
    plain, typed = constant_operand(Constant(1.5), 0), constant_operand(Constant(1, REAL), 0)
    assert (plain.type, plain.loose, plain.soft) == (LREAL, True, True)
    assert (typed.value, typed.loose) == (Known(1.0, REAL), False)


def test_texts_are_as_long_as_they_are() -> None:
    operand = constant_operand(Constant("abc", STRING()), 0)
    assert isinstance(operand.value, Known)
    assert (operand.value.value, operand.type.name) == (b"abc", "STRING(3)")
    wide = constant_operand(Constant("ab", WSTRING()), 0)
    assert (wide.constant, wide.type.name) == (b"a\0b\0", "WSTRING(2)")


def test_a_reference_is_followed() -> None:
    reference = ReferenceType(INT)
    storage = Storage(FrameBase(), 8, reference, name="r")
    operand = read(storage, reference, 0)
    pointer = Read(storage, reference)
    assert operand.storage == Storage(PointerBase(pointer), 0, INT, name="r")
    assert operand.reference is storage
    assert address_of(operand.storage, reference, 0) == pointer
    assert followed_value(pointer, reference, 0).flat is INT


def test_an_address_of_a_variable() -> None:
    storage = Storage(FrameBase(), 8, INT, name="n")
    operand = address_of(storage, PointerType(INT), 0)
    assert isinstance(operand, AddressOf)
    assert operand.storage is storage
