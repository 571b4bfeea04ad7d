"""Whole sources: units, recovery, and texts of any kind."""

import random
import sys
from collections.abc import Callable
from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.st.lexis.lexer import scan
from achse.st.lexis.source import SourceError
from achse.st.lexis.words import KEYWORDS, SIGNS
from achse.st.syntax import tree
from achse.st.syntax.cursor import MOST_FAULTS
from achse.st.syntax.parser import parse, parse_expression, parse_statements
from achse.st.syntax.printer import print_units
from achse.st.syntax.units import GlobalList, Program, Unit

SAMPLE = """
{attribute 'qualified_only'}
TYPE E_State : (Idle := 0, Run := 16#10) UINT := Idle; END_TYPE
TYPE ST_X EXTENDS ST_Base : STRUCT
    a, b AT %I* : ARRAY [0..N - 1, 1..2] OF STRING(80) := ['x', 3('$'y')]; // note
    p : POINTER TO REFERENCE TO INT;
END_STRUCT END_TYPE
VAR_GLOBAL CONSTANT N : INT := 5; END_VAR
(* outer (* inner *) *)
FUNCTION_BLOCK ABSTRACT FB_X EXTENDS A.B IMPLEMENTS I_1, I_2
VAR_INPUT x : INT (0..100) := 5; fb : FB_Y(nA := 1) := (q := 3); END_VAR
VAR_IN_OUT r : REFERENCE TO INT; END_VAR
METHOD PROTECTED FINAL Foo : BOOL
VAR_INPUT c : INT; END_VAR
Foo := c > 5 AND NOT b OR SUPER^.Foo(c := 5, d => e.3);
END_METHOD
PROPERTY PUBLIC P : INT GET P := 5; END_GET SET VAR t : INT; END_VAR x := P; END_SET END_PROPERTY
ACTION Act: x := 1; END_ACTION
x := T#5s - T#3s;
CASE x OF 1, 3..5: a := b := 7; E_State.Idle: y S= TRUE; ELSE z(); END_CASE
FOR i := 1 TO 10 BY 2 DO IF a THEN EXIT; ELSIF b THEN RETURN; END_IF END_FOR
REPEAT x := x + 1; UNTIL x > 5 END_REPEAT
END_FUNCTION_BLOCK
INTERFACE I_1 EXTENDS I_0 METHOD Foo : BOOL END_METHOD PROPERTY P : INT GET END_GET END_PROPERTY
END_INTERFACE
FUNCTION F : LREAL VAR_INPUT x : LREAL; END_VAR F := x ** 2; END_FUNCTION
PROGRAM MAIN VAR f : LREAL; END_VAR f := F(2.5E3); END_PROGRAM
"""


def flat(text: str) -> str:
    lines = print_units(parse(text).check().units).split("\n")
    return " ".join(line.strip() for line in lines if line)


@pytest.mark.parametrize(
    "text",
    [
        "PROGRAM MAIN END_PROGRAM",
        "PROGRAM MAIN VAR a : INT; END_VAR VAR_TEMP b : INT; END_VAR a := 1; END_PROGRAM",
        "PROGRAM MAIN METHOD Run END_METHOD ACTION Go: a(); END_ACTION Run(); END_PROGRAM",
        "FUNCTION F END_FUNCTION",
        "FUNCTION F : INT VAR_INPUT a : INT; END_VAR F := a; END_FUNCTION",
        "FUNCTION F : ARRAY [0..1] OF INT END_FUNCTION",
        "FUNCTION F : REFERENCE TO ST_X END_FUNCTION",
        "FUNCTION INTERNAL F : BOOL VAR_IN_OUT a : ARRAY [*] OF INT; END_VAR END_FUNCTION",
        "FUNCTION_BLOCK FB END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK ABSTRACT FB EXTENDS FB_0 IMPLEMENTS I_1, L.I_2 END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK FINAL FB IMPLEMENTS I_1 END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK PUBLIC FB VAR_STAT a : INT; END_VAR END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK FB VAR_GENERIC CONSTANT n : INT := 1; END_VAR EXTENDS FB_0<n> "
        "END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK FB METHOD m END_METHOD END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK FB METHOD PUBLIC ABSTRACT m : BOOL END_METHOD END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK FB METHOD OVERRIDE m VAR_INST a : INT; END_VAR m := 1; END_METHOD "
        "END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK FB {attribute 'TcRpcEnable'} METHOD m : INT END_METHOD END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK FB PROPERTY p : INT GET p := 1; END_GET END_PROPERTY END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK FB PROPERTY PRIVATE p : INT GET PUBLIC p := 1; END_GET SET VAR a : INT; "
        "END_VAR a := p; END_SET END_PROPERTY END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK FB PROPERTY p : INT := 4 GET p := 1; END_GET END_PROPERTY "
        "END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK FB METHOD Final : BOOL END_METHOD END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK FB PROPERTY Abstract : INT END_PROPERTY END_FUNCTION_BLOCK",
        "INTERFACE I END_INTERFACE",
        "INTERFACE I EXTENDS I_1, I_2 METHOD m VAR_INPUT a : INT; END_VAR END_METHOD END_INTERFACE",
        "NAMESPACE A.B TYPE T : INT; END_TYPE PROGRAM P END_PROGRAM END_NAMESPACE",
        "NAMESPACE A NAMESPACE B FUNCTION F END_FUNCTION END_NAMESPACE END_NAMESPACE",
        "{attribute 'linkalways'} (* of it *) PROGRAM MAIN END_PROGRAM",
    ],
)
def test_units_are_read_as_they_are_written(text: str) -> None:
    assert flat(text) == text


