"""Tc2_Utilities: what public projects use besides formats, texts and times."""

import math
import struct
from binascii import crc_hqx
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.plc.code.conftest import Ran

WIDE = st.integers(0, (1 << 64) - 1)


@pytest.fixture(scope="module")
def values() -> Ran:
    return Ran(
        "PROGRAM MAIN VAR i : INT := -7; l : LREAL := 2.5; s : STRING := 'abc'; t : TIME := T#3S;"
        " b : BOOL := TRUE; p : POINTER TO INT;"
        " i2, none : INT; l2 : LREAL; s2 : STRING; t2 : TIME; b2 : BOOL; END_VAR"
        " i2 := PINT_TO_INT(ADR(i)); none := PINT_TO_INT(p); l2 := PLREAL_TO_LREAL(ADR(l));"
        " s2 := PSTRING_TO_STRING(ADR(s)); t2 := Tc2_Utilities.PTIME_TO_TIME(ADR(t));"
        " b2 := PBOOL_TO_BOOL(ADR(b)); END_PROGRAM"
    ).cycle()


@pytest.mark.parametrize(
    ("name", "value"),
    [("i2", -7), ("none", 0), ("l2", 2.5), ("s2", "abc"), ("b2", True)],
)
def test_values_by_address(values: Ran, name: str, value: object) -> None:
    assert values.plc.failure == ""
    assert values[name] == value


@pytest.fixture(scope="module")
def halves() -> Ran:
    return Ran(
        "PROGRAM MAIN VAR a, b : T_ULARGE_INTEGER; sum, difference, product : T_ULARGE_INTEGER;"
        " quotient, rest, low, high, both, any, one, none, wide, left, right : T_ULARGE_INTEGER;"
        " order : DINT; turned, back : ULINT; zero : BOOL; END_VAR"
        " sum := UInt64Add64(a, b); difference := UInt64Sub64(a, b); product := UInt64Mul64(a, b);"
        " order := UInt64Cmp64(a, b); turned := HOST_TO_BE64EX(WHOLE_OF_ULARGE(a));"
        " quotient := UInt64Div64(a, b); rest := UInt64Mod64(a, b); low := UInt64Min(a, b);"
        " high := UInt64Max(a, b); both := UInt64And(a, b); any := UInt64Or(a, b);"
        " one := UInt64Xor(a, b); none := UInt64Not(a); left := UInt64Shl(a, 5);"
        " wide := UInt32x32To64(a.dwHighPart, b.dwLowPart); right := UInt64Shr(a, 5);"
        " zero := UInt64isZero(b) AND ULARGE_TO_ULINT(ULINT_TO_ULARGE(turned)) = turned;"
        " back := BE64_TO_HOSTEX(turned); END_PROGRAM"
    )


