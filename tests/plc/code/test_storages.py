"""Storages: arrays, bits, pointers, references, records, packed and overlaid places."""

from collections.abc import Callable
from typing import Any

import pytest

Run = Callable[..., Any]


@pytest.mark.parametrize(
    ("declared", "body", "expected"),
    [
        ("w : WORD; x : BOOL;", "w.3 := TRUE; w.15 := TRUE; x := w.3;", {"w": 0x8008, "x": True}),
        ("a : ARRAY[-1..1, 2..3] OF INT; x : INT;", "a[-1, 3] := 5; a[1, 2] := 6; x := a[-1, 3];",
         {"a": [[0, 5], [0, 0], [6, 0]], "x": 5}),
        ("a : ARRAY[1..3] OF INT; p : POINTER TO INT; x : INT; y : INT;",
         "p := ADR(a); p[2] := 7; x := a[3]; p := p + 2; p^ := 8; y := a[2];", {"x": 7, "y": 8}),
        ("x : INT := 4; r : REFERENCE TO INT; b : BOOL;",
         "b := __ISVALIDREF(r); r REF= x; r := r + 1;", {"x": 5, "b": False}),
        ("s : STRING(5); t : STRING(10); n : INT;",
         "s := 'abcdefgh'; t := s; n := LEN(t); t := CONCAT(t, 'XYZ');",
         {"s": "abcde", "t": "abcdeXYZ", "n": 5}),
        ("s : STRING(8) := 'abcdef';", "s := 'x';", {"s": "x"}),
        ("b : BYTE; p : POINTER TO DWORD; a : ARRAY[0..7] OF BYTE; d : DWORD;",
         "p := ADR(a[1]); p^ := 16#11223344; b := a[2]; d := p^;", {"b": 0x33, "d": 0x11223344}),
        ("w : WSTRING(4); n : INT;", "w := \"äbcdef\"; n := WLEN(w);", {"w": "äbcd", "n": 4}),
        ("x : INT; n : UDINT;", "n := SIZEOF(x) + SIZEOF(n);", {"n": 6}),
    ],
)  # fmt: skip
def test_each_storage(run: Run, declared: str, body: str, expected: dict[str, Any]) -> None:
    ran = run(f"PROGRAM MAIN VAR {declared} END_VAR {body} END_PROGRAM")
    assert ran.plc.failure == ""
    assert {name: ran[name] for name in expected} == expected


def test_unions_and_packed_records(run: Run) -> None:
    ran = run(
        "TYPE U : UNION d : DWORD; b : ARRAY[0..3] OF BYTE; END_UNION END_TYPE\n"
        "{attribute 'pack_mode' := '1'}\n"
        "TYPE P : STRUCT a : BYTE; b : DINT; c : LREAL; END_STRUCT END_TYPE\n"
        "PROGRAM MAIN VAR u : U; p : P; q : P; i : INT := 2; END_VAR"
        " u.d := 16#01020304; u.b[i] := 9; p.a := 1; p.b := -2; p.c := 1.5; q := p;"
        " q.b := q.b - 1; END_PROGRAM"
    )
    assert ran["u.d"] == 0x01090304
    assert ran["q"] == {"a": 1, "b": -3, "c": 1.5}


@pytest.mark.parametrize("index", [0, 4, -1, 30000])
def test_an_index_outside_is_arraybounds_with_its_line(run: Run, index: int) -> None:
    ran = run(
        "PROGRAM MAIN\nVAR a : ARRAY[1..3] OF INT; i : INT; END_VAR\n"
        f"i := {index};\na[i] := 1;\nEND_PROGRAM"
    )
    assert ran.stopped.name == "ARRAYBOUNDS"
    assert (ran.stopped.path, ran.stopped.line, ran.stopped.routine) == ("test.st", 4, "MAIN")
    assert ran["a"] == [0, 0, 0]


def test_an_unchecked_index_reaches_the_neighbouring_bytes(run: Run) -> None:
    ran = run(
        "PROGRAM MAIN VAR before : INT := 7; a : ARRAY[1..3] OF INT; after : INT; i : INT := 4;"
        " x : INT; END_VAR a[i] := 5; i := 0; x := a[i]; END_PROGRAM",
        check_bounds=False,
    )
    assert (ran["before"], ran["a"], ran["after"], ran["x"]) == (7, [0, 0, 0], 5, 7)


def test_an_unchecked_index_of_an_open_array_counts_from_its_first(run: Run) -> None:
    ran = run(
        "FUNCTION put : INT VAR_IN_OUT a : ARRAY[*] OF INT; END_VAR VAR_INPUT i : INT; END_VAR"
        " a[i] := 5; END_FUNCTION\n"
        "PROGRAM MAIN VAR before : INT; a : ARRAY[3..5] OF INT; after : INT; END_VAR"
        " put(a, 2); put(a, 4); put(a, 6); END_PROGRAM",
        check_bounds=False,
    )
    assert (ran["before"], ran["a"], ran["after"]) == (5, [0, 5, 0], 5)


@pytest.mark.parametrize("index", ["-30000", "16#7FFFFFFF", "16#7FFFFFFFFFFFFF"])
def test_an_unchecked_index_outside_of_plc_memory_is_an_access_violation(
    run: Run, index: str
) -> None:
    ran = run(
        "PROGRAM MAIN\nVAR a : ARRAY[1..3] OF LREAL; i : LINT; END_VAR\n"
        f"i := {index};\na[i] := 1;\nEND_PROGRAM",
        check_bounds=False,
    )
    assert (ran.stopped.name, ran.stopped.line) == ("ACCESS_VIOLATION", 4)


@pytest.mark.parametrize("address", ["0", "16#10", "16#FFFFFFFFFFFFFFFF", "16#8000000000000000"])
@pytest.mark.parametrize("type", ["BYTE", "INT", "LREAL", "STRING", "ARRAY[0..9] OF LINT"])
def test_a_wild_pointer_is_an_access_violation(run: Run, address: str, type: str) -> None:
    ran = run(
        f"PROGRAM MAIN VAR p : POINTER TO {type}; x : {type}; END_VAR"
        f" p := {address}; p^ := x; END_PROGRAM"
    )
    assert ran.stopped.name == "ACCESS_VIOLATION"


def test_copying_a_block_leaves_its_header(run: Run) -> None:
    ran = run(
        "FUNCTION_BLOCK A VAR n : INT := 1; END_VAR METHOD M : INT M := n; END_METHOD"
        " END_FUNCTION_BLOCK\n"
        "PROGRAM MAIN VAR a : A; b : A; x : INT; END_VAR b := a; x := b.M(); END_PROGRAM"
    )
    assert ran["x"] == 1


def test_direct_addresses_share_the_image(run: Run) -> None:
    ran = run(
        "PROGRAM MAIN VAR a AT %MW10 : WORD; b AT %MX10.3 : BOOL; c : BOOL; END_VAR"
        " a := 0; b := TRUE; c := %MX10.3; %MB11 := 5; END_PROGRAM"
    )
    assert (ran["a"], ran["c"]) == (0x0508, True)
