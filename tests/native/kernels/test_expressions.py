"""Machine code computes what Python computes, bit for bit, or the expression is refused."""

import math
import struct
from collections.abc import Callable
from enum import Enum, IntEnum
from types import ModuleType
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.native.kernels.arithmetic import LIBRARY, TranslationError
from achse.native.kernels.translate import translate

FLOATS = [
    "a + b * 2 - a / 3.0", "a - -b", "-a", "+a * True", "abs(a) - abs(-b)", "min(a, b)",
    "max(a, b, 1)", "min(0.0, -0.0) * a", "a if a < b else b", "1 if a < b else 2.5",
    "(a > b) + (a >= b) * 2.0", "(a == b) + (a != b) * 2.0 + (a <= b) * 4.0",
    "0.0 < a <= b < 100.0", "a and b", "a or b", "not a", "a < b and b < 10.0 or a > 20.0",
    "a in (0.0, 1.0, b)", "a not in (b, 2)", "a % 3.0", "a % -3.0", "a % b if b else a",
    "math.floor(a) - math.ceil(b) + math.trunc(a)", "round(a) + int(b)", "float(int(a)) / 7",
    "math.sqrt(abs(a))", "math.copysign(a, b)", "math.fabs(a) + math.pi", "bool(a) + 0.5",
    "math.isfinite(a) + math.isnan(b) + math.isinf(a)", "math.inf if a > 0 else -math.inf",
    "TABLE[int(abs(a)) % 4] + NUMBERS[-1]", "NUMBERS[int(abs(a)) % 4] * a", "Colour.RED * a",
    "Plain.ONE.value + a", "CONSTANT * a", "abs(a) ** 0.5", "(a, b)[1] + (b, a)[0]",
    "math.sin(a) + math.cos(b)", "math.atan2(a, b)", "math.exp(-abs(a))", "math.fmod(a, 7.0)",
]  # fmt: skip
WHOLES = [
    "a + b * 3 - 1", "a - b", "-a", "~a", "abs(a)", "a & b | 5 ^ a", "a >> 3", "(a & 255) << 4",
    "a % 7", "a % -7", "a // 7", "a // -7", "a % b if b else 0", "a // b if b else 0",
    "min(a, b) + max(a, b, 3)", "a if a else b", "a and b", "a or b", "not a", "a in (1, b)",
    "a in TABLE", "a < b", "(a < b) | (a > 3)", "(a < b) + True", "TABLE[a % 4]",
    "TABLE[-(a % 4) - 1]", "int(a * 0.5)", "math.floor(a / 3)", "-True + a", "a != b and a - b",
    "not (a < b or not b)", "1 if a < b < 9 else 0",
]  # fmt: skip
OUTSIDE = {
    "[a]": "List", "a.real": "not a record", "unknown": "nothing is called unknown", "a @ b": "Mat",
    "a << 1": "LShift", "~a": "no ~ of a float", "a is b": "comparison Is", "'text'": "'text'",
    "math.nothing": "no math.nothing", "math.hypot(a, b)": "math.hypot", "sum(a)": "sum",
    "a[0]": "no element", "(a, b) + a": "not a number", "min(a)": "min", "abs(a, b)": "arguments",
    "math.sin(x=a)": "arguments", "0xFFFF_FFFF_FFFF_FFFF": "64 bits",
    "a if a else (a, b)": "different kinds", "a in b": "not a tuple", "lambda: a": "Lambda",
    "(a, b)[int(a)]": "no element", "not (a, b)": "only numbers", "f'{a}'": "JoinedStr",
    "a(b)": "not a function",
}  # fmt: skip

TABLE = (3, 1, 4, 1)
NUMBERS = (2.5, 1.5, -0.5, 1)
CONSTANT = 1.25


class Colour(IntEnum):
    RED = 7


class Plain(Enum):
    ONE = 1