@pytest.mark.parametrize(
    ("text", "line", "column", "message"),
    [
        ("x := 1;", 1, 1,
         "expected TYPE, VAR_GLOBAL, FUNCTION_BLOCK, FUNCTION, PROGRAM or INTERFACE, got 'x'"),
        ("PROGRAM", 1, 8, "expected a name, got the end"),
        ("PROGRAM 5 END_PROGRAM", 1, 9, "expected a name, got '5'"),
        ("PROGRAM MAIN", 1, 13, "expected END_PROGRAM, got the end"),
        ("PROGRAM MAIN END_FUNCTION", 1, 14, "expected END_PROGRAM, got 'END_FUNCTION'"),
        ("PROGRAM A x := 1; PROGRAM B END_PROGRAM", 1, 19, "expected END_PROGRAM, got 'PROGRAM'"),
        ("FUNCTION F : END_FUNCTION", 1, 14, "expected a type, got 'END_FUNCTION'"),
        ("FUNCTION_BLOCK F EXTENDS END_FUNCTION_BLOCK", 1, 26,
         "expected the name of a type, got 'END_FUNCTION_BLOCK'"),
        ("INTERFACE I x := 1; END_INTERFACE", 1, 13,
         "expected METHOD, PROPERTY or END_INTERFACE, got 'x'"),
        ("FUNCTION_BLOCK F METHOD END_METHOD END_FUNCTION_BLOCK", 1, 25,
         "expected a name, got 'END_METHOD'"),
        ("FUNCTION_BLOCK F PROPERTY p GET END_GET END_PROPERTY END_FUNCTION_BLOCK", 1, 29,
         "expected ':', got 'GET'"),
        ("FUNCTION_BLOCK F PROPERTY p : INT x := 1; END_PROPERTY END_FUNCTION_BLOCK", 1, 35,
         "expected GET, SET or END_PROPERTY, got 'x'"),
        ("NAMESPACE A PROGRAM P END_PROGRAM", 1, 34, "expected END_NAMESPACE, got the end"),
        ("PROGRAM P END_IF END_PROGRAM", 1, 11, "expected END_PROGRAM, got 'END_IF'"),
        ("{IF defined (A)} PROGRAM P END_PROGRAM", 1, 39, "expected {END_IF}"),
        ("{END_IF}", 1, 1, "{END_IF} without {IF}"),
        ("{IF defined A}{END_IF}", 1, 1,
         "expected a condition like defined (X) AND NOT defined (Y)"),
    ],
)  # fmt: skip
def test_faults_say_where_and_what(text: str, line: int, column: int, message: str) -> None:
    first = parse(text).faults[0]
    assert (*first.location[1:], first.message) == (line, column, message)


def test_all_faults_of_a_file_are_reported() -> None:
    text = "\n".join(f"PROGRAM P{n}\nVAR a INT; END_VAR\nx := ;\nEND_PROGRAM" for n in range(5))
    parsed = parse(text)
    assert [fault.location.line for fault in parsed.faults] == [
        line for n in range(5) for line in (4 * n + 2, 4 * n + 3)
    ]
    assert len(parsed.units) == 5
    with pytest.raises(SourceError) as caught:
        parsed.check()
    assert len(caught.value.faults) == 10


def test_number_of_reported_faults_is_limited() -> None:
    assert len(parse("a;\n" * 5000 + "PROGRAM P x:=; END_PROGRAM " * 5000).faults) == MOST_FAULTS


def test_variable_lists_of_a_file_are_one_list() -> None:
    text = "{attribute 'qualified_only'}\nVAR_GLOBAL a : INT; END_VAR VAR_GLOBAL b : INT; END_VAR"
    (unit,) = parse(text, name="GVL_X").check().units
    assert isinstance(unit, GlobalList)
    assert (unit.name, len(unit.blocks)) == ("GVL_X", 2)
    assert unit.note.attributes == (("qualified_only", ""),)


