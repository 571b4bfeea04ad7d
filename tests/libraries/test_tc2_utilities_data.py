"""Tc2_Utilities in memory: texts by address, buffers, CSV, tables, time zones, clocks, control."""

from datetime import UTC, datetime, timedelta
from typing import Any
from uuid import UUID
from zoneinfo import ZoneInfo

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.plc.code.conftest import Ran

LETTERS = st.text("abc;,", max_size=12)


@settings(max_examples=8)
@given(
    text=LETTERS,
    part=LETTERS,
    size=st.integers(1, 16),
    length=st.integers(0, 14),
    at=st.integers(0, 14),
)
def test_parts_of_texts(text: str, part: str, size: int, length: int, at: int) -> None:
    ran = Ran(
        f"PROGRAM MAIN VAR s : STRING(20) := '{text}'; p : STRING(20) := '{part}';"
        " m, l, r, x, d, i, c : STRING(20); ok : ARRAY [0..6] OF BOOL; END_VAR"
        f" ok[0] := MID2(ADR(s), ADR(m), {size}, {length}, {at});"
        f" ok[1] := LEFT2(ADR(s), ADR(l), {size}, {length});"
        f" ok[2] := RIGHT2(ADR(s), ADR(r), {size}, {length});"
        f" ok[3] := REPLACE2(ADR(s), ADR(p), ADR(x), {size}, {length}, {at});"
        f" ok[4] := DELETE2(ADR(s), ADR(d), {size}, {length}, {at});"
        f" ok[5] := INSERT2(ADR(s), ADR(p), ADR(i), {size}, {at});"
        f" ok[6] := STRNCPY(ADR(c), ADR(s), {size}); END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    begin = min(max(at, 1) - 1, len(text))
    middle = text[at - 1 : at - 1 + length] if at >= 1 else ""
    expected = [
        middle,
        text[:length],
        text[max(len(text) - length, 0) :] if length else "",
        text[:begin] + part + text[begin + length :],
        text[:begin] + text[begin + length :],
        text[: min(at, len(text))] + part + text[min(at, len(text)) :],
        text,
    ]
    for number, (name, whole) in enumerate(zip("mlrxdic", expected, strict=True)):
        assert ran[name] == whole[: size - 1]
        assert ran["ok"][number] == (len(whole) < size)


@settings(max_examples=8)
@given(text=LETTERS, find=st.text("abc;", min_size=1, max_size=2), new=LETTERS)
def test_find_and_replace_and_split(text: str, find: str, new: str) -> None:
    ran = Ran(
        f"PROGRAM MAIN VAR s : STRING(20) := '{text}'; f : STRING(5) := '{find}';"
        f" n : STRING(20) := '{new}'; o, gone : STRING(255); l, r, ll, rr : STRING(20);"
        " ok : ARRAY [0..3] OF BOOL; END_VAR"
        " ok[0] := FindAndReplace(ADR(s), ADR(f), ADR(n), ADR(o), SIZEOF(o));"
        " ok[1] := FindAndSplit(ADR(f), ADR(s), ADR(l), SIZEOF(l), ADR(r), SIZEOF(r));"
        " ok[2] := FindAndSplit(ADR(f), ADR(s), ADR(ll), 21, ADR(rr), 21, TRUE);"
        " ok[3] := FindAndDelete(ADR(s), ADR(f), ADR(gone), SIZEOF(gone)); END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    assert list(ran["ok"]) == [find in text] * 4
    assert (ran["o"], ran["gone"]) == (text.replace(find, new), text.replace(find, ""))
    if find in text:
        assert (ran["l"], ran["r"]) == tuple(text.split(find, 1))
        assert (ran["ll"], ran["rr"]) == tuple(text.rsplit(find, 1))


def test_texts_by_the_names_of_their_inputs() -> None:
    """As a public project calls them."""
    ran = Ran(
        "PROGRAM MAIN VAR s : STRING := 'a-b-c'; o, t : STRING; n : UDINT; ok, u : BOOL; END_VAR"
        " ok := FindAndReplaceChar(pSrcString := ADR(s), sDeleteChar := '-', sInsertChar := '',"
        " pDstString := ADR(o), nDstSize := SIZEOF(o)); u := UTF8_TO_STRING(pDstSTRING := ADR(t),"
        " pSrcUTF8 := ADR(o), nDstSize := SIZEOF(t), nDstLen => n); END_PROGRAM"
    ).cycle()
    assert (ran["ok"], ran["o"], ran["u"], ran["t"], ran["n"]) == (True, "abc", True, "abc", 3)


@pytest.mark.parametrize(
    ("text", "ids"),
    [
        ("192.168.0.255", [192, 168, 0, 255]),
        ("0.0.0.0", [0, 0, 0, 0]),
        ("1.2.3", [0] * 4),
        ("1.2.3.", [0] * 4),
        ("1.2.3.4.5", [0] * 4),
        ("1..3.4", [0] * 4),
        ("1.2.3.256", [0] * 4),
        ("1.2.x.4", [0] * 4),
    ],
)
def test_internet_addresses_in_four_numbers(text: str, ids: list[int]) -> None:
    ran = Ran(
        "PROGRAM MAIN VAR a : T_IPv4AddrArr; s : T_IPv4Addr; END_VAR"
        f" a := F_ScanIPv4AddrIds('{text}'); s := F_CreateIPv4Addr(a); END_PROGRAM"
    ).cycle()
    assert list(ran["a"]) == ids
    assert ran["s"] == ".".join(map(str, ids))


def test_wide_texts_and_guids() -> None:
    ran = Ran(
        'PROGRAM MAIN VAR w : WSTRING(20) := "aé€"; v : WSTRING(20); t : WSTRING(40);'
        " s : STRING(20); ok1, ok2, ok3 : BOOL; n : UDINT; g : STRING(38); id : GUID :="
        " (Data1 := 16#1A2B3C4D, Data2 := 1, Data3 := 16#FFFF, Data4 := [1,2,3,4,5,6,7,255]);"
        " b : T_MaxString; END_VAR n := WLEN2(ADR(w));"
        " ok1 := WSTRING_TO_STRING2(ADR(s), ADR(w), SIZEOF(s));"
        " ok2 := STRING_TO_WSTRING2(ADR(v), ADR(s), 6); ok3 := WCONCAT2(ADR(w), ADR(w),"
        " ADR(t), 82);"
        " g := GUID_TO_REGSTRING(id); b := BYTEARR_TO_MAXSTRING(MAXSTRING_TO_BYTEARR('abc'));"
        " END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    assert (ran["n"], ran["s"], ran["v"], ran["t"]) == (3, "aé€", "aé", "aé€aé€")
    assert (ran["ok1"], ran["ok2"], ran["ok3"]) == (True, False, True)
    assert (ran["g"], ran["b"]) == ("{1A2B3C4D-0001-FFFF-0102-0304050607FF}", "abc")


@settings(max_examples=7, deadline=None)
@given(st.lists(st.sampled_from(["", "a", "bcd", "x" * 20]), max_size=8), st.booleans())
def test_texts_first_in_first_out(texts: list[str], over: bool) -> None:
    room = 60
    calls = "".join(f" r.putValue := '{text}'; r.A_AddTail(); {_ok('r')}" for text in texts)
    ran = Ran(
        f"PROGRAM MAIN VAR r : FB_StringRingBuffer; m : ARRAY [1..{room}] OF BYTE; n : INT;"
        " ok : ARRAY [0..40] OF BOOL; out : ARRAY [0..20] OF T_MaxString; k : INT; END_VAR"
        f" r.pBuffer := ADR(m); r.cbBuffer := {room}; r.bOverwrite := {str(over).upper()};{calls}"
        " r.A_RemoveHead(); WHILE r.bOk DO out[k] := r.getValue; k := k + 1; r.A_RemoveHead();"
        " END_WHILE END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    buffer: list[str] = []
    fits = []
    for text in texts:
        while over and buffer and _size(buffer) + 5 + len(text) > room:
            buffer.pop(0)
        fits.append(_size(buffer) + 5 + len(text) <= room)
        if fits[-1]:
            buffer.append(text)
    assert list(ran["ok"])[: len(texts)] == fits
    assert list(ran["out"])[: ran["k"]] == buffer


def _size(texts: list[str]) -> int:
    return sum(5 + len(text) for text in texts)


def _ok(block: str) -> str:
    return f"ok[n] := {block}.bOk; n := n + 1;"


def test_last_in_first_out_and_parts() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR s : FB_MemStackBuffer; m : ARRAY [1..19] OF BYTE; a : DINT := 1; b : INT"
        " := 2; x, y : DINT; ok : ARRAY [0..9] OF BOOL; n : INT; cut : FB_MemBufferSplit; join :"
        " FB_MemBufferMerge; t : STRING(10) := 'abcdefg'; u : STRING(10); c : INT; END_VAR"
        " s.pBuffer := ADR(m); s.cbBuffer := 19; s.pWrite := ADR(a); s.cbWrite := 4; s.A_Push();"
        f" {_ok('s')} s.pWrite := ADR(b); s.cbWrite := 2; s.A_Push(); {_ok('s')} s.A_Push();"
        f" {_ok('s')} s.pRead := ADR(x); s.cbRead := 1; s.A_Top();"
        f" {_ok('s')} s.cbRead := 4; s.A_Pop(); s.pRead := ADR(y); s.A_Pop();"
        f" {_ok('s')} s.A_Pop(); {_ok('s')} cut(eCmd := eEnumCmd_First, pBuffer := ADR(t),"
        " cbBuffer := 7, cbSize := 3); join.eCmd := eEnumCmd_First; WHILE cut.bOk DO"
        " join(pBuffer := ADR(u), cbBuffer := 10, pSegment := cut.pSegment, cbSegment :="
        " cut.cbSegment); join.eCmd := eEnumCmd_Next; c := c + 1; cut(eCmd := eEnumCmd_Next);"
        " END_WHILE END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    assert (ran["x"], ran["y"], ran["u"], ran["c"]) == (2, 1, "abcdefg", 3)
    assert list(ran["ok"])[:6] == [True, True, False, False, True, False]


ROWS = st.lists(
    st.lists(st.text('a;"\r\n', max_size=5), min_size=1, max_size=4), min_size=1, max_size=4
)


@settings(max_examples=8, deadline=None)
@given(ROWS)
def test_csv_there_and_back(rows: list[list[str]]) -> None:
    signs = {'"': '"', "\r": "$R", "\n": "$L"}
    calls = ""
    for row in rows:
        for number, field in enumerate(row):
            text = "".join(signs.get(sign, sign) for sign in field)
            last = str(number == len(row) - 1).upper()
            calls += (
                f" w(putValue := STRING_TO_CSVFIELD('{text}', TRUE), bCRLF := {last}, pBuffer :="
                " ADR(m), cbBuffer := 400); w.eCmd := eEnumCmd_Next;"
            )
    ran = Ran(
        "PROGRAM MAIN VAR w : FB_CSVMemBufferWriter; r : FB_CSVMemBufferReader; m : ARRAY [1..400]"
        " OF BYTE; out : ARRAY [0..20] OF T_MaxString; ends : ARRAY [0..20] OF BOOL; n : INT;"
        f" END_VAR {calls} r(eCmd := eEnumCmd_First, pBuffer := ADR(m), cbBuffer := w.cbSize);"
        " WHILE r.bOk DO out[n] := CSVFIELD_TO_STRING(r.getValue, TRUE); ends[n] := r.bCRLF;"
        " n := n + 1; r(eCmd := eEnumCmd_Next); END_WHILE END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    fields = [field for row in rows for field in row]
    assert list(ran["out"])[: ran["n"]] == fields
    assert [i for i, end in enumerate(ran["ends"]) if end] == [
        sum(map(len, rows[: n + 1])) - 1 for n in range(len(rows))
    ]
    assert ran["w.nRecords"] == len(rows)


def test_csv_fields_are_bytes_too() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR d : DWORD := 16#22413B; e : DWORD; f : ARRAY [0..9] OF BYTE; n, k :"
        " UDINT;"
        " END_VAR n := ARG_TO_CSVFIELD(F_DWORD(d), TRUE, ADR(f), 10);"
        " k := CSVFIELD_TO_ARG(ADR(f), n, TRUE, F_DWORD(e)); END_PROGRAM"
    ).cycle()
    assert (ran["n"], ran["k"], ran["e"]) == (7, 4, 0x22413B)
    assert bytes(ran["f"])[:7] == b'";A""\0"'


def test_values_by_key() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR h : T_HHASHTABLE; e : ARRAY [0..3] OF T_HashTableEntry; t :"
        " FB_HashTableCtrl; ok : ARRAY [0..20] OF BOOL; n : INT; v : ARRAY [0..9] OF PVOID; c :"
        " UDINT; made : BOOL; END_VAR made := F_CreateHashTableHnd(ADR(e), SIZEOF(e), h);"
        f" t(hTable := h, key := 5, putValue := 50); t.A_Add(); {_ok('t')}"
        f" t.key := 9; t.putValue := 90; t.A_Add(); {_ok('t')} t.A_Add(); {_ok('t')}"
        f" t.key := 5; t.A_Lookup(); v[0] := t.getValue; t.key := 7; t.A_Lookup(); {_ok('t')}"
        f" t.key := 1; t.A_Add(); t.key := 2; t.A_Add(); {_ok('t')} t.key := 3; t.A_Add();"
        f" {_ok('t')} t.key := 5; t.A_Remove(); {_ok('t')} t.key := 9; t.A_Lookup();"
        " v[1] := t.getValue; c := h.nCount; t.A_GetFirst(); WHILE t.bOk DO v[2] := v[2] + 1;"
        " t.putPosPtr := t.getPosPtr; t.A_GetNext(); END_WHILE t.A_Reset(); v[3] := h.nFree;"
        " END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    assert list(ran["ok"])[:7] == [True, True, False, False, True, False, True]
    assert (ran["made"], ran["c"], list(ran["v"])[:4]) == (True, 3, [50, 90, 3, 4])


def test_values_in_a_list() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR h : T_HLINKEDLIST; e : ARRAY [0..2] OF T_LinkedListEntry; l :"
        " FB_LinkedListCtrl; v : ARRAY [0..9] OF PVOID; full, found : BOOL; made : BOOL; i : INT;"
        " END_VAR made := F_CreateLinkedListHnd(ADR(e), SIZEOF(e), h); l(hList := h, putValue"
        " := 2);"
        " l.A_AddTailValue(); l.putValue := 3; l.A_AddTailValue(); l.putValue := 1;"
        " l.A_AddHeadValue(); l.A_AddHeadValue(); full := NOT l.bOk; l.A_GetHead(); WHILE l.bOk DO"
        " v[i] := l.getValue; i := i + 1; l.putPosPtr := l.getPosPtr; l.A_GetNext(); END_WHILE"
        " l.putValue := 2; l.putPosPtr := 0; l.A_FindNext(); found := l.bOk; l.putPosPtr :="
        " l.getPosPtr; l.A_RemoveValueAtPosPtr(); l.A_RemoveTailValue(); v[4] := l.getValue;"
        " l.A_GetTail(); v[5] := l.getValue; v[6] := h.nCount; END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    assert (ran["made"], ran["full"], ran["found"]) == (True, True, True)
    assert list(ran["v"])[:7] == [1, 2, 3, 0, 3, 1, 1]


ZONES = {
    "Europe/Berlin": (-60, (10, 0, 5, 3), (3, 0, 5, 2)),
    "America/New_York": (300, (11, 0, 1, 2), (3, 0, 2, 2)),
    "Asia/Tokyo": (-540, None, None),
    "Australia/Sydney": (-600, (4, 0, 1, 3), (10, 0, 1, 2)),
}
"""Bias, end and begin of summer: month, day of the week, which of the month, hour."""


def _rule(rule: tuple[int, int, int, int] | None) -> str:
    if rule is None:
        return "()"
    month, weekday, week, hour = rule
    return f"(wMonth := {month}, wDayOfWeek := {weekday}, wDay := {week}, wHour := {hour})"


@settings(max_examples=13, deadline=None)
@given(
    name=st.sampled_from(sorted(ZONES)),
    moment=st.datetimes(datetime(2010, 1, 1), datetime(2060, 1, 1)),
)
def test_time_zones_as_the_calendar_has_them(name: str, moment: datetime) -> None:
    utc = moment.replace(microsecond=0, tzinfo=UTC)
    local = utc.astimezone(ZoneInfo(name))
    bias, winter, summer = ZONES[name]
    rules = "" if winter is None else f", standardDate := {_rule(winter)}, daylightDate := "
    rules += "" if summer is None else _rule(summer)
    ran = Ran(
        f"PROGRAM MAIN VAR z : ST_TimeZoneInformation := (bias := {bias}, daylightBias := -60"
        f"{rules}); there : FB_SystemTimeToTzSpecificLocalTime; back :"
        f" FB_TzSpecificLocalTimeToSystemTime; t : TIMESTRUCT; END_VAR t :="
        f" STRING_TO_SYSTEMTIME('{utc:%Y-%m-%d-%H:%M:%S}.000'); there(in := t, tzInfo := z);"
        " back(in := there.out, tzInfo := z); END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    out = ran["there.out"]
    shown = datetime(*(out[f"w{part}"] for part in ("Year", "Month", "Day", "Hour", "Minute")))
    assert shown == local.replace(tzinfo=None, second=0)
    assert ran["there.bB"] == bool(local.fold)
    kind = 0 if winter is None else 2 if local.dst() else 1
    assert int(ran["there.eTzID"]) == kind
    if not local.fold:
        again = ran["back.out"]
        parts = [again[f"w{part}"] for part in ("Year", "Month", "Day", "Hour", "Minute")]
        assert datetime(*parts) == utc.replace(second=0, tzinfo=None)


def test_the_hour_that_comes_twice() -> None:
    begin = datetime(2024, 10, 27, 0, 0, tzinfo=UTC)
    wanted = [begin + timedelta(minutes=20 * step) for step in range(9)]
    berlin = [moment.astimezone(ZoneInfo("Europe/Berlin")) for moment in wanted]
    times = ", ".join(f"'{moment:%Y-%m-%d-%H:%M:%S}.000'" for moment in berlin)
    ran = Ran(
        "PROGRAM MAIN VAR z : ST_TimeZoneInformation := (bias := -60, daylightBias := -60,"
        f" standardDate := {_rule((10, 0, 5, 3))}, daylightDate := {_rule((3, 0, 5, 2))});"
        f" s : ARRAY [0..8] OF STRING(24) := [{times}]; n : INT; out : ARRAY [0..8] OF STRING(24);"
        " back : FB_TzSpecificLocalTimeToSystemTime; END_VAR"
        " back(in := STRING_TO_SYSTEMTIME(s[n]), tzInfo := z);"
        " out[n] := SYSTEMTIME_TO_STRING(back.out); n := n + 1; END_PROGRAM"
    ).cycle(9)
    assert list(ran["out"]) == [f"{moment:%Y-%m-%d-%H:%M:%S}.000" for moment in wanted]


def test_clocks_of_their_own() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR a : RTC_EX2; b : RTC; n : INT; t : TIMESTRUCT := (wYear := 2024,"
        " wMonth := 2, wDay := 28, wHour := 23, wMinute := 59, wSecond := 59, wMilliseconds"
        " := 990);"
        " END_VAR n := n + 1;"
        " a(EN := n > 1, PDT := t); b(EN := n > 1, PDT := DT#2024-02-28-23:59:59);"
        " END_PROGRAM"
    ).cycle(4)
    assert (ran["a.Q"], ran["a.CDT.wDay"], ran["a.CDT.wDayOfWeek"]) == (True, 29, 4)
    assert (ran["a.CDT.wHour"], ran["a.CDT.wMilliseconds"]) == (0, 10)
    assert (ran["b.Q"], ran["b.CDT"]) == (True, datetime(2024, 2, 28, 23, 59, 59))


@settings(max_examples=8)
@given(st.integers(0, 2**32 - 1))
def test_operating_hours_split_and_join_a_time(ms: int) -> None:
    ran = Ran(
        f"PROGRAM MAIN VAR t : TIME := T#{ms}MS; u : TIME; s : OTSTRUCT; END_VAR"
        " s := TIME_TO_OTSTRUCT(t); u := OTSTRUCT_TO_TIME(s); END_PROGRAM"
    ).cycle()
    parts = [ran[f"s.{name}"] for name in ("wWeek", "wDay", "wHour", "wMinute", "wSecond")]
    span = timedelta(milliseconds=ms)
    assert parts == [
        span.days // 7, span.days % 7, span.seconds // 3600, span.seconds // 60 % 60,
        span.seconds % 60,
    ]  # fmt: skip
    assert ran["s.wMilliseconds"] == ms % 1000
    assert ran["u"] == ran["t"]


def test_a_controller_takes_its_process_to_the_set_point() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR c : FB_BasicPID; y : LREAL; bad : FB_BasicPID; END_VAR"
        " c(fSetpointValue := 10, fActualValue := y, fCtrlCycleTime := 0.01, fKp := 2, fTn := 0.5,"
        " fTv := 0.02, fTd := 0.02); y := y + 0.01 * (c.fCtrlOutput - y) / 0.3;"
        " bad(fKp := 1); END_PROGRAM"
    ).cycle(600)
    assert ran["y"] == pytest.approx(10, abs=0.01)
    assert (ran["bad.nErrorStatus"], ran["bad.fCtrlOutput"]) == (1, 0)


def test_own_names_hide_those_of_libraries_but_for_who_names_the_library() -> None:
    ran = Ran(
        "FUNCTION F_ToASC : BYTE VAR_INPUT str : STRING; END_VAR F_ToASC := 1; END_FUNCTION"
        " TYPE TYPE_CLASS : (MINE := 7); END_TYPE"
        " PROGRAM MAIN VAR a, b : BYTE; c, d : DINT; END_VAR a := F_ToASC('A');"
        " b := Tc2_System.F_ToASC('A'); c := TYPE_CLASS.MINE;"
        " d := TO_DINT(__SYSTEM.TYPE_CLASS.TYPE_STRING); END_PROGRAM"
    ).cycle()
    values: tuple[Any, ...] = (ran["a"], ran["b"], ran["c"], ran["d"])
    assert values == (1, 65, 7, 16)


@settings(max_examples=8)
@given(value=st.uuids(), wrong=st.text("0123456789abcdefABCDEF-{}", max_size=36))
def test_identifiers_from_texts(value: UUID, wrong: str) -> None:
    text = str(value)
    ran = Ran(
        f"PROGRAM MAIN VAR a, b, c, d : GUID; s, r, w : STRING(40); END_VAR"
        f" a := STRING_TO_GUID('{text.upper()}'); s := GUID_TO_STRING(a);"
        f" b := REGSTRING_TO_GUID('{{{text}}}'); r := GUID_TO_REGSTRING(b);"
        f" c := STRING_TO_GUID('{wrong}'); w := GUID_TO_STRING(c);"
        f" d := REGSTRING_TO_GUID('{text}');"
        " END_PROGRAM"
    ).cycle()
    assert ran["s"] == text.upper()
    assert ran["r"] == f"{{{text.upper()}}}"
    try:
        expected = UUID(wrong) if len(wrong) == 36 else UUID(int=0)
        expected = expected if str(expected) == wrong.lower() else UUID(int=0)
    except ValueError:
        expected = UUID(int=0)
    assert ran["w"] == str(expected).upper()
    assert ran["d"]["Data1"] == 0
