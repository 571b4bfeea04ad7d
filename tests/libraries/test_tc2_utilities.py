"""Tc2_Utilities: formats, numbers as text, texts by address, times, ring buffers."""

from collections import deque
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.plc.code.conftest import Ran

VARIABLES = (
    "i : INT := 130; n : INT := -5; b : BYTE := 200; w : WORD := 16#ABCD; l : LINT := -9;"
    " u : ULINT := 16#FFFFFFFFFFFFFFFF; f : LREAL := 2.5; r : REAL := -0.1; t : BOOL := TRUE;"
    " s : STRING(20) := 'abc'; e : STRING; c : BYTE := 65; big : LREAL := 1E300; z : INT;"
    " five : UINT := 5; nil : T_Arg;"
)


@pytest.fixture(scope="module")
def formatter() -> Ran:
    return Ran(
        f"PROGRAM MAIN VAR f1 : FB_FormatString; sFormat : T_MaxString; a, d, g : INT; {VARIABLES}"
        " args : ARRAY[0..15] OF T_Arg; END_VAR"
        " args[0] := F_INT(i); args[1] := F_INT(n); args[2] := F_BYTE(b); args[3] := F_WORD(w);"
        " args[4] := F_LINT(l); args[5] := F_ULINT(u); args[6] := F_LREAL(f);"
        " args[7] := F_REAL(r); args[8] := F_BOOL(t); args[9] := F_STRING(s);"
        " args[10] := F_STRING(e); args[11] := F_BYTE(c); args[12] := F_LREAL(big);"
        " args[13] := F_INT(z); args[14] := F_UINT(five); args[15] := nil;"
        " f1(sFormat := sFormat, arg1 := args[a], arg2 := args[d], arg3 := args[g]); END_PROGRAM"
    )


NAMES = ["i", "n", "b", "w", "l", "u", "f", "r", "t", "s", "e", "c", "big", "z", "five", ""]


def _formatted(ran: Ran, text: str, *names: str) -> tuple[str, int]:
    main: Any = ran.plc.instance("MAIN")
    main["sFormat"] = text
    for place, name in zip("adg", (*names, "", "", ""), strict=False):
        main[place] = NAMES.index(name)
    ran.cycle()
    assert ran.plc.failure == ""
    assert ran["f1.bError"] is (ran["f1.nErrId"] != 0)
    return ran["f1.sOut"], ran["f1.nErrId"]


@pytest.mark.parametrize(
    ("text", "names", "result"),
    [
        ("plain", "", "plain"),
        ("", "", ""),
        ("100 %%", "", "100 %"),
        ("%+.10d", "i", "+0000000130"),
        ("%d|%d|%d", "n i z", "-5|130|0"),
        ("%5d|%-5d|%05d", "n n n", "   -5|-5   |-0005"),
        ("% d|%+d", "i i", " 130|+130"),
        ("%x|%X|%#x", "w w w", "abcd|ABCD|16#abcd"),
        ("%x|%u", "n n", "fffb|65531"),
        ("%b|%o|%d", "b b b", "11001000|310|200"),
        ("%d|%u", "l u", "-9|18446744073709551615"),
        ("%d", "t", "1"),
        ("%f|%.1f|%.0f", "f f f", "2.500000|2.5|3"),
        ("%10.2f|%-8.1f|%08.2f", "f r r", "      2.50|-0.1    |-0000.10"),
        ("%x", "r", "bdcccccd"),
        ("[%s|%5s|%-5s]", "s s s", "[abc|  abc|abc  ]"),
        ("%.2s|%.9s|%s", "s s e", "ab|abc|"),
        ("%05s", "s", "  abc"),
        ("%c%3c", "c c", "A  A"),
        ("%*d|%s", "i five s", "  130|abc"),
        ("%.*d", "i five", "00130"),
        ("%.d|%.3d", "z z", "0|000"),
    ],
)
def test_formats(formatter: Ran, text: str, names: str, result: str) -> None:
    assert _formatted(formatter, text, *names.split()) == (result, 0)


