"""Storages: what is reached without a look, what is looked up, what is refused."""

import random
from collections.abc import Callable
from typing import Any

import pytest

from achse.plc.code.execution import CodeForm

Run = Callable[..., Any]


@pytest.mark.parametrize(
    ("declared", "body", "name"),
    [
        ("p : POINTER TO INT; x : INT;", "p := ADR(x) + 16#1000000; x := p^;", "ACCESS_VIOLATION"),
        ("p : POINTER TO INT; x : INT;", "x := p^;", "ACCESS_VIOLATION"),
        ("p : POINTER TO LREAL;", "p := 16#FFFFFFFFFFFFFFFF; p^ := 1.5;", "ACCESS_VIOLATION"),
        ("p : POINTER TO BYTE;", "p := 16#90000000; p^ := 1;", "ACCESS_VIOLATION"),
        ("p : POINTER TO INT; x : INT; n : DINT := 900000;", "p := ADR(x); p[n] := 1;",
         "ACCESS_VIOLATION"),
        ("a : ARRAY[-2..3] OF INT; i : INT := 4;", "a[i] := 1;", "ARRAYBOUNDS"),
        ("a : ARRAY[-2..3] OF INT; i : LINT := -3;", "a[i] := 1;", "ARRAYBOUNDS"),
        ("a : ARRAY[0..3] OF INT; i : ULINT := 16#8000000000000000;", "a[i] := 1;",
         "ARRAYBOUNDS"),
        ("p : POINTER TO STRING(20);", "p := 16#5000FFF8; p^ := 'longer than what is left';",
         "ACCESS_VIOLATION"),
        ("p : POINTER TO ARRAY[0..99999] OF LREAL; x : LREAL;", "p := ADR(x); p^[0] := p^[99999];",
         "ACCESS_VIOLATION"),
    ],
)  # fmt: skip
def test_nothing_beyond_plc_memory_is_reached(
    run: Run, declared: str, body: str, name: str
) -> None:
    ran = run(f"PROGRAM MAIN\nVAR {declared} END_VAR\n{body}\nEND_PROGRAM")
    assert ran.stopped.name == name
    assert ran.stopped.line == 3


def test_a_wild_instance_is_refused(run: Run) -> None:
    text = (
        "FUNCTION_BLOCK FB VAR n : DINT; END_VAR n := n + 1; END_FUNCTION_BLOCK\n"
        "PROGRAM MAIN VAR p : POINTER TO FB; b : ARRAY[0..99] OF BYTE; END_VAR\n{} p^();"
        " END_PROGRAM"
    )
    assert run(text.format("p := ADR(b) + 1;")).stopped.name in ("MISALIGNMENT", "ACCESS_VIOLATION")
    assert run(text.format("")).stopped.name == "ACCESS_VIOLATION"
    assert run(text.format("p := 16#70000000;")).stopped.name == "ACCESS_VIOLATION"


def test_unaligned_and_bits(run: Run) -> None:
    ran = run(
        "PROGRAM MAIN VAR b : ARRAY[0..19] OF BYTE; p : POINTER TO LREAL; q : POINTER TO DINT;"
        " w : WORD; x : BOOL; END_VAR p := ADR(b) + 3; p^ := 1.5; q := ADR(b) + 13; q^ := -2;"
        " w.3 := TRUE; w.15 := p^ > 1.0; x := w.15 AND NOT w.4; b[0].7 := x; END_PROGRAM"
    )
    assert ran["w"] == 0x8008
    assert ran["b"][:11] == [0x80, 0, 0, 0, 0, 0, 0, 0, 0, 0xF8, 0x3F]


def test_overlapping_copies(run: Run) -> None:
    ran = run(
        "PROGRAM MAIN VAR a : ARRAY[0..9] OF INT := [0,1,2,3,4,5,6,7,8,9];"
        " p, q : POINTER TO ARRAY[0..7] OF INT; END_VAR"
        " p := ADR(a[0]); q := ADR(a[2]); q^ := p^; END_PROGRAM"
    )
    assert ran["a"] == [0, 1, 0, 1, 2, 3, 4, 5, 6, 7]


@pytest.mark.parametrize("seed", range(4))
def test_random_pointers_do_in_machine_code_what_they_do_in_plain_code(
    run: Run, form: CodeForm, seed: int
) -> None:
    """Reads, writes, copies, texts and calls at addresses at, around and far beyond memory."""
    if form is CodeForm.PLAIN:
        pytest.skip("machine code is compared with it")
    dice = random.Random(seed)
    lines = []
    for n in range(60):
        area = dice.choice([0, 1, 2, 3, 4, 5, 6, 7, 8, 15, 16, 2**35])
        end = dice.choice([0, 0x10000, 0x100000, 0x400000, dice.randrange(0x20000)])
        address = (area << 28) + end + dice.randint(-9, 9) & (1 << 64) - 1
        # Not into the variables themselves: they are what is compared.
        write = dice.random() < 0.5 and area != 5
        act = dice.choice(
            ["p1^ := 1;", "p2^ := 2;", "p8^ := 2.5;", "p2[9] := 3;", "ps^ := 'text';", "pr^ := r;"]
            if write
            else ["x := p1^;", "x := p2[dice];", "y := p8^;", "s := ps^;", "r := pr^;", "pf^();"]
        )
        name = act.split("^")[0].split("[")[0].rpartition(" ")[2]
        lines.append(f"__TRY {name} := {address}; {act} __CATCH(c) k[{n}] := c; __ENDTRY\n")
    ran = run(
        "TYPE T : STRUCT a : ARRAY[0..9] OF DINT; END_STRUCT END_TYPE\n"
        "FUNCTION_BLOCK FB VAR n : DINT; END_VAR n := n; END_FUNCTION_BLOCK\n"
        "PROGRAM MAIN VAR p1 : POINTER TO BYTE; p2 : POINTER TO INT; p8 : POINTER TO LREAL;"
        " ps : POINTER TO STRING(30); pr : POINTER TO T; pf : POINTER TO FB; x, dice : DINT;"
        " y : LREAL; s : STRING(30); r : T; c : UDINT; k : ARRAY[0..60] OF UDINT; END_VAR\n"
        f"dice := -7;\n{''.join(lines)}END_PROGRAM"
    )
    assert ran.plc.failure == ""
    assert 0x51 in ran["k"]
