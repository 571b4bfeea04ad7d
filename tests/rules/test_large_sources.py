"""Large sources load and run: work grows with their length, and nothing is too deep."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.plc.code.conftest import Ran

PLAIN_PROGRAM = "PROGRAM MAIN VAR a, b : DINT; END_VAR\n"


def _statements(size: int) -> str:
    return PLAIN_PROGRAM + "a := a + 1;\n" * size + "END_PROGRAM"


def _declarations(size: int) -> str:
    names = "".join(f"v{number} : DINT := {number};\n" for number in range(size))
    return f"PROGRAM MAIN VAR a, b : DINT;\n{names}END_VAR\na := v{size - 1} + 1;\nEND_PROGRAM"


def _elsif(size: int) -> str:
    branches = "".join(f"ELSIF b = {number} THEN a := {number};\n" for number in range(1, size))
    return f"{PLAIN_PROGRAM}b := {size - 1};\nIF b = 0 THEN a := 1;\n{branches}END_IF\nEND_PROGRAM"


def _case(size: int) -> str:
    choices = "".join(f"{number}: a := {number};\n" for number in range(size - 1))
    return f"{PLAIN_PROGRAM}b := -1;\nCASE b OF\n{choices}ELSE a := {size};\nEND_CASE\nEND_PROGRAM"


def _functions(size: int) -> str:
    # No function is that of another size: code of the same text is kept.
    functions = "".join(
        f"FUNCTION F{number} : DINT\nVAR_INPUT x : DINT; END_VAR\n"
        f"F{number} := x + {number + size};\nEND_FUNCTION\n"
        for number in range(size // 4)
    )
    return f"{functions}{PLAIN_PROGRAM}a := F{size // 4 - 1}(1);\nEND_PROGRAM"


KINDS: dict[Callable[[int], str], Callable[[int], int]] = {
    _statements: lambda size: size,
    _declarations: lambda size: size,
    _elsif: lambda size: size - 1,
    _case: lambda size: size,
    _functions: lambda size: size // 4 + size,
}
"""What a source of so many lines leaves in `a`."""


def _calls(work: Callable[[], Any]) -> int:
    """How many functions, of Python or in C, are called."""
    calls = 0

    def note(frame: Any, event: str, argument: Any) -> None:
        nonlocal calls
        calls += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        work()
    finally:
        sys.setprofile(before)
    return calls


@pytest.mark.parametrize("kind", KINDS)
def test_work_grows_with_the_length(
    kind: Callable[[int], str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Reading, checking, translating and a cycle of four times as many lines."""
    monkeypatch.setenv("ACHSE_CACHE_DIR", str(tmp_path / "empty"))
    Ran(f"{PLAIN_PROGRAM}a := 1;\nEND_PROGRAM").cycle()  # reads the libraries
    ran: list[Ran] = []
    large = _calls(lambda: ran.append(Ran(kind(1200)).cycle()))
    assert ran[0]["a"] == KINDS[kind](1200)
    assert large < 4.4 * _calls(lambda: Ran(kind(300)).cycle())


def test_many_lines_of_declarations(many: Callable[[int], int]) -> None:
    count = many(10_000)
    assert Ran(_declarations(count)).cycle()["a"] == count


def test_many_lines_of_statements(many: Callable[[int], int]) -> None:
    count = many(2_000)
    text = f"{PLAIN_PROGRAM}{chr(10).join(['a', ':=', 'a', '+ 1', ';'] * count)}\nEND_PROGRAM"
    assert text.count("\n") > 5 * count
    assert Ran(text).cycle()["a"] == count


def test_choices_inside_each_other_at_the_end_of_long_ones() -> None:
    """Depth is what Python's own nesting and ours have in common."""
    text = "a := 7;\n"
    for _ in range(8):
        branches = "".join(f"ELSIF b = {number} THEN a := {number};\n" for number in range(1, 40))
        text = f"IF b = 0 THEN a := 1;\n{branches}ELSE\n{text}END_IF\n"
    assert Ran(f"{PLAIN_PROGRAM}b := 99;\n{text}END_PROGRAM").cycle()["a"] == 7


def test_leaving_loops_from_a_long_choice() -> None:
    branches = "".join(f"ELSIF b = {number} THEN CONTINUE;\n" for number in range(2, 60))
    text = (
        "WHILE TRUE DO\nb := b + 1;\nIF b = 1 THEN a := 0;\n"
        f"{branches}ELSIF b > 70 THEN EXIT;\nEND_IF\na := a + 1;\nEND_WHILE\n"
    )
    assert Ran(f"{PLAIN_PROGRAM}{text}END_PROGRAM").cycle()["a"] == 12
