"""Channels and the variables of PLCs: which belong together, and what goes over in each cycle."""

import logging
from pathlib import Path
from typing import Any

import pytest

from achse.motion.channels.program_channel import ProgramChannel
from achse.motion.channels.states import InterpreterState, ProgramMode
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse
from achse.station.plcs.channel_links import channel_variables

TYPES = """
TYPE PLCTONC_NCICHANNEL_REF : STRUCT
  SkipLine : WORD; ItpOperationMode : WORD; MFuncGranted : WORD; reserved : WORD;
  ChnAxesOvr : UDINT; ChnSpindleOvr : UDINT; rest : ARRAY [1..112] OF BYTE;
END_STRUCT END_TYPE
TYPE NCTOPLC_NCICHANNEL_REF : STRUCT
  BlockNo : UDINT; FastMFuncMask : ARRAY [1..5] OF DWORD; HskMFuncNo : UINT; HskMFuncReq : WORD;
  HFuncValue : DINT; SpindleRpm : UINT; Tool : UINT; ChnState : DWORD;
  IntParams : ARRAY [0..3] OF UDINT; DoubleParams : ARRAY [0..3] OF LREAL; PathVelo : LREAL;
  LoadedProg : UDINT; ItpMode : WORD; ItpState : UINT; ErrorCode : UDINT; ChnId : UINT;
  GrpId : UINT; ItfVersion : UINT; reserved1 : UINT; ChnOperationState : UDINT;
  McsAxisIDs : ARRAY [0..7] OF USINT; AcsAxisIDs : ARRAY [0..7] OF USINT;
  rest : ARRAY [1..24] OF USINT;
END_STRUCT END_TYPE
TYPE NciChannelToPlc : STRUCT
  nJobNo : DWORD; nFastMFuncMask : ARRAY [1..5] OF DWORD; nHskMFuncNo : WORD; nHskMFuncReq : WORD;
  nHFuncValue : DINT; nSpindleRpm : WORD; nTool : WORD; rest : ARRAY [37..132] OF BYTE;
  nLoadedProg : DWORD; nItpMode : WORD; nItpState : WORD; nItpErrCode : WORD;
  rest2 : ARRAY [143..150] OF BYTE;
END_STRUCT END_TYPE
"""
MAIN = """
PROGRAM MAIN
VAR
  toChannel AT %Q* : PLCTONC_NCICHANNEL_REF;
  fromChannel AT %I* : NCTOPLC_NCICHANNEL_REF;
  X : AXIS_REF; Y : AXIS_REF; Z : AXIS_REF;
  axesOverride : UDINT := 1000000; mode : WORD; seen : UINT; confirm : BOOL := TRUE;
END_VAR
X.PlcToNc.ControlDWord.Enable := TRUE; X.PlcToNc.ControlDWord.FeedEnablePlus := TRUE;
X.PlcToNc.ControlDWord.FeedEnableMinus := TRUE; X.PlcToNc.Override := 1000000;
Y.PlcToNc := X.PlcToNc; Z.PlcToNc := X.PlcToNc;
toChannel.ChnAxesOvr := axesOverride;
toChannel.ItpOperationMode := mode;
IF fromChannel.HskMFuncReq > 0 THEN
  seen := fromChannel.HskMFuncNo;
  toChannel.MFuncGranted := BOOL_TO_WORD(confirm);
ELSE
  toChannel.MFuncGranted := 0;
END_IF
END_PROGRAM
"""


def _station(folder: Path, text: str = MAIN, channel: dict[str, Any] | None = None) -> Station:
    (folder / "a.st").write_text(TYPES + text, encoding="utf-8")
    (folder / "part.nc").write_text("N10 G1 X5 F6000\nN20 M8\n/1 N25 X7\nN30 X10 Y2\nM30")
    rule = {"number": 8, "handshake": "before"}
    document = {
        "plc": [{"sources": "a.st"}],
        "axis": [{"id": id, "name": name} for id, name in enumerate("XYZ", 1)],
        "channel": [{"id": 1, "programs": ".", "m": [rule], **(channel or {})}],
        "group": [{"id": 11, "channel": 1, "axes": [1, 2, 3]}],
    }
    return Station(parse(document, "a.toml"), base=folder)


def _channel(station: Station, number: int = 1) -> ProgramChannel:
    assert station.nc is not None
    channel = station.nc.channels.channel(number)
    assert isinstance(channel, ProgramChannel)
    return channel


def test_a_program_confirms_m_functions_by_its_structures_alone(tmp_path: Path) -> None:
    station = _station(tmp_path)
    main: Any = station.plcs[851].instance("MAIN")
    channel = _channel(station)
    station.advance(0.1)
    shown = main["fromChannel"]
    assert (shown["ChnId"], shown["GrpId"], shown["ItfVersion"]) == (1, 11, 2)
    assert list(shown["McsAxisIDs"])[:4] == [1, 2, 3, 0]
    assert shown["ChnState"] == 1, "a channel with an interpreter"
    assert channel.load("part.nc") == 0
    assert channel.start() == 0
    station.advance(0.05)
    assert main["fromChannel"]["ItpState"] == InterpreterState.WAITING
    assert main["fromChannel"]["PathVelo"] > 1.0
    station.advance(3.0)
    assert main["seen"] == 8
    assert channel.state is InterpreterState.READY
    assert station.nc is not None
    assert station.nc.axis(1).set_position == pytest.approx(10.0)


