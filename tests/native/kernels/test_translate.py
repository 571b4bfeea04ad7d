"""Which functions make a kernel, and how it is called."""

import re
from collections.abc import Sequence
from types import FunctionType
from typing import Any

import pytest

from achse.native.backend import ADDRESS, F64, I64, FunctionSignature
from achse.native.declare import RecordLayout
from achse.native.kernels.arithmetic import TranslationError
from achse.native.kernels.translate import ENTRY, interface_of, translate


class Wheel:
    """A record."""


WHEEL: RecordLayout[Any] = RecordLayout("wheel", {}, 0)


def _function(callable: Any) -> FunctionType:
    assert isinstance(callable, FunctionType)
    return callable


def turn(wheels: Sequence[Wheel], by: float, count: int) -> float:
    return by * count * len(wheels)


def _bare(a, b):  # type: ignore[no-untyped-def]
    return a


def _text(a: str) -> int:
    return len(a)


def _named(*, a: float) -> float:
    return a


def _two(a: float) -> tuple[float, float]:
    return a, a


def test_a_sequence_is_an_address_and_a_length() -> None:
    signature = interface_of(_function(turn), {Wheel: WHEEL}).functions[ENTRY].signature
    assert signature == FunctionSignature((ADDRESS, I64, F64, I64), (F64,))


@pytest.mark.parametrize(
    ("function", "reason"),
    [(_bare, "a has no annotation"), (_text, "'str'"), (_named, "parameter a")],
)
def test_parameters_have_kinds(function: Any, reason: str) -> None:
    with pytest.raises(TranslationError, match=rf"test_translate\.py:\d+: .*{reason}"):
        translate(function, {})


def test_a_tuple_does_not_leave_machine_code() -> None:
    with pytest.raises(TranslationError, match="cannot be called from outside"):
        interface_of(_function(_two), {})


def test_only_functions_of_modules_are_translated() -> None:
    def inner(a: float) -> float:
        return a

    with pytest.raises(TranslationError, match="not a function of a module"):
        translate(_function(inner), {})


def test_what_is_called_is_taken_in_once(written: Any) -> None:
    module = written(
        "def outer(a: float) -> float:\n    return inner(a) + inner(-a)\n"
        "def inner(a: float) -> float:\n    return a if a < 1.0 else inner(a / 2.0)\n"
        "def unused(a: float) -> float:\n    return a\n"
    )
    text = translate(module.outer, {}).assembly()
    assert text.count("define ") == 3  # that which takes its arguments from a block besides
    assert "unused" not in text


def _gear(a: float, halved: bool = False) -> float:
    return 0.5 * a if halved else a


def _ways(a: float, either: bool) -> float:
    return _gear(a, True) + 10.0 * _gear(a, halved=False) + 100.0 * _gear(a) + _gear(a, either)


def test_a_way_that_is_written_in_the_call_has_a_copy_of_its_own() -> None:
    assembly = translate(_function(_ways), {}).assembly()
    result = re.findall(r"^define .*_gear([^\"]*)\"", assembly, re.M)
    assert sorted(result) == ["", ".halved", ".not_halved"]


@pytest.mark.parametrize("either", [False, True])
def test_all_ways_give_what_python_gives(compiled: Any, either: bool) -> None:
    assert compiled(_ways)(3.0, either) == _ways(3.0, either)


def _handed_on(a: float, halved: bool = False) -> float:
    return 2.0 * _gear(a, halved)


def _changed(a: float, halved: bool = False) -> float:
    halved = halved or a > 2.0
    return 2.0 * _gear(a, halved)


def _several(a: float) -> float:
    return _handed_on(a, True) + _changed(a, False)


def test_a_way_is_handed_on_unless_it_changes(compiled: Any) -> None:
    assembly = translate(_function(_several), {}).assembly()
    result = re.findall(r"^define .*_gear([^\"]*)\"", assembly, re.M)
    assert sorted(result) == ["", ".halved"]
    assert compiled(_several)(3.0) == _several(3.0)
