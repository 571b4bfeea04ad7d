"""Tc3_EventLogger in a station: what clients at the event logger's port and the log see."""

import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.station import Station
from achse.station.configuration.station_file import parse

CLASSES = """<T><DataType><Name GUID="{AC1249EC-7A00-4AA4-851B-9BA1B619868E}">Line</Name>
<DisplayName>Line events</DisplayName><EventId><Name Id="1">Jam</Name>
<DisplayName>jam at {0}, {1} parts</DisplayName><Severity>Error</Severity></EventId>
<EventId><Name Id="2">Hello</Name><DisplayName>hello</DisplayName><Severity>Info</Severity>
</EventId></DataType></T>"""
MAIN = """
PROGRAM MAIN
VAR
    step : INT;
    hello, none : FB_TcMessage;
    jam : FB_TcAlarm;
    source : FB_TcSourceInfo;
    results : ARRAY [0..19] OF HRESULT;
    raised, active : ARRAY [0..4] OF BOOL;
    state : ARRAY [0..4] OF TcEventConfirmationState;
    text, name : STRING(255);
    same, other, ready, cleared : BOOL;
    logger : FB_TcEventLogger;
    arguments : FB_TcArguments;
END_VAR
step := step + 1;
CASE step OF
1:
    results[0] := none.Send(0);
    cleared := logger.ClearLoggedEvents(0);
    results[1] := hello.CreateEx(TC_Events.Line.Hello, 0);
    results[2] := hello.Send(0);
    same := hello.EqualsToEventEntryEx(TC_EVENTS.Line.Hello);
    other := hello.EqualsToEventEntryEx(TC_EVENTS.Line.Jam);
2:
    source.sName := 'feeder';
    results[3] := jam.CreateEx(TC_EVENTS.Line.Jam, TRUE, source);
    jam.ipArguments.Clear().AddString('belt').AddDInt(7);
    results[4] := jam.Raise(0);
    results[5] := jam.Raise(0);
    raised[0] := jam.bRaised; active[0] := jam.bActive; state[0] := jam.eConfirmationState;
    ready := jam.RequestEventText(1033, text, SIZEOF(text));
    jam.RequestEventClassName(1033, name, SIZEOF(name));
3:
    results[6] := jam.Clear(0, FALSE);
    results[7] := jam.Clear(0, FALSE);
    raised[1] := jam.bRaised; active[1] := jam.bActive;
4:
    results[8] := jam.Confirm(0);
    results[9] := jam.Confirm(0);
    active[2] := jam.bActive; state[2] := jam.eConfirmationState;
    arguments.AddString('gate').AddBool(TRUE);
    results[10] := logger.SendMessageEx(TC_EVENTS.Line.Jam, source, 0, arguments);
END_CASE
END_PROGRAM
"""


@pytest.fixture
def station(tmp_path: Path) -> Station:
    (tmp_path / "a.st").write_text(MAIN, encoding="utf-8")
    (tmp_path / "a.tsproj").write_text(CLASSES, encoding="utf-8")
    document = {"plc": [{"sources": "a.st"}]}
    return Station(parse(document, "a.toml"), base=tmp_path)


def test_messages_and_alarms(station: Station, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO, "achse.logger")
    station.advance(0.2)
    plc = station.plcs[851]
    assert plc.failure == ""
    main: Any = plc.instance("MAIN")
    refused = 0x98110712 - 2**32
    assert list(main["results"])[:11] == [
        refused, 0, 0, 0, 0, refused, 0, refused, 0, refused, 0,
    ]  # fmt: skip
    assert list(main["raised"])[:2] == [True, False]
    assert list(main["active"])[:3] == [True, True, False]
    assert [int(state) for state in main["state"]][:3] == [2, 0, 3]
    assert (main["same"], main["other"], main["ready"]) == (True, False, True)
    assert main["cleared"]
    assert (main["text"], main["name"]) == ("jam at belt, 7 parts", "Line events")
    shown = [(record.levelname, record.getMessage()) for record in caplog.records]
    assert shown == [
        ("INFO", "TCPLC (port 851): MAIN.hello: hello"),
        ("ERROR", "TCPLC (port 851): raised feeder: jam at belt, 7 parts"),
        ("ERROR", "TCPLC (port 851): cleared feeder: jam at belt, 7 parts"),
        ("ERROR", "TCPLC (port 851): confirmed feeder: jam at belt, 7 parts"),
        ("ERROR", "TCPLC (port 851): feeder: jam at gate, TRUE parts"),
    ]


def test_a_client_of_the_event_logger_sees_them(
    station: Station, client_of: Callable[..., Any]
) -> None:
    client = client_of(station.router, 110)
    client.subscribe(1, 0xFFFF, 255)
    station.advance(0.3)
    texts = [data[36:].rstrip(b"\0").decode() for _, data in client.samples()]
    assert "raised feeder: jam at belt, 7 parts" in texts