def test_actions_may_stand_after_their_unit() -> None:
    parsed = parse(
        "FUNCTION_BLOCK FB VAR n : INT; END_VAR END_FUNCTION_BLOCK\n"
        "ACTION One: n := 1; END_ACTION\nACTION Two: n := 2; END_ACTION\n"
        "PROGRAM MAIN END_PROGRAM ACTION Three: ; END_ACTION"
    ).check()
    parts = [[part.name for part in unit.parts] for unit in parsed.units if hasattr(unit, "parts")]
    assert parts == [["One", "Two"], ["Three"]]
    assert parse("ACTION Lost: ; END_ACTION").faults


@pytest.mark.parametrize(
    ("written", "bracketed"),
    [
        ("1, 2, 3", "[1, 2, 3]"),
        ("1, 2(0)", "[1, 2(0)]"),
        ("3(0)", "[3(0)]"),
        ("(a := 0), (a := 1)", "[(a := 0), (a := 1)]"),
    ],
)
def test_arrays_begin_without_brackets_too(written: str, bracketed: str) -> None:
    text = "VAR_GLOBAL a : ARRAY [0..2] OF T := {}; END_VAR"
    assert parse(text.format(written)).check().units == parse(text.format(bracketed)).units


def test_conditions_leave_out_what_does_not_count() -> None:
    text = """PROGRAM P
{IF defined (SIM)} a := 1; {ELSIF hasvalue (N, '2')} a := 2; {ELSE} a := 3; {END_IF}
END_PROGRAM"""
    for defines, value in (((), "3"), (("sim",), "1"), ({"N": "2"}, "2"), ({"N": "1"}, "3")):
        (unit,) = parse(text, defines=defines).check().units
        assert isinstance(unit, Program)
        assert unit.body == (tree.Assign(":=", tree.Name("a"), tree.Literal("integer", value)),)


def test_the_callers_stack_does_not_matter() -> None:
    def deeper(levels: int) -> int:
        if levels:
            return deeper(levels - 1)
        return len(parse("PROGRAM P a := " + "(" * 90 + "1" + ")" * 90 + "; END_PROGRAM").faults)

    before = sys.getrecursionlimit()  # a PLC that runs in this process has its own
    sys.setrecursionlimit(1000)
    try:
        assert deeper(100) == 0
        assert 1 in [deeper(levels) for levels in range(500, 900, 50)]
    finally:
        sys.setrecursionlimit(before)


def test_a_sample_survives_printing() -> None:
    units = parse(SAMPLE).check().units
    assert parse(print_units(units)).check().units == _by_kind(units)


def _by_kind(units: tuple[Unit, ...]) -> tuple[Unit, ...]:
    lists = [unit for unit in units if isinstance(unit, GlobalList)]
    return (*(unit for unit in units if not isinstance(unit, GlobalList)), *lists)


WORDS = st.sampled_from(
    [*sorted(KEYWORDS), *sorted(SIGNS), "a", "b.c", "5", "1.5", "T#1s", "'x'", "{attribute 'a'}",
     "// c\n", "(*", "*)", "/*", "{", "}", "{IF defined (A)}", "{END_IF}", "%I*", "\n", "S=", "GET",
     "INT#5", '"', "'", "$", "NAMESPACE", "CONSTANT", "PUBLIC"]
)  # fmt: skip


@given(st.lists(WORDS, max_size=60))
@settings(max_examples=75, deadline=None)
def test_words_in_any_order_give_units_or_faults(words: list[str]) -> None:
    parsed = parse(" ".join(words))
    assert all(fault.location.line >= 1 and fault.message for fault in parsed.faults)


@given(st.text(max_size=200))
@settings(max_examples=75, deadline=None)
def test_any_text_gives_units_or_faults(text: str) -> None:
    parse(text)
    for read in (parse_expression, parse_statements):
        with suppress(SourceError):
            read(text)