@given(a=WIDE, b=WIDE)
@settings(max_examples=30, deadline=None)
def test_numbers_in_two_halves(halves: Ran, a: int, b: int) -> None:
    main: Any = halves.plc.instance("MAIN")
    for name, value in (("a", a), ("b", b)):
        main[name].dwLowPart = value & 0xFFFFFFFF
        main[name].dwHighPart = value >> 32
    halves.cycle()
    expected = {"sum": a + b, "difference": a - b, "product": a * b, "low": min(a, b)}
    expected |= {"high": max(a, b), "both": a & b, "any": a | b, "one": a ^ b, "none": ~a}
    expected |= {"quotient": a // b if b else 0, "rest": a % b if b else 0, "left": a << 5}
    expected |= {"wide": (a >> 32) * (b & 0xFFFFFFFF), "right": a >> 5}
    for name, value in expected.items():
        number = halves[name]
        assert number["dwHighPart"] << 32 | number["dwLowPart"] == value % (1 << 64)
    assert halves["order"] == (a > b) - (a < b)
    assert halves["turned"].to_bytes(8, "little") == a.to_bytes(8, "big")
    assert (halves["back"], halves["zero"]) == (a, b == 0)


@pytest.mark.parametrize(
    ("bias", "utc", "precision", "text"),
    [
        (0, False, 3, "2024-02-29T01:02:03.045+00:00"),
        (-90, False, 0, "2024-02-29T01:02:03+01:30"),
        (300, False, 9, "2024-02-29T01:02:03.045000000-05:00"),
        (0, True, 1, "2024-02-29T01:02:03.0Z"),
    ],
)
def test_iso_8601(bias: int, utc: bool, precision: int, text: str) -> None:
    ran = Ran(
        "PROGRAM MAIN VAR t : TIMESTRUCT := (wYear := 2024, wMonth := 2, wDay := 29, wHour := 1,"
        " wMinute := 2, wSecond := 3, wMilliseconds := 45); s : STRING(39); END_VAR"
        f" s := SYSTEMTIME_TO_ISO8601(t, {bias}, {utc}, {precision}); END_PROGRAM"
    ).cycle()
    assert ran["s"] == text


@pytest.mark.parametrize("value", [0.0, -1.5, math.inf, -math.inf, math.nan])
def test_what_is_a_number_in_single_precision(value: float) -> None:
    (bits,) = struct.unpack("<I", struct.pack("<f", value))
    ran = Ran(
        "PROGRAM MAIN VAR p : POINTER TO DWORD; x : REAL; nan, finite : BOOL; END_VAR"
        f" p := ADR(x); p^ := {bits}; nan := RealIsNaN(x); finite := RealIsFinite(x); END_PROGRAM"
    ).cycle()
    assert (ran["nan"], ran["finite"]) == (math.isnan(value), math.isfinite(value))


def _symbol(folder: Path, name: str) -> Any:
    (folder / "a.st").write_text(
        "TYPE ST_A : STRUCT a : INT; END_STRUCT END_TYPE\n"
        "PROGRAM MAIN VAR\n"
        " ask : PLC_ReadSymInfoByName;\n"
        " stValue : ST_A; // what it means\n"
        "END_VAR\n"
        f"ask(PORT := 851, SYMNAME := '{name}', START := TRUE); END_PROGRAM",
        encoding="utf-8",
    )
    station = Station(parse({"plc": [{"sources": "a.st"}]}, "a.toml"), base=folder)
    station.advance(0.2)
    assert station.plcs[851].failure == ""
    return station.plcs[851].instance("MAIN")["ask"]


def test_what_a_plc_says_of_a_symbol(tmp_path: Path) -> None:
    ask = _symbol(tmp_path, "MAIN.stValue")
    assert (ask.BUSY, ask.ERR, ask.SYMINFO.byteSize) == (False, False, 2)
    assert ask.SYMINFO.adsDataType == 65
    assert ask.SYMINFO.symDataType == "ST_A"
    assert ask.SYMINFO.symComment.strip() == "what it means"


def test_a_symbol_that_is_not_there(tmp_path: Path) -> None:
    ask = _symbol(tmp_path, "MAIN.nothing")
    assert (ask.BUSY, ask.ERR, ask.ERRID) == (False, True, 0x710)


@pytest.fixture(scope="module")
def sums() -> Ran:
    return Ran(
        "PROGRAM MAIN VAR data : ARRAY [0..9] OF BYTE; n : UDINT; first, whole, parts : WORD;"
        " arg : T_Arg := (cbLen := 7); kind : INT; END_VAR"
        " whole := F_DATA_TO_CRC16_CCITT(ADR(data), n, first);"
        " parts := F_DATA_TO_CRC16_CCITT(ADR(data[1]), MAX(n, 1) - 1,"
        " SEL(n = 0, F_BYTE_TO_CRC16_CCITT(data[0], first), first));"
        " arg := EMPTY_ARG_VALUE; kind := arg.eType; END_PROGRAM"
    )


@given(data=st.binary(max_size=10), first=st.sampled_from([0, 0xFFFF]) | st.integers(0, 0xFFFF))
@settings(max_examples=30, deadline=None)
def test_crc_16_of_bytes_at_once_and_one_after_the_other(
    sums: Ran, data: bytes, first: int
) -> None:
    main: Any = sums.plc.instance("MAIN")
    main["data"], main["n"], main["first"] = list(data.ljust(10, b"x")), len(data), first
    sums.cycle()
    assert sums.plc.failure == ""
    assert sums["whole"] == sums["parts"] == crc_hqx(data, first)
    assert (sums["arg"]["cbLen"], sums["arg"]["pData"], sums["kind"]) == (0, 0, 0)
