"""Scenarios: loaded as text, run anywhere; a run that raises is a row with its error."""

from pathlib import Path
from typing import Any

import pytest

from achse.sweeps import SweepError, SweepPlan
from achse.sweeps.plan import SweepParameter
from achse.sweeps.scenario import Scenario, digest_of, play

SOURCE = """
def run(*, a: float, seed: int) -> dict[str, float]:
    if a == 2:
        raise ValueError("two")
    return {"sum": a + seed, "file": __file__.rpartition("/")[2], "even": seed % 2 == 0}


def bad(*, seed: int):
    return {"seconds": 1} if seed == 0 else {"x": object()} if seed == 1 else 7


def strange(*, b: int, seed: int):
    return {}
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "scenario.py"
    path.write_text(SOURCE)
    return path


def test_rows_have_parameters_results_and_errors(file: Path) -> None:
    scenario = Scenario.load(file)
    file.unlink()  # it travels as text
    rows = play(scenario, list(SweepPlan([SweepParameter("a", (1, 2))], 2)))
    for row in rows:
        assert row.pop("seconds") >= 0
    assert rows == [
        {"run": 0, "a": 1, "seed": 0, "sum": 1, "file": "scenario.py", "even": True, "error": ""},
        {"run": 1, "a": 1, "seed": 1, "sum": 2, "file": "scenario.py", "even": False, "error": ""},
        {"run": 2, "a": 2, "seed": 0, "error": "ValueError: two"},
        {"run": 3, "a": 2, "seed": 1, "error": "ValueError: two"},
    ]


def test_results_that_cannot_be_are_reported(file: Path) -> None:
    rows = play(Scenario.load(file, "bad"), list(SweepPlan(seeds=3)))
    assert [row["error"].partition(":")[0] for row in rows] == [
        "SweepError",
        "SweepError",
        "SweepError",
    ]
    assert "a dictionary of results, got int" in rows[2]["error"]
    assert "cannot be called 'seconds'" in rows[0]["error"]
    assert "result x is a number, text or bool, got object" in rows[1]["error"]
    (row,) = play(Scenario.load(file, "strange"), list(SweepPlan()))
    assert row["error"].startswith("TypeError")


HOSTILE = r"""
from __future__ import annotations
import asyncio, enum, sys
from dataclasses import dataclass
from beside import VALUE

@dataclass
class Point:
    x: int

class Number(enum.IntEnum):
    A = 7

class Text(str):
    def __str__(self):
        raise OSError

class Odd(Exception):
    def __str__(self):
        raise OSError

RAISED = (
    SystemExit(3), SystemExit(), GeneratorExit(), asyncio.CancelledError("c"), MemoryError("m"),
    RecursionError("r"), Odd(), StopIteration(1), BaseException("b"), ValueError("\udcff"),
    KeyError("k" * 1000), ExceptionGroup("g", [ValueError("v")]),
)
RESULTS = (
    {"n": Number.A, "t": Text("t"), "zero": -0.0, "point": Point(VALUE).x},
    {1: 2}, {"x": "a" * 2_000_000}, {f"x{n}": n for n in range(2000)}, {"x": None}, [1], None,
    {"x": b"b"}, {"x": lambda: 1}, {"x": "\udcff"},
)

def raises(*, which: int, seed: int):
    raise RAISED[which]

def gives(*, which: int, seed: int):
    return RESULTS[which]

def ends_it(*, seed: int):
    raise KeyboardInterrupt
"""


def hostile(tmp_path: Path, name: str, count: int) -> list[dict[str, Any]]:
    (tmp_path / "beside.py").write_text("VALUE = 3")
    (tmp_path / "hostile.py").write_text(HOSTILE)
    which = SweepParameter("which", tuple(range(count)))
    return play(Scenario.load(tmp_path / "hostile.py", name), list(SweepPlan([which])))


def test_whatever_a_run_raises_is_its_error(tmp_path: Path) -> None:
    rows = hostile(tmp_path, "raises", 12)
    assert [row["error"].partition(":")[0] for row in rows] == [
        *("SystemExit", "SystemExit", "GeneratorExit", "CancelledError", "MemoryError"),
        *("RecursionError", "Odd", "StopIteration", "BaseException", "ValueError", "KeyError"),
        "ExceptionGroup",
    ]
    for row in rows:
        assert len(row["error"].encode()) <= 500
        assert set(row) == {"run", "which", "seed", "error", "seconds"}


def test_results_are_plain_or_refused(tmp_path: Path) -> None:
    plain, *refused, text = hostile(tmp_path, "gives", 10)
    assert [type(plain[name]) for name in ("n", "t", "zero", "point")] == [int, str, float, int]
    assert (plain["n"], plain["t"], str(plain["zero"]), plain["point"]) == (7, "t", "-0.0", 3)
    assert [row["error"].partition(":")[0] for row in refused] == ["SweepError"] * 8
    assert text["x"] == "\\udcff"


def test_ctrl_c_ends_a_sweep_in_this_process(tmp_path: Path) -> None:
    (tmp_path / "beside.py").write_text("VALUE = 3")
    (tmp_path / "hostile.py").write_text(HOSTILE)
    scenario = Scenario.load(tmp_path / "hostile.py", "ends_it")
    with pytest.raises(KeyboardInterrupt):
        play(scenario, list(SweepPlan()))
    (row,) = play(scenario, list(SweepPlan()), own_process=True)
    assert row["error"].startswith("KeyboardInterrupt")


def test_files_that_are_no_scenario(tmp_path: Path) -> None:
    file = tmp_path / "x.py"
    for source, message in (
        ("x = 1", "has no function run"),
        ("def run(", "SyntaxError"),
        ("1 / 0", "ZeroDivisionError"),
        ("import sys; sys.exit(3)", "SystemExit"),
    ):
        file.write_text(source)
        with pytest.raises(SweepError, match=message):
            Scenario.load(file)
    file.write_bytes(b"# \xff")
    with pytest.raises(SweepError, match="in UTF-8"):
        Scenario.load(file)


def test_digests_are_of_what_was_found_not_of_when() -> None:
    rows: list[dict[str, Any]] = [
        {"run": 0, "x": 1.5, "seconds": 1.0},
        {"run": 1, "x": float("nan"), "seconds": 2.0},
    ]
    same = [dict(rows[1], seconds=9.0), dict(rows[0], seconds=8.0, gap=None)]
    assert digest_of(rows) == digest_of(same)
    assert digest_of(rows) != digest_of([rows[0], {"run": 1, "x": 1.0, "seconds": 2.0}])
