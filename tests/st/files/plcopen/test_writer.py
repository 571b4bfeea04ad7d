"""PLCopen XML that is written reads as the same units and tasks."""

import re

import pytest

from achse.st.files.envelope import TaskDeclaration
from achse.st.files.exports import parse_export
from achse.st.files.plcopen.documents import parse_plcopen, tasks_of_plcopen
from achse.st.files.plcopen.writer import plcopen_document
from achse.st.syntax.nodes import changed
from achse.st.syntax.parser import Parsed, parse
from achse.st.syntax.printer import print_units
from achse.st.syntax.units import FunctionBlock, Program
from tests.st.files.test_envelope import BLOCK
from tests.st.graphical.drawings import contact, network, networks, read, unit

CREATED = "2026-11-28T12:00:00"
TEXT = """{attribute 'qualified_only'}
VAR_GLOBAL CONSTANT
    nMax : INT := 3; // most
END_VAR

TYPE E_Mode : (off, slow := 5, fast) INT := slow; END_TYPE
TYPE ST_X EXTENDS ST_Base :
STRUCT
    a, b : ARRAY[0..nMax, 1..2] OF REAL := [6(0.5), 2(1.5)];
    s : STRING(30) := 'a$'b < c';
    p : POINTER TO INT;
    r : REFERENCE TO ST_Base;
END_STRUCT
END_TYPE
TYPE ST_Base : STRUCT n : INT (0..100); END_STRUCT END_TYPE
TYPE U_X : UNION w : WORD; b : BYTE; END_UNION END_TYPE

INTERFACE I_Run EXTENDS I_Base
METHOD Run : BOOL
VAR_INPUT n : INT; END_VAR
END_METHOD
PROPERTY P : INT
GET
END_GET
END_PROPERTY
END_INTERFACE
INTERFACE I_Base
END_INTERFACE

FUNCTION F : REAL
VAR_INPUT x : REAL; END_VAR
VAR_OUTPUT y : INT; END_VAR
F := x * 2.0;
END_FUNCTION

FUNCTION_BLOCK ABSTRACT FB_X EXTENDS FB_Base IMPLEMENTS I_Run
VAR_INPUT RETAIN i : BOOL; END_VAR
VAR_IN_OUT io : ST_X; END_VAR
VAR_STAT n : INT; END_VAR
VAR t AT %IX0.3 : BOOL; END_VAR
METHOD PUBLIC Run : BOOL
VAR_INPUT n : INT; END_VAR
Run := n > 3;
END_METHOD
PROPERTY PRIVATE P : INT
GET
VAR k : INT; END_VAR
P := k;
END_GET
SET
n := P;
END_SET
END_PROPERTY
ACTION Act:
n := 0;
END_ACTION
IF i AND n < 3 THEN n := n + 1; END_IF
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Base
END_FUNCTION_BLOCK

PROGRAM MAIN
VAR f : F; END_VAR
f(x := 1);
END_PROGRAM
"""


def written(*sources: Parsed, tasks: tuple[TaskDeclaration, ...] = ()) -> bytes:
    document = plcopen_document(sources, tasks, "plc", CREATED)
    assert document.left_out == []
    return document.text.encode()


def in_order(parsed: Parsed) -> dict[str, str]:
    """Units by name, their parts by kind: a document has actions first."""
    assert not parsed.faults
    texts = {}
    for one in parsed.units:
        if isinstance(one, FunctionBlock | Program):
            one = changed(one, parts=tuple(sorted(one.parts, key=lambda part: type(part).__name__)))
        texts[one.name] = print_units([one])
    return texts


def test_units_read_as_they_were() -> None:
    source = parse(TEXT, name="GVL_X")
    assert in_order(parse_plcopen(written(source), "plc.xml", "plc")) == in_order(source)


def test_elements_alone_say_the_same_as_far_as_the_schema_goes() -> None:
    text = """TYPE E : (off, slow := 5); END_TYPE
TYPE ST_X :
STRUCT
    a : ARRAY[0..3, 1..2] OF REAL := [8(0.5)];
    s : STRING(30) := 'a < b';
    p : POINTER TO INT;
    n : INT (0..100);
END_STRUCT
END_TYPE
FUNCTION F : REAL
VAR_INPUT x : REAL; END_VAR
F := x * 2.0;
END_FUNCTION
PROGRAM MAIN
VAR CONSTANT c : TIME := T#1s; END_VAR
VAR q AT %QX0.3 : BOOL; x : ST_X; END_VAR
q := TRUE;
END_PROGRAM
"""
    bare = re.sub(
        "<InterfaceAsPlainText>.*?</InterfaceAsPlainText>", "", written(parse(text)).decode(),
        flags=re.DOTALL,
    )  # fmt: skip
    assert in_order(parse_plcopen(bare.encode(), "plc.xml", "plc")) == in_order(parse(text))


def test_texts_of_files_stay_with_their_comments() -> None:
    source = read(BLOCK)
    data = written(source)
    assert b"// in" in data
    assert in_order(parse_plcopen(data, "plc.xml", "plc")) == in_order(source)


def test_document_that_was_read_is_written_the_same() -> None:
    once = written(parse(TEXT, name="GVL_X"))
    again = written(parse_plcopen(once, "plc.xml", "plc"))
    assert in_order(parse_plcopen(again, "a", "a")) == in_order(parse_plcopen(once, "a", "a"))


def test_tasks_read_as_they_were() -> None:
    tasks = (
        TaskDeclaration("Fast", 250_000, 1, ("MAIN", "Other")),
        TaskDeclaration("Slow", 1_500_000_000, 20, ()),
    )
    assert tuple(tasks_of_plcopen(written(tasks=tasks), "plc.xml")) == tasks


@pytest.mark.parametrize("name", ["MAIN", "FB_Y"])
def test_drawn_bodies_are_left_out_and_named(name: str) -> None:
    head = f"FUNCTION_BLOCK {name}\nVAR a : BOOL; END_VAR"
    drawn = read(unit(head, networks(network(contact("a")))))
    document = plcopen_document([drawn], (), "plc", CREATED)
    assert document.left_out == [name]
    (read_back,) = parse_plcopen(document.text.encode(), "plc.xml", "plc").units
    assert read_back.name == name


def test_export_of_twincat_2_becomes_a_document() -> None:
    text = (
        "PROGRAM MAIN\nVAR n : INT; END_VAR\n(* @END_DECLARATION := '0' *)\nn := n + 1;\n"
        "END_PROGRAM\n"
    )
    source = parse_export(text, "MAIN.EXP", "MAIN")
    assert in_order(parse_plcopen(written(source), "plc.xml", "plc")) == in_order(source)