@pytest.mark.parametrize(
    ("text", "names", "error"),
    [
        ("%", "i", 0x11),
        ("%d %", "i", 0x12),
        ("%5%", "i", 0x11),
        ("%**d", "i five", 0x21),
        ("%256d", "i", 0x41),
        ("%*d", "i w", 0x41),
        ("%.256d", "i", 0x81),
        ("%5+d", "i", 0x101),
        ("%*5d", "i five", 0x201),
        ("%.1.d", "i", 0x401),
        ("%i", "i", 0x801),
        ("%d%e", "i i", 0x802),
        ("%s", "i", 0x1001),
        ("%d", "s", 0x1001),
        ("%d", "f", 0x1001),
        ("%f", "i", 0x1001),
        ("%c", "i", 0x1001),
        ("%*d", "i n", 0x1001),
        ("%d", "", 0x4001),
        ("%d%d", "i", 0x4002),
        ("%*d", "i", 0x4001),
        ("%200d%200d", "i i", 0x8002),
        ("%f", "big", 0x8001),
    ],
)
def test_what_is_wrong_in_a_format(formatter: Ran, text: str, names: str, error: int) -> None:
    result = _formatted(formatter, text, *names.split())
    if error & 0x8000:  # the argument was taken already
        assert (result[0], result[1] & ~0xF) == ("", 0x8000)
    else:
        assert result == ("", error)


def test_a_pointer_to_nothing_is_reported() -> None:
    ran = Ran("PROGRAM MAIN VAR f : FB_FormatString2; END_VAR f(nDstSize := 8); END_PROGRAM")
    assert ran.cycle()["f.nErrId"] == 0x10000


def test_numbers_as_text() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR h1, h2, h3, b, o, d, r1, r2, r3, r4, inf : T_MaxString; x : WORD;"
        " y : DWORD; v : LREAL; END_VAR"
        " h1 := WORD_TO_HEXSTR(16#ABCD, 2, TRUE); h2 := BYTE_TO_HEXSTR(15, 4, FALSE);"
        " h3 := DWORD_TO_HEXSTR(0, 0, FALSE); b := BYTE_TO_BINSTR(5, 8);"
        " o := WORD_TO_OCTSTR(64, 0); d := LWORD_TO_DECSTR(16#FFFFFFFFFFFFFFFF, 0);"
        " r1 := LREAL_TO_FMTSTR(-2.345, 2, FALSE); r2 := LREAL_TO_FMTSTR(2.5, 0, TRUE);"
        " r3 := LREAL_TO_FMTSTR(0.0, 0, TRUE); r4 := LREAL_TO_FMTSTR(-0.001, 2, FALSE);"
        " MEMSET(ADR(v), 0, 8); y := 16#7FF00000; MEMCPY(ADR(v) + 4, ADR(y), 4);"
        " inf := LREAL_TO_FMTSTR(v, 2, TRUE); x := HOST_TO_BE16(16#1234);"
        " y := HOST_TO_BE32(16#12345678); END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    assert [ran[name] for name in ("h1", "h2", "h3", "b")] == ["abcd", "000F", "", "00000101"]
    assert (ran["o"], ran["d"]) == ("100", str(2**64 - 1))
    assert [ran[f"r{n}"] for n in (1, 2, 3, 4)] == ["-2.34", "3", "0", "0.00"]
    assert (ran["inf"], ran["x"], ran["y"]) == ("#INF", 0x3412, 0x78563412)


@pytest.fixture(scope="module")
def by_address() -> Ran:
    return Ran(
        "PROGRAM MAIN VAR a, b : STRING; c, g : STRING(40); size : UDINT;"
        " ok : BOOL; at1, n : UDINT; l, r, u, d : T_MaxString; END_VAR"
        " ok := CONCAT2(ADR(a), ADR(b), ADR(c), size); at1 := FIND2(ADR(a), ADR(b));"
        " g := a; CONCAT2(ADR(g), ADR(b), ADR(g), SIZEOF(g)); n := LEN2(ADR(g));"
        " l := F_LTrim(a); r := F_RTrim(a); u := F_ToUCase(a); d := F_ToLCase(u); END_PROGRAM"
    )


