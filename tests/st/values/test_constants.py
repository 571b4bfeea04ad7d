"""Constant expressions and how they fit into types."""

from typing import Any

import pytest

from achse.iec import (
    ARRAY,
    BYTE,
    INT,
    TIME,
    UINT,
    IecType,
)
from achse.plc import PlcRuntime, Task
from achse.plc.bodies import Bodies
from achse.st.check import check
from achse.st.declare import Declarations, declare
from achse.st.lexis.codes import Code
from achse.st.lexis.source import SourceError
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.parser import parse, parse_expression
from achse.st.syntax.tree import Expression, Name
from achse.st.values.constants import Evaluator, Path, path_of
from achse.st.values.values import Constant, NotConstant

CONSTANTS = {("c",): Constant(7), ("G", "t"): Constant(1500, TIME), ("w",): Constant(5, UINT)}

BLOCK = ARRAY(BYTE, (1, 42))
GRID = ARRAY(INT, (1, 3), (-2, 5))


def lookup(path: Path, at: int) -> Constant:
    if path == ("v",):
        raise NotConstant(at)
    if path not in CONSTANTS:
        raise Unexpected(at, f"no {path}", Code.UNKNOWN_NAME)
    return CONSTANTS[path]


def type_of(tree: Expression) -> IecType[Any]:
    return BLOCK if isinstance(tree, Name) and tree.name == "x" else GRID


def evaluated(text: str) -> Constant:
    return Evaluator(lookup, type_of).value(parse_expression(text))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1 + 2 * 3", 7),
        ("(1 + 2) * 3", 9),
        ("10 - 4 - 3", 3),
        ("7 / 2", 3),
        ("-7 / 2", -3),
        ("7 MOD 3", 1),
        ("-7 MOD 3", -1),
        ("7 / 2.0", 3.5),
        ("2 ** 3", 8.0),
        ("1 < 2", True),
        ("1 >= 2", False),
        ("'a' = 'a'", True),
        ("1 = 1.0", True),
        ("TRUE AND NOT FALSE", True),
        ("TRUE XOR TRUE", False),
        ("TRUE OR_ELSE FALSE", True),
        ("2#1100 AND 2#1010", 8),
        ("2#1100 OR 2#1010", 14),
        ("6 XOR 3", 5),
        ("NOT 16#0F", 0xF0),
        ("NOT WORD#1", 0xFFFE),
        ("NOT 0", -1),
        ("-16#80", -128),
        ("+5", 5),
        ("c - 1", 6),
        ("G.t", 1500),
        ("G.t + T#1s", 2500),
        ("G.t * 2", 3000),
        ("G.t / 2", 750),
        ("G.t * 1.5", 2250),
        ("T#3s / T#1s", 3),
        ("T#1s < T#2s", True),
        ("5.3", 5.3),
        ("c.0", True),
        ("c.3", False),
        ("w.%B0", 5),
        ("SIZEOF(x)", 42),
        ("XSIZEOF(x)", 42),
        ("UPPER_BOUND(x, 1)", 42),
        ("UPPER_BOUND(grid, 2)", 5),
        ("LOWER_BOUND(grid, c - 5)", -2),
        ("SHL(16#FF, 4)", 0xFF0),
        ("TO_INT(2.5) + MAX(c, 1)", 10),
    ],
)
def test_values(text: str, value: object) -> None:
    result = evaluated(text).value
    assert (result, type(result)) == (value, type(value))


@pytest.mark.parametrize("text", ["v", "v + 1", "ADR(c)", "f(1)", "c[1]", "c^", "THIS^.x", "(v)^",
                                  "c := 1", "v.x.y + 1", "TO_STRING(1.0E20)", "MAX(1, v)",
                                  "F_TO_INT(1)", "MAX(a := 1, 2)"])  # fmt: skip
def test_what_shows_at_run_time(text: str) -> None:
    with pytest.raises((NotConstant, Unexpected)) as caught:
        evaluated(text)
    assert isinstance(caught.value, NotConstant) or "no (" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x", "no ('x',)"),
        ("1 / 0", "a division by zero"),
        ("1 MOD 0", "a division by zero"),
        ("1.0 / 0", "a division by zero"),
        ("TRUE + 1", "'+' takes numbers"),
        ("'a' + 1", "'+' takes numbers"),
        ("1 AND 1.5", "AND takes two truths or two whole numbers"),
        ("'a' < 1", "'<' compares values of one kind"),
        ("-TRUE", "- takes a number, got True"),
        ("NOT 1.5", "NOT takes a number, got 1.5"),
        ("1.5.0", "expected"),
        ("c.%X3.%X0", "a bit of a whole number, got False"),
        ("T#1s - LTIME#1s", "'-' takes times of one type"),
        ("10.0 ** 999", "there is no such value"),
        ("(-8) ** 0.5", "the result is not a finite number"),
        ("16#FFFF_FFFF_FFFF_FFFF + 1", "the result does not fit into 64 bits"),
        ("UPPER_BOUND(x, 2)", "has 1 dimensions"),
        ("SIZEOF(x, 1)", "SIZEOF takes 1 arguments, got 2"),
        ("SQRT()", "SQRT takes another number of arguments"),
        ("LIMIT(1)", "LIMIT takes another number of arguments"),
    ],
)
def test_what_has_no_value(text: str, message: str) -> None:
    with pytest.raises((Unexpected, SourceError)) as caught:
        evaluated(text)
    assert message in str(caught.value)


