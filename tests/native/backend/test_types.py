"""Types: sizes, ranges and how they cross the C calling convention."""

import ctypes

import pytest

from achse.native.backend import types
from achse.native.backend.types import (
    ADDRESS,
    BOOL,
    F32,
    F64,
    I8,
    I16,
    I64,
    U8,
    U32,
    FunctionSignature,
    InstructionError,
    Operand,
)

ALL = [thing for thing in vars(types).values() if isinstance(thing, types.MachineType)]


def test_sizes_are_those_that_python_sees() -> None:
    assert all(each.size == ctypes.sizeof(each.c_type) for each in ALL)


def test_ranges() -> None:
    assert (I8.least, I8.most, U8.least, U8.most) == (-128, 127, 0, 255)
    assert (I64.most, U32.most) == (2**63 - 1, 2**32 - 1)
    assert [each for each in ALL if not each.is_whole] == [BOOL, F32, F64, ADDRESS]


def test_narrow_numbers_are_extended() -> None:
    assert (I16.extension, U8.extension, BOOL.extension) == ("signext ", "zeroext ", "zeroext ")
    assert U32.extension == F32.extension == ""


def test_an_operand_says_its_type() -> None:
    assert Operand(I16, "%x").typed == "i16 %x"
    assert Operand(I16, "-3").is_constant
    assert not Operand(ADDRESS, "@table").is_constant


def test_results() -> None:
    assert FunctionSignature().llvm_result == "void"
    assert FunctionSignature((), (F64,)).llvm_result == "double"
    assert FunctionSignature((), (F64, BOOL)).llvm_result == "{ double, i1 }"
    assert FunctionSignature((U8,), (F64,)).c_types == (ctypes.c_double, ctypes.c_uint8)
    with pytest.raises(InstructionError, match="one result expected"):
        FunctionSignature((), (F64, BOOL)).c_types  # noqa: B018