def test_damaged_sources_give_units_or_faults() -> None:
    chance = random.Random(851)
    for _ in range(300):
        text = list(SAMPLE)
        for _ in range(chance.randint(1, 8)):
            place = chance.randrange(len(text))
            match chance.randrange(4):
                case 0:
                    del text[place : place + chance.randint(1, 30)]
                case 1:
                    text[place] = chr(chance.choice([0, 9, 34, 36, 39, 40, 42, 59, 123, 125, 0xE4]))
                case 2:
                    text.insert(place, chance.choice(["(*", "END_IF ", "VAR ", "((", "'", "{"]))
                case _:
                    text[place:place] = text[place // 2 : place // 2 + 40]
            if not text:
                text = list(SAMPLE)
        parsed = parse("".join(text))
        for fault in parsed.faults:
            assert str(fault).startswith(f"<text>:{fault.location.line}:{fault.location.column}: ")


@pytest.mark.parametrize(
    "unit", ["(", "{", "'", '"', "(*", "/*", "{'", '{"', "[", "a.", "a(", "IF ", "VAR ", "%", "$",
             "TYPE ", "1", "a#", "CASE a OF 1:", "{IF defined (A)}", "\n", "//", "a:=", "**",
             "x : ", "METHOD ", "NAMESPACE A ", "T#1", "D#", "16#", "1.", "{IF NOT "]
)  # fmt: skip
def test_nothing_takes_long(unit: str, many: Callable[[int], int]) -> None:
    text = unit * many(4000)
    parse(text)
    parse("PROGRAM P " + text)


SOUND = """\
TYPE E : (A, B := 5) UINT; END_TYPE
TYPE S : STRUCT a : INT := 5; b : ARRAY[0..3] OF BOOL; END_STRUCT END_TYPE
FUNCTION_BLOCK F EXTENDS G IMPLEMENTS I
VAR_INPUT a : INT; END_VAR
VAR b : S := (a := 5, b := [1, 2]); END_VAR
METHOD M : INT
VAR_INPUT x : INT; END_VAR
M := x + 1;
END_METHOD
PROPERTY P : INT
GET
P := 5;
END_GET
SET
a := P;
END_SET
END_PROPERTY
ACTION Act:
a := 5;
END_ACTION
CASE a OF 1: b(); 2, 3: c := 5; ELSE d(); END_CASE
FOR i := 1 TO 5 BY 2 DO IF a THEN b(); ELSIF c THEN d(); ELSE e(); END_IF END_FOR
WHILE a DO b(); END_WHILE
REPEAT b(); UNTIL c END_REPEAT
__TRY b(); __CATCH(x) c(); __FINALLY d(); __ENDTRY
END_FUNCTION_BLOCK
PROGRAM Last VAR z : INT; END_VAR z := z + 1; END_PROGRAM
"""


def test_a_token_too_few_or_too_many_is_one_fault() -> None:
    assert parse(SOUND).faults == ()
    counts = []
    tokens = scan(SOUND)
    for at, word in zip(tokens.starts, tokens.words, strict=True):
        before, after = SOUND[:at], SOUND[at + len(word) :]
        for text in (" " * len(word), f"{word} {word}", f" ) {word}"):
            parsed = parse(before + text + after)
            counts.append(len(parsed.faults))
            if word not in ("PROGRAM", "Last", "") and parsed.faults:
                assert parsed.units[-1].name == "Last", parsed.faults
    assert max(counts) <= 6
    assert sum(count <= 1 for count in counts) > 0.9 * len(counts)


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("CASE a OF 1: b(); 2..", ": c(); ELSE d(); END_CASE", "an expression, got ':'"),
        ("CASE a OF 1 ", "b(); 2: c(); END_CASE", "',' or ':' after the label, got 'b'"),
        ("REPEAT b(); UNTIL ", "END_REPEAT", "an expression, got 'END_REPEAT'"),
        ("REPEAT b(); ", "END_REPEAT", "UNTIL, got 'END_REPEAT'"),
    ],
)
def test_a_fault_inside_a_block_leaves_its_end_alone(before: str, after: str, message: str) -> None:
    (fault,) = parse(f"PROGRAM P {before}{after} END_PROGRAM").faults
    assert fault.message == f"expected {message}"
    assert fault.location.column == len(f"PROGRAM P {before}") + 1


def test_an_end_that_is_missing_is_missing_once() -> None:
    text = """FUNCTION_BLOCK F
METHOD M
PROPERTY P : INT
GET
P := 5;
END_PROPERTY
END_FUNCTION_BLOCK
PROGRAM Last END_PROGRAM"""
    parsed = parse(text)
    assert [(f.location.line, f.message) for f in parsed.faults] == [
        (2, "expected END_METHOD, got 'PROPERTY'"),
        (5, "expected END_GET, got 'END_PROPERTY'"),
    ]
    assert [unit.name for unit in parsed.units] == ["F", "Last"]


def test_after_a_head_at_fault_variables_are_no_further_faults() -> None:
    text = """FUNCTION_BLOCK F G EXTENDS H
VAR_INPUT a : INT; END_VAR
VAR b : INT; END_VAR
END_FUNCTION_BLOCK"""
    assert [f.location.line for f in parse(text).faults] == [1]
    late = "PROGRAM P a(); VAR b : INT; END_VAR VAR c : INT; END_VAR END_PROGRAM"
    assert [f.message for f in parse(late).faults] == ["expected END_PROGRAM, got 'VAR'"]


def test_empty_blocks_of_an_interface_mean_nothing() -> None:
    text = "INTERFACE I {}METHOD M END_METHOD END_INTERFACE"
    assert flat(text.format("VAR_INPUT END_VAR VAR_OUTPUT END_VAR ")) == text.format("")
