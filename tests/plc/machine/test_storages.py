"""Storages: what is reached without a look, what is looked up, what is refused."""

import random
from collections.abc import Callable
from typing import Any, NamedTuple

import pytest

from achse.plc.code.execution import CodeForm
from achse.plc.code.faults import ExceptionCode
from achse.plc.memory import Area
from achse.plc.runtime import PlcState

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


_ELEMENTS = {
    "BOOL": (1, "TRUE"), "BYTE": (1, "171"), "INT": (2, "-2"), "DWORD": (4, "16#89ABCDEF"),
    "LINT": (8, "-3"), "REAL": (4, "1.5"), "LREAL": (8, "-2.5"), "STRING(5)": (6, "'abcd'"),
    "WSTRING(2)": (6, '"xy"'), "R": (8, ""), "ARRAY[0..2] OF INT": (6, ""),
}  # fmt: skip
"""Element types of drawn arrays: size in bytes, and a value to write."""


class _Array(NamedTuple):
    size: int
    stride: int
    first: int
    last: int


def _program_of_accesses(dice: random.Random, count: int) -> tuple[str, list[_Array]]:
    """A program that reads or writes element `i` of array `which`, or tells its address."""
    declared: dict[str, str] = dict.fromkeys(("global", "struct", "block", "program", "call"), "")
    branches = dict.fromkeys(("block", "program", "call"), "")
    variables = ""
    arrays = []
    for number in range(count):
        type = dice.choice(list(_ELEMENTS))
        size, value = _ELEMENTS[type]
        place = dice.choice(list(declared))
        first = dice.choice([-3, 0, 1, 70])
        last = first + dice.randrange(4)
        columns = dice.choice([0, 0, 2])
        bounds = f"{first}..{last}" + f", 1..{columns}" * bool(columns)
        declared[place] += f"a{number} : ARRAY[{bounds}] OF {type}; "
        path = {"struct": "GVL.outer.inner.", "global": "GVL."}.get(place, "")
        index = "GVL.i" + ", 2" * bool(columns)
        element = f"{path}a{number}[{index}]"
        variables += f"x{number} : {type}; "
        act = f"GVL.x{number} := {element};"
        if dice.random() < 0.5:
            act = f"{element} := {value or f'GVL.x{number}'};"
        here = place if place in branches else dice.choice(list(branches))
        branches[here] += (
            f"{number}: IF GVL.looks THEN GVL.place := ADR({element}); ELSE {act} END_IF\n"
        )
        arrays.append(_Array(size, size * (columns or 1), first, last))
    body = {place: f"CASE GVL.which OF\n{lines}99: ; END_CASE" for place, lines in branches.items()}
    text = (
        "TYPE R : STRUCT a : INT; b : DINT; END_STRUCT END_TYPE\n"
        f"TYPE Inner : STRUCT pad : BYTE; {declared['struct']} END_STRUCT END_TYPE\n"
        "TYPE Outer : STRUCT pad : INT; inner : Inner; END_STRUCT END_TYPE\n"
        "VAR_GLOBAL which : INT := 99; looks : BOOL; i : LINT; place : LWORD; outer : Outer;\n"
        f"{declared['global']}{variables} END_VAR\n"
        f"FUNCTION fc : INT VAR pad : BYTE; {declared['call']} END_VAR\n{body['call']}"
        f" END_FUNCTION\nFUNCTION_BLOCK F VAR {declared['block']} END_VAR\n{body['block']}"
        f" END_FUNCTION_BLOCK\nPROGRAM MAIN VAR f : F; {declared['program']} END_VAR\n"
        f"{body['program']} f(); fc(); END_PROGRAM\n"
    )
    return text, arrays


@pytest.mark.parametrize("seed", range(3))
def test_an_unchecked_index_reaches_plc_memory_and_nothing_else(run: Run, seed: int) -> None:
    """In both forms: any type, bounds, place, index, read and write."""
    dice = random.Random(seed)
    text, arrays = _program_of_accesses(dice, 12)
    ran = run(text, check_bounds=False)
    plc = ran.plc
    start = {area: plc.memory[area].snapshot() for area in Area}

    def cycle(which: int, index: int, *, looks: bool) -> None:
        for area in Area:
            plc.memory[area].restore(start[area])
        unit = plc.instance("GVL")
        unit["which"], unit["i"], unit["looks"] = which, index, looks
        ran.cycle()

    for _ in range(25):
        which = dice.randrange(len(arrays))
        array = arrays[which]
        distance = dice.choice([1, 2, 5, 100, 10_000, 1 << 20, 1 << 40])
        index = dice.choice([array.first - distance, array.last + distance, array.first])
        cycle(which, array.first, looks=True)
        address = plc.instance("GVL")["place"] + (index - array.first) * array.stride
        there = plc.memory.at(address)
        fits = there is not None and there[1] + array.size <= len(there[0])
        cycle(which, index, looks=False)
        if plc.state is PlcState.EXCEPTION:
            assert not fits
            assert ran.stopped.code == ExceptionCode.ACCESS_VIOLATION
            plc.reset()
            plc.run()
        else:
            assert fits
