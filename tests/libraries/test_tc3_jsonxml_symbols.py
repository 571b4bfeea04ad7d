"""Tc3_JsonXml: variables are written as JSON and read from it, by the names of their types."""

import json
from typing import Any

from tests.plc.code.conftest import Ran

TYPES = """
TYPE E_Kind : (small := 3, big := 7); END_TYPE
TYPE ST_Sub : STRUCT a : INT; b : ARRAY [1..2] OF REAL; END_STRUCT END_TYPE
TYPE ST_Values : STRUCT
    {attribute 'Unit' := 'm/s'} {attribute 'DisplayName' := 'Speed'} speed : LREAL;
    on : BOOL; name : STRING; kind : E_Kind; sub : ST_Sub; subs : ARRAY [0..1] OF ST_Sub;
    grid : ARRAY [0..1, 0..1] OF USINT; moment : DT; wait : TIME; p : POINTER TO INT;
END_STRUCT END_TYPE
PROGRAM MAIN
VAR
    values, copy : ST_Values;
    json : FB_JsonReadWriteDatatype;
    sax : FB_JsonSaxWriter;
    s, t, u, metadata : STRING(2000);
    small : STRING(9);
    short : STRING(255);
    length, room : UDINT := 2000;
    ok : ARRAY [0..9] OF BOOL;
    hr : ARRAY [0..9] OF HRESULT;
    n : ARRAY [0..9] OF UDINT;
    typeName, symbol : STRING(255);
END_VAR
"""
VALUES = {
    "speed": 2.5,
    "on": True,
    "name": 'x"y',
    "kind": 7,
    "sub": {"a": -3, "b": [0.1, 2]},
    "subs": [{"a": 0, "b": [0, 0]}, {"a": 9, "b": [0, 0]}],
    "grid": [[0, 0], [5, 0]],
    "moment": "2024-02-29T12:30:00",
    "wait": 1500,
}
SET = """
values.speed := 2.5; values.on := TRUE; values.name := 'x"y'; values.kind := E_Kind.big;
values.sub.a := -3; values.sub.b[1] := 0.1; values.sub.b[2] := 2; values.subs[1].a := 9;
values.grid[1, 0] := 5; values.moment := DT#2024-02-29-12:30:00; values.wait := T#1.5S;
"""


def _main(body: str) -> Any:
    ran = Ran(f"{TYPES}{SET}{body} END_PROGRAM", has_twin=False).cycle()
    assert ran.plc.failure == ""
    return ran.plc.instance("MAIN")


def test_value_is_written_in_all_ways() -> None:
    main = _main("""
        n[0] := json.CopyJsonStringFromSymbol(
            'ST_Values', SIZEOF(values), ADR(values), s, SIZEOF(s));
        n[1] := json.GetSizeJsonStringFromSymbol('ST_Values', SIZEOF(values), ADR(values));
        ok[0] := json.GetJsonFromSymbol('', SIZEOF(values), ADR(values), room, ADR(t));
        sax.StartObject();
        ok[1] := json.AddJsonKeyValueFromSymbol(sax, 'v', 'st_values', SIZEOF(values), ADR(values));
        ok[2] := json.AddJsonKeyPropertiesFromSymbol(
            sax, 'MetaData', 'ST_Values', 'Unit|DisplayName');
        sax.EndObject(); sax.CopyDocument(u, SIZEOF(u));
        short := json.GetJsonStringFromSymbol('ST_Sub', SIZEOF(values.sub), ADR(values.sub));
        metadata := json.GetJsonStringFromSymbolProperties('ST_Values', 'unit');
        typeName := json.GetDatatypeNameByAddress(SIZEOF(values.subs[1]), ADR(values.subs[1]));
        symbol := json.GetSymbolNameByAddress(SIZEOF(values.grid[1, 0]), ADR(values.grid[1, 0]));
        """)
    assert json.loads(main["s"]) == VALUES
    assert main["n"][0] == main["n"][1] == main["room"] == len(main["s"]) + 1
    assert main["t"] == main["s"]
    attributes = {"speed": {"Unit": "m/s", "DisplayName": "Speed"}}
    assert json.loads(main["u"]) == {"v": VALUES, "MetaData": attributes}
    assert list(main["ok"])[:3] == [True] * 3
    assert json.loads(main["short"]) == VALUES["sub"]
    assert json.loads(main["metadata"]) == {"speed": {"Unit": "m/s"}}
    assert (main["typeName"], main["symbol"]) == ("ST_Sub", "MAIN.values.grid[1,0]")


def test_value_is_read_and_what_does_not_fit_stays() -> None:
    main = _main("""
        json.CopyJsonStringFromSymbol('ST_Values', SIZEOF(values), ADR(values), s, SIZEOF(s));
        ok[0] := json.SetSymbolFromJson(s, 'ST_Values', SIZEOF(copy), ADR(copy));
        ok[1] := json.SetSymbolFromJson(
            '{"SPEED": 7, "on": 1, "sub": {"a": 99999, "b": [4]}, "none": 5, "grid": [[1], 2]}',
            'ST_Values', SIZEOF(values), ADR(values));
        """)
    assert list(main["ok"])[:2] == [True, True]
    copy, values = main["copy"], main["values"]
    assert (copy["name"], copy["sub"]["b"][1], copy["grid"][1, 0]) == (
        'x"y', main["copy"]["sub"]["b"][1], 5,
    )  # fmt: skip
    assert (values["speed"], values["on"], values["sub"]["a"]) == (7, True, -3)
    assert (values["sub"]["b"][1], values["sub"]["b"][2]) == (4, 2)
    assert (values["grid"][0, 0], values["grid"][1, 0]) == (1, 5)


def test_errors() -> None:
    main = _main("""
        n[0] := json.CopyJsonStringFromSymbol(
            'ST_None', SIZEOF(values), ADR(values), s, SIZEOF(s), hrErrorCode => hr[0]);
        n[1] := json.CopyJsonStringFromSymbol('ST_Values', 3, ADR(values), s, SIZEOF(s),
            hrErrorCode => hr[1]);
        small := 'full'; n[2] := json.CopyJsonStringFromSymbol(
            'ST_Values', SIZEOF(values), ADR(values), small, SIZEOF(small), hrErrorCode => hr[2]);
        ok[3] := json.SetSymbolFromJson('{', 'ST_Values', SIZEOF(values), ADR(values),
            hrErrorCode => hr[3]);
        symbol := json.GetSymbolNameByAddress(1, ADR(values) + 1, hrErrorCode => hr[4]);
        """)
    codes = (0x710, 0x710, 0x705, 0x70D, 0x710)
    assert list(main["hr"])[:5] == [0x98110000 + code - 2**32 for code in codes]
    assert list(main["n"])[:3] == [0, 0, 0]
    assert (main["small"], main["ok"][3], main["symbol"]) == ("", False, "")


def test_long_text_is_passed_whole() -> None:
    text = '{"name": "' + "n" * 60 + '", "none": "' + "x" * 60 + '", "speed": 9}'
    main = _main(
        f"ok[0] := json.SetSymbolFromJson('{text}', 'ST_Values', SIZEOF(copy), ADR(copy));"
    )
    assert (main["ok"][0], main["copy"]["speed"]) == (True, 9)