def test_what_is_no_number_stays_none() -> None:
    assert evaluated("LOG(-1)").value != evaluated("LOG(-1)").value


def test_paths() -> None:
    assert path_of(parse_expression("a.b.c")) == ("a", "b", "c")
    assert path_of(parse_expression(".a")) == ("a",)
    assert path_of(parse_expression("a[1].b")) is None
    assert path_of(parse_expression("THIS^.b")) is None


def test_long_sums_are_worked_out_without_recursion() -> None:
    assert evaluated(" + ".join(["1"] * 1000)).value == 1000


def _declared(text: str) -> Declarations:
    return declare([parse(text)])


def _faults(text: str) -> list[str]:
    with pytest.raises(SourceError) as caught:
        _declared(text)
    return [
        f"{fault.location.line}:{fault.location.column} {fault.message}"
        for fault in caught.value.faults
    ]


@pytest.mark.parametrize(
    ("literal", "fault"),
    [
        ("UTF8#'a'", "a number takes digits, like 10, 16#FF or 1.5E3"),
        ("INT#", "a number takes digits, like 10, 16#FF or 1.5E3"),
        ("T#", "TIME takes a timedelta"),
        ("WSTRING#'a'", "a string literal takes WSTRING# and a text in quotes"),
        ("16#ZZ", "a number takes digits of base 16 after #"),
        ("BYTE#300", "BYTE takes an integer in 0..255, got 300"),
        ("1.0E400", "a number takes at most 1.79E308"),
        ("E_None#1", "no type is named 'E_None'"),
        ("E_None#nope", "no constant or variable is named 'E_None.nope'"),
    ],
)
def test_wrong_literals_are_faults_with_their_place(literal: str, fault: str) -> None:
    (message,) = _faults(f"VAR_GLOBAL\nx : LREAL := {literal};\nEND_VAR")
    assert message.startswith("2:14 ")
    assert fault in message


def test_a_literal_of_an_enumeration_by_its_number() -> None:
    text = "TYPE E : (a, b); END_TYPE VAR_GLOBAL x : E := E#1; y : INT := E#b; END_VAR"
    x, y = next(iter(_declared(text).globals.values())).__iec__.members
    assert (x.initial, y.initial) == (1, 1)
    faults = _faults("TYPE S : STRUCT END_STRUCT END_TYPE VAR_GLOBAL x : INT := S#1; END_VAR")
    assert faults == ["1:59 S#… is the value of an enumeration, not of a S"]


def test_a_count_beyond_midnight_stays_as_it_is() -> None:
    """As bodies have it: TO_TOD keeps the bits."""
    (x,) = next(
        iter(_declared("VAR_GLOBAL x : TOD := TO_TOD(4294967295); END_VAR").globals.values())
    ).__iec__.members
    assert x.initial_bytes() == b"\xff" * 4


FILE_MODES = "TYPE E_Mode : (FM_READ, FM_WRITE := 7); END_TYPE "


@pytest.mark.parametrize(
    ("source", "enum", "value", "number"),
    [
        ("", "SysFile.ACCESS_MODE", "SysFile.AM_WRITE", 1),
        ("", "SysFile.ACCESS_MODE", "SysFile.ACCESS_MODE.AM_WRITE", 1),
        (FILE_MODES, "E_Mode", "Files.FM_WRITE", 7),
        (FILE_MODES, "E_Mode", "Files.E_Mode.FM_WRITE", 7),
        (FILE_MODES, "E_Mode", "E_Mode.FM_WRITE", 7),
        (FILE_MODES, "E_Mode", "FM_WRITE", 7),
    ],
)
def test_a_value_of_an_enumeration_behind_the_name_space_of_its_library(
    source: str, enum: str, value: str, number: int
) -> None:
    """The name space is that of a library: no source declares the name."""
    (x,) = next(
        iter(_declared(source + f"VAR_GLOBAL x : INT := {value}; END_VAR").globals.values())
    ).__iec__.members
    assert x.initial == number
    declarations = _declared(
        source + f"PROGRAM P VAR x : INT; e : {enum}; END_VAR x := {value}; e := {value};"
        f" IF e = {value} THEN x := x + 1; END_IF END_PROGRAM"
    )
    project = check(declarations)
    assert not project.faults
    plc = PlcRuntime(
        [Task("T", 1_000_000, list(declarations.programs.values()))], bodies=Bodies(project)
    )
    plc.run_due(1_000_000)
    assert plc.instance("P")["x"] == number + 1
