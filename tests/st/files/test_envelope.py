"""Sources in XML: units put together, places in the file, and what is refused."""

import random

import pytest

from achse.st.files.envelope import WITHOUT_TEXT, TaskDeclaration, parse_envelope, read_task
from achse.st.graphical.body import GraphicalBody
from achse.st.lexis.source import SourceError
from achse.st.lexis.xml import parse_xml
from achse.st.syntax import units
from achse.st.syntax.parser import Parsed, parse

BLOCK = """<?xml version="1.0" encoding="utf-8"?>
<TcPlcObject Version="1.1.0.1" ProductVersion="3.1.4024.12">
  <POU Name="FB_X" Id="{0}" SpecialFunc="None">
    <Declaration><![CDATA[{attribute 'linkalways'}
FUNCTION_BLOCK FB_X EXTENDS FB_Base
VAR_INPUT
\tbIn : BOOL; // in
END_VAR
]]></Declaration>
    <Implementation>
      <ST><![CDATA[bOut := bIn;
Run();]]></ST>
    </Implementation>
    <Folder Name="Methods" Id="{1}" />
    <Method Name="Run" Id="{2}">
      <Declaration><![CDATA[METHOD PUBLIC Run : BOOL
VAR_INPUT n : INT; END_VAR]]></Declaration>
      <Implementation>
        <ST><![CDATA[Run := n > 0;]]></ST>
      </Implementation>
    </Method>
    <Property Name="P" Id="{3}">
      <Declaration><![CDATA[PROPERTY P : INT]]></Declaration>
      <Get Name="Get" Id="{4}">
        <Declaration><![CDATA[VAR
END_VAR
]]></Declaration>
        <Implementation>
          <ST><![CDATA[P := 1;]]></ST>
        </Implementation>
      </Get>
    </Property>
    <Action Name="Act" Id="{5}">
      <Implementation>
        <ST><![CDATA[bOut := FALSE;]]></ST>
      </Implementation>
    </Action>
    <LineIds Name="FB_X"><LineId Id="3" Count="1" /></LineIds>
  </POU>
</TcPlcObject>"""

SAME = """{attribute 'linkalways'}
FUNCTION_BLOCK FB_X EXTENDS FB_Base
VAR_INPUT
    bIn : BOOL; // in
END_VAR
METHOD PUBLIC Run : BOOL
VAR_INPUT n : INT; END_VAR
Run := n > 0;
END_METHOD
PROPERTY P : INT GET VAR END_VAR P := 1; END_GET END_PROPERTY
ACTION Act: bOut := FALSE; END_ACTION
bOut := bIn;
Run();
END_FUNCTION_BLOCK"""


def read(text: str) -> Parsed:
    return parse_envelope(parse_xml(text.encode(), "x.TcPOU"), "x.TcPOU")


def wrapped(tag: str, declaration: str, name: str = "X", inside: str = "") -> str:
    return (
        f'<TcPlcObject><{tag} Name="{name}"><Declaration><![CDATA[{declaration}]]></Declaration>'
        f"{inside}</{tag}></TcPlcObject>"
    )


def test_a_block_is_what_it_would_be_in_plain_text() -> None:
    assert read(BLOCK).check().units == parse(SAME).check().units


def test_lists_types_and_interfaces() -> None:
    (variables,) = read(wrapped("GVL", "VAR_GLOBAL a : INT; END_VAR", "GVL_X")).check().units
    assert isinstance(variables, units.GlobalList)
    assert variables.name == "GVL_X"
    (type,) = read(wrapped("DUT", "TYPE T : INT; END_TYPE")).check().units
    assert isinstance(type, units.TypeDeclaration)
    method = '<Method Name="m"><Declaration>METHOD m : INT</Declaration></Method>'
    head = "INTERFACE I EXTENDS J\nVAR_INPUT\nEND_VAR\n"  # an empty block means nothing
    (interface,) = read(wrapped("Itf", head, inside=method)).check().units
    assert (
        interface == parse("INTERFACE I EXTENDS J METHOD m : INT END_METHOD END_INTERFACE").units[0]
    )


def test_text_without_cdata_is_text() -> None:
    text = "<a><DUT Name='T'><Declaration>TYPE T : INT (0..5) := 1 &lt; 2; END_TYPE</Declaration>"
    (type,) = read(text + "</DUT></a>").check().units
    assert isinstance(type, units.TypeDeclaration)


