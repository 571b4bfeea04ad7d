"""Tc3_JsonXml: documents that are written, read, searched and changed."""

import base64
import json
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.plc.code.conftest import Ran


@pytest.fixture(scope="module")
def writer() -> Ran:
    return Ran(
        "PROGRAM MAIN VAR w : FB_JsonSaxWriter; s : STRING(20); b : ARRAY [0..6] OF BYTE;"
        " whole, length : DINT; real : LREAL; truth : BOOL;"
        " out : STRING(999); n, k : UDINT; short : STRING(255); none : UDINT;"
        " END_VAR w.ResetDocument(); w.StartObject(); w.AddKeyString('text', s); w.AddKey('list');"
        " w.StartArray(); w.AddDint(whole); w.AddLreal(real); w.AddBool(truth);"
        " w.AddNull(); w.StartObject(); w.EndObject(); w.EndArray(); w.AddKeyNumber('n', 7);"
        " w.AddKey('hex'); w.AddHexBinary(ADR(b), length); w.AddKey('b64');"
        " w.AddBase64(ADR(b), length); w.AddKey('raw'); w.AddRawObject('{\"x\":[1]}');"
        " w.AddKey('at'); w.AddDateTime(DT#2024-02-29-12:34:56); w.EndObject();"
        " n := w.CopyDocument(out, SIZEOF(out)); k := w.GetDocumentLength();"
        " none := w.CopyDocument(out, 10); w.ResetDocument(); w.AddString('é');"
        " short := w.GetDocument(); END_PROGRAM"
    )


@settings(max_examples=15, deadline=None)
@given(
    text=st.text('ab"\\/\t\n{}', max_size=9),
    whole=st.integers(-(2**31), 2**31 - 1),
    real=st.floats(-1e6, 1e6),
    data=st.binary(max_size=7),
    truth=st.booleans(),
)
def test_what_is_written_is_json(
    writer: Ran, text: str, whole: int, real: float, data: bytes, truth: bool
) -> None:
    ran = writer
    main: Any = ran.plc.instance("MAIN")
    main["s"], main["whole"], main["real"], main["truth"] = text, whole, real, truth
    main["length"] = len(data)
    for index, byte in enumerate(data):
        main["b"][index] = byte
    ran.cycle(3)
    assert ran.plc.failure == ""
    report = json.loads(ran["out"])
    assert abs(report["list"][1] - real) < 1e-9 * max(1, abs(real))
    assert report | {"list": report["list"][:1] + report["list"][2:]} == {
        "text": text,
        "list": [whole, truth, None, {}],
        "n": 7,
        "hex": data.hex().upper(),
        "b64": base64.b64encode(data).decode(),
        "raw": {"x": [1]},
        "at": "2024-02-29T12:34:56.000",
    }
    assert (ran["n"], ran["none"]) == (ran["k"] + 1, 0)


READ = (
    '{"name":"pump","n":-5,"big":18446744073709551615,"x":1.5,"on":true,"l":[1,2,3],"o":{"p":"q"}}'
)


def test_what_is_read() -> None:
    ran = Ran(
        f"PROGRAM MAIN VAR d : FB_JsonDomParser; s : STRING(300) := '{READ}'; root, v, it, e :"
        " SJsonValue; name, part, all, other : STRING(255); n : DINT; big : ULINT; x : LREAL; on,"
        " has, hasnot, bad, isInt, isObj : BOOL; sum : DINT; names : STRING(255); size, idx : DINT;"
        " i : SJsonIterator; END_VAR"
        " root := d.ParseDocument(s); v := d.FindMember(root, 'name'); name := d.GetString(v);"
        " n := d.GetInt(d.FindMember(root, 'n')); big := d.GetUint64(d.FindMember(root, 'big'));"
        " x := d.GetDouble(d.FindMember(root, 'x')); on := d.GetBool(d.FindMember(root, 'on'));"
        " has := d.HasMember(root, 'o'); hasnot := d.HasMember(root, 'zz');"
        " part := d.GetString(d.FindMemberPath(root, 'o/p')); v := d.FindMember(root, 'l');"
        " size := UDINT_TO_DINT(d.GetArraySize(v)); idx := d.GetInt(d.GetArrayValueByIdx(v, 1));"
        " it := d.ArrayBegin(v); e := d.ArrayEnd(v); sum := 0; WHILE it <> e DO"
        " sum := sum + d.GetInt(d.GetArrayValue(it)); it := d.NextArray(it); END_WHILE"
        " names := ''; i := d.MemberBegin(root); WHILE i <> d.MemberEnd(root) DO"
        " names := CONCAT(CONCAT(names, d.GetMemberName(i)), ' '); i := d.NextMember(i); END_WHILE"
        " isInt := d.IsInt(d.FindMember(root, 'n')); isObj := d.IsObject(root);"
        " d.RemoveMemberByName(root, 'l'); d.RemoveMemberByName(root, 'big');"
        " d.AddStringMember(root, 'new', 'té$'x'); d.SetInt(d.FindMember(root, 'n'), 8);"
        " v := d.AddArrayMember(root, 'a'); d.PushbackBoolValue(v, TRUE);"
        " d.PushbackDoubleValue(v, 0.5); d.AddJsonMember(root, 'j', '{\"k\":null}');"
        " all := d.GetDocument(); bad := d.ParseDocument('{') = 0; d.NewDocument();"
        " other := d.GetDocument(); END_PROGRAM"
    ).cycle(2)
    assert ran.plc.failure == ""
    assert (ran["name"], ran["n"], ran["big"], ran["x"]) == ("pump", -5, 2**64 - 1, 1.5)
    assert (ran["on"], ran["has"], ran["hasnot"], ran["bad"]) == (True, True, False, True)
    assert (ran["part"], ran["sum"], ran["size"], ran["idx"]) == ("q", 6, 3, 2)
    assert ran["names"] == "name n big x on l o "
    assert (ran["isInt"], ran["isObj"], ran["other"]) == (True, True, "{}")
    report = json.loads(ran["all"].encode("cp1252").decode("utf-8"))
    assert report == {
        "name": "pump", "n": 8, "x": 1.5, "on": True, "o": {"p": "q"}, "new": "té'x",
        "a": [True, 0.5], "j": {"k": None},
    }  # fmt: skip