def _with(ran: Ran, **values: Any) -> Ran:
    """Run a cycle with these variables."""
    main: Any = ran.plc.instance("MAIN")
    for name, value in values.items():
        main[name] = value
    return ran.cycle()


@settings(max_examples=8)
@given(
    first=st.text("ab ", max_size=12),
    second=st.text("ab ", max_size=12),
    size=st.integers(1, 30),
)
def test_texts_by_address(by_address: Ran, first: str, second: str, size: int) -> None:
    ran = _with(by_address, a=first, b=second, size=size)
    assert ran.plc.failure == ""
    both = first + second
    assert (ran["ok"], ran["c"]) == (len(both) < size, both[: size - 1])
    assert ran["at1"] == (first.find(second) + 1 if second else 0)
    assert (ran["g"], ran["n"]) == (both, len(both))
    assert (ran["l"], ran["r"]) == (first.lstrip(" "), first.rstrip(" "))
    assert (ran["u"], ran["d"]) == (first.upper(), first)


UTF8 = """PROGRAM MAIN
VAR
    {attribute 'TcEncoding' := 'UTF-8'} sA : STRING(40) := sLiteral_TO_UTF8('ä€');
    {attribute 'TcEncoding' := 'UTF-8'} sB : STRING(40) := wsLiteral_TO_UTF8("ä€Ω");
    sRaw : STRING(40) := Tc2_Utilities.wsLiteral_TO_UTF8("Ω");
    {attribute 'TcEncoding' := 'UTF-8'} sC : STRING(40);
    {attribute 'TcEncoding' := 'UTF-8'} sD : STRING(40);
    sPlain : STRING(40);
END_VAR
sC := sLiteral_TO_UTF8('ä€');
sD := wsLiteral_TO_UTF8("ä€Ω");
sPlain := sD;
END_PROGRAM"""


@pytest.mark.parametrize("executed", [False, True])
def test_literals_in_utf_8(executed: bool) -> None:
    """As initial values and in bodies; a STRING that is not said to be UTF-8 has the same bytes."""
    ran = Ran(UTF8)
    assert (ran["sA"], ran["sB"], ran["sRaw"]) == ("ä€", "ä€Ω", "Î©")
    if executed:
        ran.cycle()
        assert (ran["sC"], ran["sD"]) == ("ä€", "ä€Ω")
        assert ran["sPlain"].encode("cp1252") == "ä€Ω".encode()


@pytest.fixture(scope="module")
def there_and_back() -> Ran:
    return Ran(
        "PROGRAM MAIN VAR w : WSTRING(40); back : WSTRING(40); size : UDINT;"
        " {attribute 'TcEncoding' := 'UTF-8'} u : STRING(50); s : STRING(50); again : STRING(60);"
        " guard : UDINT := 7; ok, b2, b3, b4 : BOOL; END_VAR"
        " ok := WSTRING_TO_UTF8(ADR(u), ADR(w), size);"
        " b2 := UTF8_TO_WSTRING(ADR(back), ADR(u), SIZEOF(back));"
        " b3 := UTF8_TO_STRING(ADR(s), ADR(u), SIZEOF(s));"
        " b4 := STRING_TO_UTF8(ADR(again), ADR(s), SIZEOF(again)); END_PROGRAM"
    )


@example(text="\x7f\x80\u07ff\u0800\uffff\U00010000\U0010ffff", size=50)
@given(
    text=st.text(
        st.characters(codec="utf-8", exclude_characters='"$\0', exclude_categories=["Cs", "Cc"]),
        max_size=12,
    ),
    size=st.integers(1, 50),
)
def test_texts_to_utf_8_and_back(there_and_back: Ran, text: str, size: int) -> None:
    ran = _with(there_and_back, w=text, size=size)
    assert ran.plc.failure == ""
    end = text
    while len(end.encode()) >= size:
        end = end[:-1]
    assert (ran["ok"], ran["u"], ran["back"]) == (end == text, end, end)
    assert ran["s"].encode("cp1252", "replace") == end.encode("cp1252", "replace")
    assert (ran["b2"], ran["b3"], ran["b4"], ran["guard"]) == (True, True, True, 7)


