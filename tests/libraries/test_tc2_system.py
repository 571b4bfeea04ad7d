"""Tc2_System: bits, characters, addresses, clocks, and files through the system service."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.plc.code.conftest import Ran


@settings(max_examples=7)
@given(value=st.integers(0, 2**32 - 1), bit=st.integers(0, 31), new=st.booleans())
def test_single_bits(value: int, bit: int, new: bool) -> None:
    ran = Ran(
        f"PROGRAM MAIN VAR v : DWORD := {value}; b : SINT := {bit}; s, c, x : DWORD; g : BOOL;"
        " END_VAR s := SETBIT32(v, b); c := CLEARBIT32(v, b); g := GETBIT32(v, b);"
        f" x := CSETBIT32(v, b, {str(new).upper()}); END_PROGRAM"
    ).cycle()
    one = 1 << bit
    assert (ran["s"], ran["c"], ran["g"]) == (value | one, value & ~one, bool(value & one))
    assert ran["x"] == (value | one if new else value & ~one)


def test_characters_versions_and_memory() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR a, e : BYTE; s, n : STRING; v : ST_LibVersion; lo, eq, hi : DINT;"
        " d, h, u : E_TcMemoryArea; p : POINTER TO LREAL; t, f : BOOL; flag : BOOL; END_VAR"
        " a := F_ToASC('Ax'); e := F_ToASC(''); s := F_ToCHR(66); n := F_ToCHR(0);"
        " v.iMajor := 3; v.iMinor := 6; lo := F_CmpLibVersion(v, 3, 7, 0, 0);"
        " eq := F_CmpLibVersion(v, 3, 6, 0, 0); hi := F_CmpLibVersion(v, 3, 5, 9, 9);"
        " d := F_CheckMemoryArea(ADR(a), 1); u := F_CheckMemoryArea(0, 1);"
        " p := __NEW(LREAL); h := F_CheckMemoryArea(p, 8); __DELETE(p);"
        " t := TestAndSet(flag); f := TestAndSet(flag); END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    assert (ran["a"], ran["e"], ran["s"], ran["n"]) == (65, 0, "B", "")
    assert (ran["lo"], ran["eq"], ran["hi"]) == (-1, 0, 1)
    assert [int(ran[name]) for name in "dhu"] == [1, 2, 0]
    assert (ran["t"], ran["f"], ran["flag"]) == (True, False, True)


@pytest.mark.parametrize(
    ("text", "ids"),
    [
        ("5.18.255.0.1.1", [5, 18, 255, 0, 1, 1]),
        ("", [0] * 6),
        ("1.2.3.4.5", [0] * 6),
        ("1.2.3.4.5.6.7", [0] * 6),
        ("1.2.3.4.5.256", [0] * 6),
        ("1..3.4.5.6", [0] * 6),
        ("1.2.3.4.5.x", [0] * 6),
        ("0001.2.3.4.5.6", [0] * 6),
    ],
)
def test_net_ids(text: str, ids: list[int]) -> None:
    ran = Ran(
        f"PROGRAM MAIN VAR a : T_AmsNetIdArr; s : T_AmsNetId; END_VAR"
        f" a := F_ScanAmsNetIds('{text}'); s := F_CreateAmsNetId(a); END_PROGRAM"
    ).cycle()
    assert (ran["a"], ran["s"]) == (ids, ".".join(map(str, ids)))


def test_random_numbers_are_those_of_their_seed() -> None:
    text = (
        "PROGRAM MAIN VAR a, b : DRAND; n : INT; v : ARRAY[0..199] OF LREAL; x : LREAL; END_VAR"
        " a(Seed := -7, Num => v[n]); b(Seed := 8, Num => x); n := n + 1; END_PROGRAM"
    )
    first, second = Ran(text).cycle(200), Ran(text).cycle(200)
    values = first["v"]
    assert values == second["v"]
    assert all(0 <= value < 1 for value in values)
    assert len(set(values)) == 200
    assert 0.4 < sum(values) / 200 < 0.6
    assert first["x"] not in values


def test_clocks() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR a, b : ULINT; s : GETSYSTEMTIME; END_VAR"
        " a := F_GetSystemTime(); b := F_GetTaskTime(); s(); END_PROGRAM",
        epoch=lambda: 1_000_000_000,
    ).cycle(2)
    expected = 116_444_736_000_000_000 + 10_000_000 + 200_000
    assert ran["a"] == ran["b"] == ran["s.timeHiDW"] << 32 | ran["s.timeLoDW"] == expected


STEPS = """
PROGRAM MAIN
VAR
    step : INT;
    dir : FB_CreateDir; opens : FB_FileOpen; puts : FB_FilePuts; writes : FB_FileWrite;
    closes : FB_FileClose; gets : FB_FileGets; seeks : FB_FileSeek; tells : FB_FileTell;
    reads : FB_FileRead; ends : FB_EOF; renames : FB_FileRename; deletes : FB_FileDelete;
    rmdir : FB_RemoveDir; loads : FB_FileLoad;
    errors : ARRAY [0..30] OF UDINT;
    line1, line2, line3 : T_MaxString;
    position : DINT; data : ARRAY [0..99] OF BYTE; got, got2 : UDINT; eof : ARRAY [0..4] OF BOOL;
    bytes : ARRAY [0..2] OF BYTE := [1, 2, 3];
