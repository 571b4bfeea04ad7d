"""Enumeration members in plain kernels."""

import sys
from enum import Enum, IntEnum, IntFlag
from types import CodeType
from typing import Any

import pytest

from achse.native import members
from achse.native.members import fold_members, reached


class Phase(IntEnum):
    NONE = 0
    HOMING = 7
    WAITING = 1 << 40


class Bit(IntFlag):
    READY = 4


class Text(Enum):
    ONE = "one"


SOURCE = """
def run(n: int) -> int:
    total = Bit.READY | n
    for phase in range(n):
        if phase == Phase.HOMING or phase in (Phase.NONE, 3):
            total += helper(phase) if phase else Phase.HOMING
        while total > Phase.WAITING:
            total -= Phase.WAITING
    return total + (Phase.NONE if n == 2 else other(n))

def helper(n: int) -> int:
    return n & Bit.READY

def other(n: int) -> int:
    return Phase.HOMING if n else len(Text.ONE.value) + Phase.WAITING.real

def unused(n: int) -> int:
    return n
"""


def test_a_folded_kernel_computes_the_same_without_looking_up(written: Any) -> None:
    plain = written(SOURCE, Phase=Phase, Bit=Bit, Text=Text)
    folded = written(SOURCE, Phase=Phase, Bit=Bit, Text=Text)
    for _ in range(2):
        fold_members(folded.run)
    for n in range(20):
        assert folded.run(n) == plain.run(n)
    assert folded.run(0) == plain.other(0) + 4
    if sys.version_info < (3, 15):
        vars(folded)["Phase"] = None
        assert folded.run(9) == plain.run(9)
        assert 7 in folded.run.__code__.co_consts
        assert type(folded.other(1)) is int


def test_functions_with_many_constants(written: Any) -> None:
    """Beyond 255 constants and names an instruction has a prefix."""
    many = "".join(f"    n += {number}.5 * (n == Name{number}.A)\n" for number in range(300))
    text = f"def run(n: int) -> float:\n{many}    return n\n"
    names = {f"Name{number}": IntEnum(f"Name{number}", {"A": number}) for number in range(300)}
    plain, folded = written(text, **names), written(text, **names)
    fold_members(folded.run)
    for number in (0, 3, 299, 300):
        assert folded.run(number) == plain.run(number)


def test_an_unknown_byte_code_is_left_alone(written: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    module = written(SOURCE, Phase=Phase, Bit=Bit, Text=Text)
    before: CodeType = module.run.__code__
    monkeypatch.setattr(members, "_KNOWN", False)
    fold_members(module.run)
    assert module.run.__code__ is before


def test_what_a_kernel_reaches(written: Any) -> None:
    module = written(SOURCE, Phase=Phase, Bit=Bit, Text=Text)
    results = dict(reached(module.run))
    assert {"run", "helper", "other", "Phase", "Bit", "Text"} <= results.keys()
    assert "unused" not in results


TABLE = """
def work(n: int) -> int:
    return n + Phase.HOMING

ROWS = (("first", (Phase.NONE, 3), work), ("second", (4,), work))

def run(n: int) -> int:
    for row in ROWS:
        if n in row[1]:
            return row[2](n)
    return 0
"""


def test_what_the_rows_of_a_table_hold_is_reached(written: Any) -> None:
    module = written(TABLE, Phase=Phase)
    results = [thing for _, thing in reached(module.run)]
    assert module.work in results
    assert "first" in results
    assert (Phase.NONE, 3) in results
    fold_members(module.run)
    assert module.run(3) == 10