@pytest.mark.parametrize(
    "data",
    [b"\x80", b"a\xff", b"\xc3", b"\xe2\x82", b"\xc0\x80", b"\xed\xa0\x80", b"\xf5\x80\x80\x80"],
)
def test_what_is_not_utf_8(data: bytes) -> None:
    """It is U+FFFD, and nothing behind the text is read."""
    ran = Ran(
        "PROGRAM MAIN VAR a : ARRAY [0..9] OF BYTE; w : WSTRING(9); s : STRING(2); b : BOOL;"
        " END_VAR b := UTF8_TO_WSTRING(ADR(w), ADR(a), SIZEOF(w));"
        " UTF8_TO_STRING(ADR(s), ADR(a), 3); END_PROGRAM"
    )
    main: Any = ran.plc.instance("MAIN")
    for index, value in enumerate(data):
        main["a"][index] = value
    ran.cycle()
    assert (ran.plc.failure, ran["b"]) == ("", True)
    assert "\ufffd" in ran["w"]
    assert ran["s"].endswith("?")


TIMES = (
    "PROGRAM MAIN VAR t, back : ULINT; s, again : TIMESTRUCT; text : STRING(24); f : T_FILETIME;"
    " d : DT; END_VAR"
    " s := FILETIME64_TO_SYSTEMTIME(t); back := SYSTEMTIME_TO_FILETIME64(s);"
    " text := SYSTEMTIME_TO_STRING(s); again := STRING_TO_SYSTEMTIME(text);"
    " f := SYSTEMTIME_TO_FILETIME(s); d := SYSTEMTIME_TO_DT(s); END_PROGRAM"
)


@pytest.fixture(scope="module")
def times() -> Ran:
    return Ran(TIMES)