def test_what_the_program_gives_counts_as_long_as_it_runs(tmp_path: Path) -> None:
    station = _station(tmp_path)
    main: Any = station.plcs[851].instance("MAIN")
    channel = _channel(station)
    main["axesOverride"], main["confirm"] = 2_000_000, False
    main["mode"] = int(ProgramMode.SINGLE_BLOCK_INTERPRETER)
    main["toChannel"]["SkipLine"] = 2
    main["toChannel"]["ChnSpindleOvr"] = 250_000
    station.advance(0.05)
    assert (channel.override, channel.spindle_override) == (1_000_000, 250_000)
    assert channel.operation_mode is ProgramMode.SINGLE_BLOCK_INTERPRETER
    assert (channel.data.skip_mask, channel.granted) == (2, 0)
    # another client's mode stays, its override does not
    assert channel.set_operation_mode(0) == 0
    channel.override = 5
    station.advance(0.05)
    assert channel.operation_mode is ProgramMode.DEFAULT
    assert channel.override == 1_000_000
    station.plcs[851].stop()
    station.advance(0.05)
    assert (channel.override, channel.data.skip_mask) == (0, 0)


def test_an_impossible_mode_is_reported_and_changes_nothing(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    station = _station(tmp_path)
    main: Any = station.plcs[851].instance("MAIN")
    main["mode"] = 3
    with caplog.at_level(logging.WARNING, "achse.plc"):
        station.advance(0.05)
    assert _channel(station).operation_mode is ProgramMode.DEFAULT
    assert [text for text in caplog.messages if "no operation mode 0x3" in text]


def test_links_by_name_place_and_of_the_older_form(tmp_path: Path) -> None:
    text = (
        "PROGRAM MAIN VAR a AT %IB2000 : NCTOPLC_NCICHANNEL_REF; b AT %I* : NciChannelToPlc;"
        " c AT %QB3000 : PLCTONC_NCICHANNEL_REF; loose AT %Q* : PLCTONC_NCICHANNEL_REF;"
        " both : ARRAY [1..2] OF NCTOPLC_NCICHANNEL_REF; END_VAR c.SkipLine := 5; END_PROGRAM"
    )
    station = _station(tmp_path, text, {"plc": ["%IB2000", "851:main.B", "%QB3000"]})
    station.advance(0.05)
    main: Any = station.plcs[851].instance("MAIN")
    assert main["a"]["ChnId"] == 1
    channel = _channel(station)
    assert main["b"]["nItpState"] == channel.state
    assert (channel.data.skip_mask, channel.override) == (5, 0)
    structures = channel_variables(station.plcs[851].variables)
    assert {(each.name, each.to_plc, each.size) for each in structures} == {
        ("MAIN.a", True, 160),
        ("MAIN.b", True, 152),
        ("MAIN.c", False, 128),
        ("MAIN.loose", False, 128),
    }


@pytest.mark.parametrize(
    ("plc", "said"),
    [
        ("MAIN.toChanel", r"channel\[1\]\.plc: no variable .* did you mean 'MAIN\.toChannel'"),
        (["MAIN.toChannel", "MAIN.toChannel"], "linked to channel 1 already"),
        ("853:MAIN.toChannel", "expected a PLC before the colon"),
    ],
)
def test_a_wrong_link_is_reported_by_its_key(tmp_path: Path, plc: Any, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        _station(tmp_path, channel={"plc": plc})


def test_structures_without_a_channel_are_reported(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    text = (
        "PROGRAM MAIN VAR a AT %I* : NCTOPLC_NCICHANNEL_REF;"
        " b AT %I* : NCTOPLC_NCICHANNEL_REF; END_VAR END_PROGRAM"
    )
    with caplog.at_level(logging.WARNING, "achse.plc"):
        station = _station(tmp_path, text)
    assert [said for said in caplog.messages if "MAIN.a, MAIN.b: no channel" in said]
    station.advance(0.05)
    assert _channel(station).override == 1_000_000


def test_an_online_change_moves_the_links_or_drops_them(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    station = _station(tmp_path)
    station.advance(0.05)
    channel = _channel(station)
    assert channel.override == 1_000_000
    moved = MAIN.replace("VAR\n", "VAR first AT %Q* : LREAL; early AT %I* : DINT;\n", 1)
    (tmp_path / "a.st").write_text(TYPES + moved, encoding="utf-8")
    station.online_change(851)
    station.advance(0.05)
    main: Any = station.plcs[851].instance("MAIN")
    assert main["fromChannel"]["ChnId"] == 1
    assert channel.override == 1_000_000
    gone = "PROGRAM MAIN VAR fromChannel AT %I* : NCTOPLC_NCICHANNEL_REF; END_VAR END_PROGRAM"
    (tmp_path / "a.st").write_text(TYPES + gone, encoding="utf-8")
    with caplog.at_level(logging.WARNING, "achse.plc"):
        station.online_change(851)
    station.advance(0.05)
    assert channel.override == 0
    assert [said for said in caplog.messages if "toChannel".casefold() in said.casefold()]
