"""Instructions that compute: what each does, drawn over all types, compiled in both ways."""

import math
import random
import struct
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import pytest

from achse.native.backend import (
    ADDRESS,
    BOOL,
    F32,
    F64,
    I8,
    I16,
    I32,
    I64,
    U8,
    U16,
    U32,
    U64,
    FunctionBuilder,
    InstructionError,
    MachineType,
    ModuleBuilder,
    Operand,
    Relation,
    Rounding,
)

WHOLE = (I8, I16, I32, I64, U8, U16, U32, U64)
REAL = (F32, F64)
B = FunctionBuilder


def wrap(number: int, type: MachineType) -> int:
    low = number & (1 << type.bits) - 1
    return low if low <= type.most else low - (1 << type.bits)


def divide(a: int, b: int) -> int:
    return math.trunc(Fraction(a, b)) if b else a


def rotate(a: int, n: int, type: MachineType) -> int:
    low, n = a & (1 << type.bits) - 1, n % type.bits
    return wrap(low << n | low >> type.bits - n, type)


def shift_right(a: int, n: int, type: MachineType) -> int:
    return a >> min(n & (1 << type.bits) - 1, type.bits)


def shift_left(a: int, n: int, type: MachineType) -> int:
    n &= (1 << type.bits) - 1
    return 0 if n >= type.bits else wrap(a << n, type)


OF_WHOLE: dict[str, tuple[Any, Callable[[int, int, MachineType], int]]] = {
    "add": (B.add, lambda a, b, t: wrap(a + b, t)),
    "subtract": (B.subtract, lambda a, b, t: wrap(a - b, t)),
    "multiply": (B.multiply, lambda a, b, t: wrap(a * b, t)),
    "divide": (B.divide, lambda a, b, t: wrap(divide(a, b), t)),
    "remainder": (B.remainder, lambda a, b, t: wrap(a - divide(a, b) * b, t) if b else 0),
    "and": (B.bit_and, lambda a, b, t: a & b),
    "or": (B.bit_or, lambda a, b, t: a | b),
    "xor": (B.bit_xor, lambda a, b, t: a ^ b),
    "left": (B.shift_left, shift_left),
    "right": (B.shift_right, shift_right),
    "turn left": (B.rotate_left, rotate),
    "turn right": (
        B.rotate_right,
        lambda a, b, t: rotate(a, -(b & (1 << t.bits) - 1), t),
    ),
}
RELATIONS: dict[Relation, Callable[[float, float], bool]] = {
    Relation.EQUAL: lambda a, b: a == b,
    Relation.NOT_EQUAL: lambda a, b: a != b,
    Relation.LESS: lambda a, b: a < b,
    Relation.LESS_EQUAL: lambda a, b: a <= b,
    Relation.GREATER: lambda a, b: a > b,
    Relation.GREATER_EQUAL: lambda a, b: a >= b,
}


@pytest.mark.parametrize("type", WHOLE, ids=repr)
def test_whole_numbers(type: MachineType, several: Any, drawn: Any) -> None:
    run = several(
        {name: ([type, type], type, write) for name, (write, _) in OF_WHOLE.items()}
        | {"negate": ([type], type, B.negate), "absolute": ([type], type, B.absolute)}
        | {"not": ([type], type, B.bit_not)}
    )
    dice = random.Random(type.name)
    for _ in range(100):
        a, b = int(drawn(type, dice)), int(drawn(type, dice))
        for name, (_, expected) in OF_WHOLE.items():
            assert run[name](a, b) == expected(a, b, type), (name, a, b)
        assert run["negate"](a) == wrap(-a, type)
        assert run["absolute"](a) == wrap(abs(a), type)
        assert run["not"](a) == wrap(~a, type)


@pytest.mark.parametrize("type", [I8, U16, I64], ids=repr)
def test_constants_beside_them(type: MachineType, several: Any) -> None:
    numbers = (0, 1, 3, type.bits - 1, type.bits, type.most, type.least)
    names = ("divide", "remainder", "left", "right", "multiply")

    def with_constant(name: str, b: int) -> Callable[[B, Operand], Operand]:
        return lambda body, a: OF_WHOLE[name][0](body, a, body.constant(type, b))

    run = several({f"{n} {b}": ([type], type, with_constant(n, b)) for n in names for b in numbers})
    for a in (type.least, type.most, 0, 1, 77):
        for name in names:
            for b in numbers:
                assert run[f"{name} {b}"](a) == OF_WHOLE[name][1](a, b, type), (name, a, b)


@pytest.mark.parametrize("type", [*WHOLE, *REAL], ids=repr)
def test_relations(type: MachineType, several: Any, drawn: Any) -> None:
    def related(relation: Relation) -> Callable[[B, Operand, Operand], Operand]:
        return lambda body, a, b: body.compare(relation, a, b)

    run = several({each.name: ([type, type], BOOL, related(each)) for each in Relation})
    dice = random.Random(type.name)
    for _ in range(60):
        a, b = drawn(type, dice), drawn(type, dice)
        for relation, holds in RELATIONS.items():
            assert run[relation.name](a, b) is holds(a, b)
    if type.is_real:
        assert [each.name for each in Relation if run[each.name](math.nan, 1.0)] == ["NOT_EQUAL"]


