"""Tc2_XmlDataSrv: variables are kept in XML files, by address or by name."""

from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from achse.station import Station
from achse.station.configuration.station_file import parse

Run = Callable[[str], Any]

TYPES = """
TYPE E_Kind : (small := 3, big := 7); END_TYPE
TYPE ST_Part : STRUCT a : UINT; b : DINT; c : LREAL; d : STRING; END_STRUCT END_TYPE
TYPE ST_All : STRUCT
    part : ST_Part; row : ARRAY [1..3] OF INT; parts : ARRAY [0..1] OF ST_Part;
    on : BOOL; kind : E_Kind; since : DT; wait : TIME; few : REAL;
    field : ARRAY [0..1, 5..6] OF BYTE;
END_STRUCT END_TYPE
PROGRAM MAIN
VAR
    all, copy : ST_All;
    part : ST_Part;
    value : DINT := -7;
    text : STRING := 'a < b';
    read : FB_XmlSrvRead; write : FB_XmlSrvWrite;
    readByName : FB_XmlSrvReadByName; writeByName : FB_XmlSrvWriteByName;
    step : INT;
    errors : ARRAY [0..9] OF UDINT;
END_VAR
"""
FULL = (
    "<all><part><a>1</a><b>-2</b><c>2.5</c><d>&lt;x&gt;</d></part>"
    '<row index="1">10</row><row index="2">20</row><row index="3">30</row>'
    '<parts index="0"><a>4</a><b>0</b><c>0</c><d></d></parts>'
    '<parts index="1"><a>0</a><b>0</b><c>0</c><d></d></parts>'
    "<on>true</on><kind>7</kind><since>1115164800</since><wait>1500</wait><few>0.1</few>"
    '<field index="0,5">0</field><field index="0,6">0</field>'
    '<field index="1,5">9</field><field index="1,6">0</field></all>'
)


@pytest.fixture
def run(tmp_path: Path) -> Run:
    (tmp_path / "shown").mkdir()

    def ended(body: str) -> Any:
        (tmp_path / "a.st").write_text(f"{TYPES}{body}\nEND_PROGRAM", encoding="utf-8")
        document = {"plc": [{"sources": "a.st"}], "system": {"root": "shown"}}
        station = Station(parse(document, "a.toml"), base=tmp_path)
        station.advance(0.5)
        assert station.plcs[851].failure == ""
        return station.plcs[851].instance("MAIN")

    return ended


def _written(folder: Path) -> ElementTree.Element:
    return ElementTree.parse(next((folder / "shown").rglob("v.xml"))).getroot()


def _flat(element: ElementTree.Element) -> list[tuple[str, str | None, str]]:
    return [(each.tag, each.get("index"), (each.text or "").strip()) for each in element.iter()]


def test_missing_file_and_elements_are_added_and_read_back(run: Run, tmp_path: Path) -> None:
    main = run("""
        CASE step OF
        0:
            all.part.a := 1; all.part.b := -2; all.part.c := 2.5; all.part.d := '<x>';
            all.row[1] := 10; all.row[2] := 20; all.row[3] := 30; all.parts[0].a := 4;
            all.on := TRUE; all.kind := E_Kind.big; all.since := DT#2005-05-04-00:00:00;
            all.wait := T#1.5S; all.few := 0.1; all.field[1, 5] := 9;
            write(sFilePath := 'C:\\v.xml', sXPath := '/data/all', nMode := XMLSRV_ADDMISSING,
                pSymAddr := ADR(all), cbSymSize := SIZEOF(all), bExecute := TRUE);
            IF NOT write.bBusy THEN step := 1; errors[0] := write.nErrId; END_IF
        1:
            readByName(sFilePath := 'C:\\v.xml', sXPath := '/data/all', sSymName := 'MAIN.copy',
                bExecute := TRUE);
            IF NOT readByName.bBusy THEN step := 2; errors[1] := readByName.nErrId; END_IF
        END_CASE""")
    assert (main["step"], list(main["errors"])[:2]) == (2, [0, 0])
    root = _written(tmp_path)
    assert root.tag == "data"
    assert _flat(root)[1:] == _flat(ElementTree.fromstring(FULL))
    assert bytes(main["copy"]) == bytes(main["all"])