NAMES = {
    "TABLE": TABLE, "NUMBERS": NUMBERS, "CONSTANT": CONSTANT,
    "Colour": Colour, "Plain": Plain, "math": math,
}  # fmt: skip


def _module(written: Callable[..., ModuleType], expressions: list[str], kind: str) -> ModuleType:
    """A function for each expression, and `run`, which calls the one asked for."""
    lines = [
        f"def f{n}(a: {kind}, b: {kind}) -> {kind}:\n    return {text}\n"
        for n, text in enumerate(expressions)
    ]
    lines.append(f"def run(which: int, a: {kind}, b: {kind}) -> {kind}:")
    lines += [f"    if which == {n}:\n        return f{n}(a, b)" for n in range(len(expressions))]
    return written("\n".join([*lines, "    return 0"]), **NAMES)


@pytest.fixture(scope="module")
def floats(written: Any, compiled: Any) -> tuple[ModuleType, Callable[..., float]]:
    module = _module(written, FLOATS, "float")
    return module, compiled(module.run)


@pytest.fixture(scope="module")
def wholes(written: Any, compiled: Any) -> tuple[ModuleType, Callable[..., int]]:
    module = _module(written, WHOLES, "int")
    return module, compiled(module.run)


SOME_FLOATS = st.floats(-1e9, 1e9) | st.sampled_from([0.0, -0.0, 0.5, 1.5, 2.5, -0.5, 1.0, 2.0])
SOME_WHOLES = st.integers(-(1 << 40), 1 << 40) | st.integers(-8, 8)


@given(a=SOME_FLOATS, b=SOME_FLOATS)
def test_floats(floats: Any, a: float, b: float) -> None:
    module, run = floats
    for n, text in enumerate(FLOATS):
        expected, got = float(module.run(n, a, b)), run(n, a, b)
        assert struct.pack("d", expected) == struct.pack("d", got), (text, a, b, expected, got)


@given(a=SOME_WHOLES, b=SOME_WHOLES)
def test_whole_numbers(wholes: Any, a: int, b: int) -> None:
    module, run = wholes
    for n, text in enumerate(WHOLES):
        assert int(module.run(n, a, b)) == run(n, a, b), (text, a, b)


def test_not_a_number_is_in_no_relation(floats: Any) -> None:
    module, run = floats
    relations = [
        n for n, text in enumerate(FLOATS) if "==" in text or "<" in text or "isnan" in text
    ]
    for n in relations:
        for a, b in ((math.nan, 1.0), (1.0, math.nan), (math.inf, -math.inf)):
            assert struct.pack("d", float(module.run(n, a, b))) == struct.pack("d", run(n, a, b))


def test_beyond_64_bits_a_float_is_some_whole_number(floats: Any) -> None:
    _, run = floats
    some = run(FLOATS.index("float(int(a)) / 7"), 1e300, 0.0)
    assert abs(some) <= 2.0**63 / 7


@pytest.mark.parametrize("name", sorted(LIBRARY.values()))
def test_the_c_library_is_the_one_python_uses(written: Any, compiled: Any, name: str) -> None:
    two = name in ("atan2", "fmod", "pow")
    arguments = "a, 0.75" if two else "a"
    module = written(
        f"import math\ndef f(a: float) -> float:\n    return math.{name}({arguments})\n"
    )
    run = compiled(module.f)
    for a in (1.25, 2.5, 7.0) if name == "acosh" else (0.1, 0.3, 0.875):
        assert struct.pack("d", module.f(a)) == struct.pack("d", run(a))


@pytest.mark.parametrize(("text", "reason"), OUTSIDE.items())
def test_what_the_language_lacks_is_named(written: Any, text: str, reason: str) -> None:
    module = written(f"def f(a: float, b: float) -> float:\n    return {text}\n", **NAMES)
    with pytest.raises(TranslationError, match=rf"written_\d+\.py:2: f: .*{reason}"):
        translate(module.f, {})