def converted(value: float, old: MachineType, new: MachineType) -> float:
    if new is BOOL:
        return value != 0
    if new is F32:
        single: float = struct.unpack("<f", struct.pack("<f", value))[0]
        return single
    if new is F64:
        return float(value)
    if old.is_real:
        return max(new.least, min(math.trunc(value), new.most))
    return wrap(int(value), new)


@pytest.mark.parametrize("old", [BOOL, *WHOLE, *REAL], ids=repr)
def test_conversions(old: MachineType, several: Any, drawn: Any) -> None:
    def to(new: MachineType) -> Callable[[B, Operand], Operand]:
        return lambda body, value: body.convert(value, new)

    types = (BOOL, *WHOLE, *REAL)
    run = several({each.name: ([old], each, to(each)) for each in types})
    dice = random.Random(old.name)
    for _ in range(60):
        value = drawn(old, dice)
        for new in types:
            if new is F32 and abs(value) > 1e38:
                assert math.isinf(run["f32"](value))
            else:
                assert run[new.name](value) == converted(value, old, new), (value, new)
    if old.is_real:
        assert (run["i16"](math.nan), run["bool"](math.nan)) == (0, True)


def test_floats(several: Any) -> None:
    def rounded(way: Rounding) -> Callable[[B, Operand], Operand]:
        return lambda body, a: body.round(a, way)

    run = several(
        {name: ([F64, F64], F64, getattr(B, name)) for name in ("add", "subtract", "multiply")}
        | {"divide": ([F64, F64], F64, B.divide), "remainder": ([F64, F64], F64, B.remainder)}
        | {way.name: ([F64], F64, rounded(way)) for way in Rounding}
        | {"sin": ([F64], F64, lambda body, a: body.math("sin", a))}
        | {"root": ([F32], F32, lambda body, a: body.intrinsic("sqrt", a))}
        | {"power": ([F32, F32], F32, lambda body, a, b: body.math("pow", a, b))}
        | {"size": ([F64], F64, B.absolute), "negate": ([F64], F64, B.negate)}
    )
    assert run["add"](0.1, 0.2) == 0.1 + 0.2
    assert run["subtract"](0.1, 0.2) == 0.1 - 0.2
    assert run["multiply"](0.1, 0.2) == 0.1 * 0.2
    assert run["divide"](1.0, 3.0) == 1.0 / 3.0
    assert math.isinf(run["divide"](1.0, 0.0))
    assert run["remainder"](-7.5, 2.0) == math.fmod(-7.5, 2.0)
    assert [run[way.name](2.5) for way in Rounding] == [2.0, 3.0, 2.0, 2.0, 3.0]
    assert [run[way.name](-2.5) for way in Rounding] == [-3.0, -2.0, -2.0, -2.0, -3.0]
    assert run["sin"](0.7) == math.sin(0.7)
    assert (run["root"](2.25), run["power"](1.5, 2.0)) == (1.5, 2.25)
    assert (run["size"](-1.0), run["negate"](1.0)) == (1.0, -1.0)


def test_bits_of_floats(several: Any) -> None:
    run = several(
        {
            "bits": ([F32], U32, lambda body, a: body.reinterpret(a, U32)),
            "float": ([U64], F64, lambda body, a: body.reinterpret(a, F64)),
            "sign": ([U8], I8, lambda body, a: body.reinterpret(a, I8)),
        }
    )
    assert run["bits"](1.0) == 0x3F80_0000
    assert run["float"](0x3FF0_0000_0000_0000) == 1.0
    assert run["sign"](255) == -1


def test_what_does_not_fit_is_refused() -> None:
    module = ModuleBuilder()
    body = module.function("run", [I16, I32, F64, ADDRESS, BOOL], [I16])
    a, b, x, p, yes = body.parameters
    for refused, reason in (
        (lambda: body.add(a, b), "one type expected, got i16 and i32"),
        (lambda: body.add(p, p), "numbers expected"),
        (lambda: body.bit_and(x, x), "whole numbers or bools"),
        (lambda: body.shift_left(yes, yes), "a whole number expected"),
        (lambda: body.convert(x, ADDRESS), "no address is a float"),
        (lambda: body.reinterpret(x, I32), "the bits of f64"),
        (lambda: body.constant(I16, 40_000), "40000 where a number of type i16"),
        (lambda: body.intrinsic("sqrt", a), "a float expected"),
    ):
        with pytest.raises(InstructionError, match=reason):
            refused()  # type: ignore[no-untyped-call]


@pytest.mark.parametrize("type", [I64, I32, U8], ids=repr)
def test_a_float_that_fits_is_cut_in_one_instruction(type: MachineType, several: Any) -> None:
    run = several({"cut": ([F64], type, lambda body, value: body.truncate(value, type))})
    for value in (0.0, 1.75, 99.5, *((-1.75, -99.5) if type.signed else ())):
        assert run["cut"](value) == int(value)
    assert type.least <= run["cut"](1e300) <= type.most


def test_only_floats_are_cut_to_whole_numbers() -> None:
    body = ModuleBuilder().function("main", [F64, I64])
    number, whole = body.parameters
    with pytest.raises(InstructionError, match="a float to a whole number expected"):
        body.truncate(whole, I64)
    with pytest.raises(InstructionError, match="a float to a whole number expected"):
        body.truncate(number, F32)