def test_elements_that_are_not_in_the_file_are_skipped(run: Run, tmp_path: Path) -> None:
    first = run(
        "IF step = 0 THEN writeByName(sFilePath := 'C:\\v.xml', sXPath := '/d/part',"
        " nMode := 1, sSymName := 'MAIN.part', bExecute := TRUE);"
        " IF NOT writeByName.bBusy THEN step := 1; END_IF END_IF"
    )
    assert (first["step"], first["writeByName"]["bError"]) == (1, False)
    path = next((tmp_path / "shown").rglob("v.xml"))
    path.write_text(
        "<d><part><Info>test</Info><a>-100</a><C>1.2</C></part><MAIN.value>4</MAIN.value></d>",
        encoding="utf-8",
    )
    main = run("""
        CASE step OF
        0:
            part.a := 5; part.b := 6;
            read(sFilePath := 'C:\\v.xml', sXPath := '/d/part', pSymAddr := ADR(part),
                cbSymSize := SIZEOF(part), bExecute := TRUE);
            IF NOT read.bBusy THEN step := 1; errors[0] := read.nErrId; END_IF
        1:
            write(sFilePath := 'C:\\v.xml', sXPath := '/d/part', pSymAddr := ADR(part),
                cbSymSize := SIZEOF(part), bExecute := TRUE);
            IF NOT write.bBusy THEN step := 2; errors[1] := write.nErrId; END_IF
        2:
            read(bExecute := FALSE);
            read(sXPath := '/d/MAIN.value', pSymAddr := ADR(value), cbSymSize := SIZEOF(value),
                bExecute := TRUE);
            step := 3;
        3:
            read();
            IF NOT read.bBusy THEN step := 4; errors[2] := read.nErrId; END_IF
        END_CASE""")
    assert (main["step"], list(main["errors"])[:3], main["value"]) == (4, [0, 0, 0], 4)
    part = main["part"]
    assert (part["a"], part["b"], part["c"]) == (5, 6, 1.2)
    assert [(each.tag, each.text) for each in _written(tmp_path)[0]] == [
        ("Info", "test"), ("a", "5"), ("C", "1.2"),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("call", "error"),
    [
        ("sFilePath := 'C:\\none.xml', sXPath := '/d/part', sSymName := 'MAIN.part'", 0x70C),
        ("sFilePath := 'C:\\v.xml', sXPath := '/d/else', sSymName := 'MAIN.part'", 0x8006),
        ("sFilePath := 'C:\\v.xml', sXPath := 'no path!', sSymName := 'MAIN.part'", 0x8006),
        ("sFilePath := 'C:\\v.xml', sXPath := '/d/text', sSymName := 'MAIN.value'", 0x8003),
        ("sFilePath := 'C:\\v.xml', sXPath := '/d/text', sSymName := 'MAIN.none'", 0x710),
        ("sFilePath := 'C:\\bad.xml', sXPath := '/d/text', sSymName := 'MAIN.text'", 0x8002),
        ("sFilePath := 'C:\\v.xml', sXPath := '/d/text', sSymName := 'MAIN.text'", 0),
        ("sFilePath := 'C:\\v.xml', sXPath := '/d/row[@n=\"2\"]', sSymName := 'MAIN.value'", 0),
        ("sFilePath := 'C:\\v.xml', sXPath := '/d/row[1]', sSymName := 'MAIN.part.b'", 0),
    ],
)
def test_errors_of_a_request(run: Run, tmp_path: Path, call: str, error: int) -> None:
    run(
        "IF step = 0 THEN writeByName(sFilePath := 'C:\\v.xml', sXPath := '/d', nMode := 1,"
        " sSymName := 'MAIN.value', bExecute := TRUE);"
        " IF NOT writeByName.bBusy THEN step := 1; END_IF END_IF"
    )
    path = next((tmp_path / "shown").rglob("v.xml"))
    path.write_text('<d><text>hello</text><row n="1">1</row><row n="2">2</row></d>')
    path.with_name("bad.xml").write_text("<d>")
    main = run(f"readByName({call}, bExecute := TRUE);")
    got = main["readByName"]
    assert (got["bBusy"], got["bError"], got["nErrId"]) == (False, error != 0, error)
    if not error and "value" in call:
        assert main["value"] == 2