@given(moment=st.datetimes(datetime(1601, 1, 1), datetime(9000, 1, 1)))
def test_dates_are_those_of_the_calendar(times: Ran, moment: datetime) -> None:
    moment = moment.replace(microsecond=moment.microsecond // 1000 * 1000)
    filetime = (moment - datetime(1601, 1, 1)) // timedelta(microseconds=1) * 10
    main: Any = times.plc.instance("MAIN")
    main["t"] = filetime
    times.cycle()
    assert times.plc.failure == ""
    days = list(times["s"].values())
    assert days == [
        *(moment.year, moment.month, moment.isoweekday() % 7, moment.day),
        *(moment.hour, moment.minute, moment.second, moment.microsecond // 1000),
    ]
    assert times["back"] == filetime
    assert times["text"] == moment.strftime(f"{moment.year:04}-%m-%d-%H:%M:%S.") + (
        f"{moment.microsecond // 1000:03}"
    )
    assert times["again"] == times["s"]
    assert times["f"] == {
        "dwLowDateTime": filetime & 0xFFFF_FFFF,
        "dwHighDateTime": filetime >> 32,
    }
    seconds = int(moment.replace(tzinfo=UTC).timestamp())
    assert times["d"] == datetime(1970, 1, 1) + timedelta(
        seconds=seconds if 0 <= seconds < 1 << 32 else 0
    )


def test_what_is_not_a_date_is_0() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR s : TIMESTRUCT; a, b : ULINT := 1; END_VAR"
        " a := SYSTEMTIME_TO_FILETIME64(s); s.wYear := 2024; s.wMonth := 13; s.wDay := 1;"
        " b := SYSTEMTIME_TO_FILETIME64(s); END_PROGRAM"
    ).cycle()
    assert (ran["a"], ran["b"]) == (0, 0)


RING = (
    "PROGRAM MAIN VAR r : FB_MemRingBuffer; buf : ARRAY[0..29] OF BYTE; guard : DWORD := 16#55;"
    " w, g : ARRAY[0..39] OF BYTE; what : INT; n, room : UDINT; END_VAR"
    " CASE what OF"
    " 1: r.A_AddTail(pWrite := ADR(w), cbWrite := n, pBuffer := ADR(buf), cbBuffer := 30);"
    " 2: r.A_GetHead(pRead := ADR(g), cbRead := room, pBuffer := ADR(buf), cbBuffer := 30);"
    " 3: r.A_RemoveHead(pRead := ADR(g), cbRead := room, pBuffer := ADR(buf), cbBuffer := 30);"
    " 4: r.A_Reset(); END_CASE END_PROGRAM"
)


@settings(max_examples=10)
@given(
    st.lists(
        st.tuples(st.sampled_from([1, 1, 2, 3, 3, 4]), st.integers(0, 40), st.integers(0, 40)),
        max_size=30,
    )
)
def test_a_ring_buffer_is_a_queue(steps: list[tuple[int, int, int]]) -> None:
    ran = Ran(RING)
    main: Any = ran.plc.instance("MAIN")
    queue: deque[list[int]] = deque()
    for number, (what, size, room) in enumerate(steps):
        record = [(number + index) % 256 for index in range(40)]
        main["what"], main["n"], main["room"], main["w"] = what, size, room, record
        ran.cycle()
        assert ran.plc.failure == ""
        used = sum(4 + len(one) for one in queue)
        ok, count = False, 0
        if what == 1:
            ok = used + 4 + size <= 30
            if ok:
                queue.append(record[:size])
                count = size
        elif what == 4:
            ok = True
            queue.clear()
        elif queue:
            ok, count = len(queue[0]) <= room, len(queue[0])
            if ok:
                assert ran["g"][:count] == queue[0]
                if what == 3:
                    queue.popleft()
        assert (ran["r.bOk"], ran["r.nCount"], ran["r.cbReturn"]) == (ok, len(queue), count)
        assert ran["r.cbSize"] == sum(4 + len(one) for one in queue)
        assert ran["guard"] == 0x55


def test_the_time_of_day_is_queried_and_counts_in_between(tmp_path: Path) -> None:
    (tmp_path / "a.st").write_text(
        "PROGRAM MAIN VAR n : NT_GetTime; t, far : FB_LocalSystemTime; on : BOOL := TRUE; END_VAR"
        " n(START := TRUE); t(bEnable := on, dwCycle := 1);"
        " far(sNetID := '9.9.9.9.1.1', bEnable := TRUE); END_PROGRAM",
        encoding="utf-8",
    )
    epoch = int(datetime(2024, 2, 29, 23, 59, 59, tzinfo=UTC).timestamp()) * 10**9
    station = Station(
        parse({"plc": [{"sources": "a.st"}]}, "a.toml"), base=tmp_path, epoch_ns=epoch
    )
    main: Any = station.plcs[851].instance("MAIN")
    station.advance(0.01)
    assert (main["n"]["BUSY"], main["t"]["bValid"]) == (True, False)
    station.advance(0.01)
    assert (main["n"]["BUSY"], main["n"]["ERR"]) == (False, False)
    assert main["n"]["TIMESTR"]["wYear"] == 2024
    assert (main["t"]["bValid"], int(main["t"]["tzID"])) == (True, 1)
    station.advance(3.98)
    assert station.plcs[851].failure == ""
    time = main["t"]["systemTime"]
    moment = [time[f"w{name}"] for name in ("Month", "Day", "Hour", "Minute", "Second")]
    assert moment == [3, 1, 0, 0, 3]
    assert (time["wMilliseconds"], time["wDayOfWeek"]) == (0, 5)
    assert main["far"]["bValid"] is False
    main["on"] = False
    station.advance(0.05)
    assert (main["t"]["bValid"], int(main["t"]["tzID"])) == (False, -1)


def test_hexadecimal_digits_have_a_value() -> None:
    source = """PROGRAM MAIN VAR i : INT; one : STRING(1); v, w : ARRAY [0..255] OF BYTE; END_VAR
FOR i := 0 TO 255 DO
    one[0] := TO_BYTE(i); v[i] := HEXASCNIBBLE_TO_BYTE(one[0]); w[i] := HEXCHRNIBBLE_TO_BYTE(one);
END_FOR END_PROGRAM"""
    ran = Ran(source).cycle()
    digits = "0123456789abcdefABCDEF"
    expected = [int(chr(code), 16) if chr(code) in digits else 255 for code in range(256)]
    assert list(ran["v"]) == list(ran["w"]) == expected