END_VAR
{body}
END_PROGRAM
"""


def _steps(*calls: tuple[str, str, str]) -> str:
    """Each block with its inputs until it is not busy, then what is kept of it."""
    body = "CASE step OF\n"
    for number, (block, inputs, after) in enumerate(calls):
        body += (
            f"{number}: {block}({inputs}, bExecute := TRUE);\n IF NOT {block}.bBusy THEN\n"
            f" errors[{number}] := {block}.nErrId; {after}\n {block}(bExecute := FALSE);"
            " step := step + 1; END_IF\n"
        )
    return STEPS.format(body=body + "END_CASE")


def test_files_from_the_first_byte_to_the_last(tmp_path: Path) -> None:
    text = _steps(
        ("dir", "sPathName := 'logs'", ""),
        ("opens", "sPathName := 'logs/a.txt', nMode := FOPEN_MODEWRITE OR FOPEN_MODETEXT", ""),
        ("puts", "hFile := opens.hFile, sLine := 'first$Nsecond$N'", ""),
        ("writes", "hFile := opens.hFile, pWriteBuff := ADR(bytes), cbWriteLen := 3",
         "got := writes.cbWrite;"),
        ("closes", "hFile := opens.hFile", ""),
        ("opens", "sPathName := 'logs/a.txt', nMode := FOPEN_MODEREAD", ""),
        ("gets", "hFile := opens.hFile", "line1 := gets.sLine;"),
        ("tells", "hFile := opens.hFile", "position := tells.nSeekPos;"),
        ("gets", "hFile := opens.hFile", "line2 := gets.sLine;"),
        ("ends", "hFile := opens.hFile", "eof[0] := ends.bEOF;"),
        ("reads", "hFile := opens.hFile, pReadBuff := ADR(data), cbReadLen := 10",
         "got2 := reads.cbRead; eof[1] := reads.bEOF;"),
        ("ends", "hFile := opens.hFile", "eof[2] := ends.bEOF;"),
        ("gets", "hFile := opens.hFile", "eof[3] := gets.bEOF; line3 := gets.sLine;"),
        ("seeks", "hFile := opens.hFile, nSeekPos := -3, eOrigin := E_SeekOrigin.SEEK_END", ""),
        ("writes", "hFile := opens.hFile, pWriteBuff := ADR(bytes), cbWriteLen := 3", ""),
        ("closes", "hFile := opens.hFile", ""),
        ("closes", "hFile := opens.hFile", ""),
        ("renames", "sOldName := 'logs/a.txt', sNewName := 'logs/b.txt'", ""),
        ("opens", "sPathName := 'logs/a.txt', nMode := FOPEN_MODEREAD", ""),
        ("loads", "sPathName := 'logs/b.txt', pReadBuff := ADR(data), cbReadLen := 100",
         "position := position * 100 + TO_DINT(loads.cbRead);"),
        ("loads", "sPathName := 'none', pReadBuff := ADR(data), cbReadLen := 100", ""),
        ("rmdir", "sPathName := 'logs'", ""),
        ("deletes", "sPathName := 'logs/b.txt'", ""),
        ("rmdir", "sPathName := 'logs'", ""),
    )  # fmt: skip
    (tmp_path / "a.st").write_text(text, encoding="utf-8")
    shown = tmp_path / "shown"
    shown.mkdir()
    document = {"plc": [{"sources": "a.st"}], "system": {"root": "shown"}}
    station = Station(parse(document, "a.toml"), base=tmp_path)
    station.advance(1)
    plc = station.plcs[851]
    assert plc.failure == ""
    main: Any = plc.instance("MAIN")
    assert main["step"] == 24
    errors = {number: code for number, code in enumerate(main["errors"]) if code}
    assert errors.keys() == {14, 16, 18, 20, 21}
    assert (errors[16], errors[18], errors[20]) == (0x70C, 0x70C, 0x70C)
    assert (main["line1"], main["line2"], main["line3"]) == ("first\n", "second\n", "")
    assert (main["position"], main["got"], main["got2"]) == (616, 3, 3)
    assert list(main["eof"])[:4] == [False, True, True, True]
    assert bytes(main["data"])[:16] == b"first\nsecond\n\1\2\3"
    assert list(shown.iterdir()) == []


@pytest.mark.parametrize("name", ["../a.txt", "..$5Ca.txt", "/etc/hostname"])
def test_no_file_outside_of_the_root_is_opened(tmp_path: Path, name: str) -> None:
    text = _steps(
        ("opens", f"sPathName := '{name}', nMode := FOPEN_MODEREAD", ""),
        ("opens", f"sPathName := '{name}', nMode := FOPEN_MODEWRITE", ""),
        ("loads", f"sPathName := '{name}', pReadBuff := ADR(data), cbReadLen := 9", ""),
        ("deletes", f"sPathName := '{name}'", ""),
    )
    (tmp_path / "a.st").write_text(text, encoding="utf-8")
    (tmp_path / "a.txt").write_text("outside")
    (tmp_path / "shown").mkdir()
    document = {"plc": [{"sources": "a.st"}], "system": {"root": "shown"}}
    station = Station(parse(document, "a.toml"), base=tmp_path)
    station.advance(1)
    main: Any = station.plcs[851].instance("MAIN")
    assert main["step"] == 4
    assert all(list(main["errors"])[:4])
    assert (tmp_path / "a.txt").read_text() == "outside"


def test_without_a_folder_the_refusal_is_shown(tmp_path: Path) -> None:
    text = _steps(("opens", "sPathName := 'a.txt', nMode := FOPEN_MODEREAD", ""))
    (tmp_path / "a.st").write_text(text, encoding="utf-8")
    document = {"plc": [{"sources": "a.st"}]}
    station = Station(parse(document, "a.toml"), base=tmp_path)
    station.advance(0.1)
    main: Any = station.plcs[851].instance("MAIN")
    assert (main["step"], main["errors"][0]) == (1, 0x701)
    assert (main["opens"]["bError"], main["opens"]["hFile"]) == (True, 0)


def test_a_station_has_no_files_that_wait() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR status, first : SYS_FILE_STATUS; error : RTS_IEC_RESULT; shown : STRING;"
        " END_VAR status := SysFile.SysFileGetStatus(5); error := SysFileFlush(5);"
        " shown := CurrentVisu; END_PROGRAM"
    ).cycle()
    assert (ran.plc.failure, int(ran["status"]), int(ran["first"])) == ("", 1, 0)
    assert (ran["error"] > 0, ran["shown"]) == (True, "")


def test_older_event_logger_is_not_there() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR log : ADSLOGEVENT; event : TcEvent; raise, clean : BOOL; n : UDINT;"
        " END_VAR event.Flags := TCEVENTFLAG_LOG OR TCEVENTFLAG_SRCID; n := SIZEOF(event);"
        " event.StreamType := TCEVENTSTREAM_SIMPLE; event.Class := TCEVENTCLASS_ALARM;"
        " log(PORT := 110, Event := raise, EventConfigData := event, FbCleanup := clean);"
        " END_PROGRAM"
    ).cycle()
    main: Any = ran.plc.instance("MAIN")
    log = main.log
    assert (log.Err, log.EventConfigData.Flags, ran["n"]) == (False, 0x140, 88)
    main["raise"] = True
    ran.cycle()
    assert (log.Err, log.ErrId, log.EventState) == (True, 6, 0)
    main["clean"] = True
    ran.cycle()
    assert (log.Err, log.ErrId) == (False, 0)