@settings(max_examples=8, deadline=None)
@given(
    data=st.binary(max_size=9),
    moment=st.datetimes(datetime(1971, 1, 1), datetime(2100, 1, 1)),
    zone=st.sampled_from(["", "Z", "+02:00", "-11:30"]),
    room=st.integers(0, 9),
)
def test_texts_are_bytes_and_times(
    decoder: Ran, data: bytes, moment: datetime, zone: str, room: int
) -> None:
    ran = decoder
    main: Any = ran.plc.instance("MAIN")
    at = f"{moment:%Y-%m-%dT%H:%M:%S}.{moment.microsecond:06}{zone}"
    main["s"] = json.dumps([base64.b64encode(data).decode(), data.hex(), at, "no!"])
    main["room"] = room
    ran.cycle()
    assert ran.plc.failure == ""
    fits = len(data) if len(data) <= room else 0
    assert (ran["n64"], ran["n16"]) == (fits, fits)
    assert bytes(main["b64"])[:fits] == bytes(main["b16"])[:fits] == data[:fits]
    utc = datetime.fromisoformat(at if zone else at + "Z").astimezone(UTC)
    since = utc - datetime(1601, 1, 1, tzinfo=UTC)
    steps = since // timedelta(microseconds=1) * 10
    assert ran["file"] == steps
    assert ran["when"] == utc.replace(tzinfo=None, microsecond=0)
    since_2000 = (utc - datetime(2000, 1, 1, tzinfo=UTC)) // timedelta(microseconds=1) * 1000
    assert ran["dc"] == max(since_2000, 0)
    assert list(main["yes"]) == [True, True, True]
    assert list(main["not_so"]) == [False, False, False]


@pytest.fixture(scope="module")
def decoder() -> Ran:
    return Ran(
        "PROGRAM MAIN VAR p : FB_JsonDomParser; s : STRING(255) := '[]'; v : SJsonValue;"
        " b64, b16 : ARRAY [0..8] OF BYTE; room, n64, n16 : DINT; file : FILETIME; dc : DCTIME;"
        " when : DT; yes, not_so : ARRAY [0..2] OF BOOL; END_VAR"
        " v := p.ParseDocument(s);"
        " yes[0] := p.IsBase64(p.GetArrayValueByIdx(v, 0));"
        " yes[1] := p.IsHexBinary(p.GetArrayValueByIdx(v, 1));"
        " yes[2] := p.IsISO8601TimeFormat(p.GetArrayValueByIdx(v, 2));"
        " not_so[0] := p.IsBase64(p.GetArrayValueByIdx(v, 3));"
        " not_so[1] := p.IsHexBinary(p.GetArrayValueByIdx(v, 3));"
        " not_so[2] := p.IsISO8601TimeFormat(p.GetArrayValueByIdx(v, 3));"
        " n64 := p.GetBase64(p.GetArrayValueByIdx(v, 0), ADR(b64), room);"
        " n16 := p.GetHexBinary(p.GetArrayValueByIdx(v, 1), ADR(b16), room);"
        " file := p.GetFileTime(p.GetArrayValueByIdx(v, 2));"
        " when := p.GetDateTime(p.GetArrayValueByIdx(v, 2));"
        " dc := p.GetDcTime(p.GetArrayValueByIdx(v, 2)); END_PROGRAM"
    )


@pytest.mark.parametrize("block", ["FB_JsonSaxWriter", "FB_JsonSaxPrettyWriter"])
def test_a_document_is_complete_when_all_is_closed(block: str) -> None:
    ran = Ran(
        f"PROGRAM MAIN VAR w : {block}; done : ARRAY [0..3] OF BOOL; s : STRING(255);"
        " file : ULINT := 132539328000000000; dc : ULINT := 86400000000000; END_VAR"
        " w.ResetDocument(); done[0] := w.IsComplete(); w.StartObject(); done[1] := w.IsComplete();"
        " w.AddKeyFileTime('file', file); w.AddKeyDcTime('dc', dc);"
        " done[2] := w.IsComplete(); w.EndObject(); done[3] := w.IsComplete();"
        " s := w.GetDocument(); END_PROGRAM"
    ).cycle()
    assert (ran.plc.failure, list(ran["done"])) == ("", [False, False, False, True])
    assert json.loads(ran["s"]) == {
        "file": "2021-01-01T00:00:00.000",
        "dc": "2000-01-02T00:00:00.000",
    }