@pytest.mark.parametrize("kind", ["PROGRAM", "FUNCTION", "FUNCTION_BLOCK"])
def test_bodies_in_other_languages_are_kept_as_they_are(kind: str) -> None:
    body = "<Implementation><NWL><XmlArchive>x</XmlArchive></NWL></Implementation>"
    text = wrapped("POU", f"{kind} P", inside=body).encode()
    parsed = parse_envelope(parse_xml(text, "x.TcPOU", skip=WITHOUT_TEXT), "x.TcPOU")
    (unit,) = parsed.check().units
    assert isinstance(unit, units.Program | units.Function | units.FunctionBlock)
    assert isinstance(unit.body, GraphicalBody)
    assert unit.body.text == "<NWL><XmlArchive>x</XmlArchive>"
    assert list(parsed.source.drawings) == [unit.body]
    assert unit.body.start > len(parsed.source.text)


def test_faults_have_their_place_in_the_file() -> None:
    text = BLOCK.replace("bIn : BOOL;", "bIn BOOL;").replace("Run();", "Run(;")
    text = text.replace("P := 1;", "P := ;").replace("n > 0;", "n >;")
    faults = read(text).faults
    lines = text.split("\n")
    for fault in faults:
        assert fault.location.path == "x.TcPOU"
        shown = lines[fault.location.line - 1]
        assert fault.text.strip() in shown
    places = {(fault.location.line, fault.message) for fault in faults}
    assert places == {
        (7, "expected ',', AT or ':', got 'BOOL'"),
        (12, "expected an expression, got ';'"),
        (19, "expected an expression, got ';'"),
        (29, "expected an expression, got ';'"),
    }
    columns = {fault.location.line: fault.location.column for fault in faults}
    assert lines[19 - 1][columns[19] - 1] == ";"
    assert lines[12 - 1][columns[12] - 1] == ";"


def test_an_open_comment_stays_in_its_part() -> None:
    parsed = read(BLOCK.replace("bOut := bIn;", "(* bOut"))
    assert [fault.message for fault in parsed.faults] == ["this comment has no end"]
    (block,) = parsed.units
    assert isinstance(block, units.FunctionBlock)
    assert len(block.parts) == 3


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<a/>", "expected a <POU>, <GVL>, <DUT> or <Itf> in <a>"),
        ("<a><POU/></a>", "expected a <Declaration> in <POU>"),
        ("<a><DUT/></a>", "expected a <Declaration> in <DUT>"),
        ("<a><Itf/></a>", "expected a <Declaration> in <Itf>"),
        (wrapped("POU", ""), "expected PROGRAM, FUNCTION_BLOCK or FUNCTION, got the end"),
        (wrapped("POU", "PROGRAM P x := 1;"), "expected the end, got 'x'"),
        (wrapped("POU", "PROGRAM P", inside="<Method/>"), "expected a <Declaration> in <Method>"),
        (
            wrapped("POU", "PROGRAM P", inside="<Property/>"),
            "expected a <Declaration> in <Property>",
        ),
        (wrapped("Itf", "PROGRAM P"), "expected 'INTERFACE', got 'PROGRAM'"),
    ],
)
def test_what_is_no_source_is_a_fault(text: str, message: str) -> None:
    assert read(text).faults[0].message == message


def test_damaged_files_give_units_or_faults() -> None:
    chance = random.Random(852)
    for _ in range(300):
        data = bytearray(BLOCK.encode())
        for _ in range(chance.randint(1, 4)):
            place = chance.randrange(len(data))
            if chance.random() < 0.5:
                data[place] = chance.randrange(256)
            else:
                del data[place : place + chance.randint(1, 40)]
        try:
            root = parse_xml(bytes(data), "x")
        except SourceError:
            continue
        parse_envelope(root, "x")


def test_tasks() -> None:
    text = """<TcPlcObject><Task Name="PlcTask"><CycleTime>10000</CycleTime>
<Priority>20</Priority><PouCall><Name>MAIN</Name></PouCall>
<PouCall><Name>P2</Name></PouCall></Task></TcPlcObject>"""
    task = read_task(parse_xml(text.encode(), "x"))
    assert task == TaskDeclaration("PlcTask", 10_000_000, 20, ("MAIN", "P2"))
    fast = read_task(parse_xml(text.replace("10000", "12.5").encode(), "x"))
    assert fast.cycle_ns == 12_500
    for bad in (
        text.replace("10000", "ten"),
        text.replace("10000", "1.2345"),
        text.replace("20", "-1"),
        "<a/>",
    ):
        with pytest.raises(SourceError, match="expected"):
            read_task(parse_xml(bad.encode(), "x"))
