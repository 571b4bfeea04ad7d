"""Tc3_EventLogger: logged events are exported into a file and cleared, alarms by filters."""

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.station import Station
from achse.station.configuration.station_file import parse

CLASSES = """<T><DataType><Name GUID="{AC1249EC-7A00-4AA4-851B-9BA1B619868E}">Line</Name>
<DisplayName>Line events</DisplayName><EventId><Name Id="1">Jam</Name>
<DisplayName>jam; at "{0}"</DisplayName><Severity>Error</Severity></EventId>
<EventId><Name Id="2">Hello</Name><DisplayName>hello</DisplayName><Severity>Info</Severity>
</EventId></DataType></T>"""
SETUP = """
PROGRAM MAIN
VAR
    step : INT;
    hello : FB_TcMessage;
    jam, copy : FB_TcAlarm;
    logger : FB_TcEventLogger;
    source : FB_TcSourceInfo;
    filter : FB_TcEventFilter;
    csv : FB_TcEventCsvExportSettings;
    clearing : FB_TcClearLoggedEventsSettings;
    done, failed, cleared : BOOL;
    hr : HRESULT;
    results : ARRAY [0..9] OF HRESULT;
    flags : ARRAY [0..9] OF BOOL;
END_VAR
step := step + 1;
IF step = 1 THEN
    source.sName := 'feeder';
    hello.CreateEx(TC_EVENTS.Line.Hello, source);
    jam.CreateEx(TC_EVENTS.Line.Jam, TRUE, source);
    jam.ipArguments.Clear().AddString('belt');
END_IF
"""
RAISED = 133_000_000_000_000_000


@pytest.fixture
def station(tmp_path: Path) -> Callable[[str], Station]:
    def build(text: str) -> Station:
        (tmp_path / "a.st").write_text(f"{SETUP}{text}\nEND_PROGRAM", encoding="utf-8")
        (tmp_path / "a.tsproj").write_text(CLASSES, encoding="utf-8")
        (tmp_path / "shown").mkdir()
        document = {"plc": [{"sources": "a.st"}], "system": {"root": "shown"}}
        built = Station(parse(document, "a.toml"), base=tmp_path)
        built.advance(0.5)
        assert built.plcs[851].failure == ""
        return built

    return build


def _table(path: Path, delimiter: str = ";") -> list[list[str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.reader(file, delimiter=delimiter))


def test_all_logged_events_are_exported(station: Callable[[str], Station], tmp_path: Path) -> None:
    built = station(f"""
        IF step = 1 THEN
            jam.Raise({RAISED}); jam.Clear({RAISED + 10_000_000});
            jam.Confirm({RAISED + 15_000_000});
            hello.SetJsonAttribute('{{"a":1}}'); hello.Send({RAISED + 20_000_000});
        END_IF
        IF NOT done THEN
            done := logger.ExportLoggedEvents(
                'C:\\log.csv', 0, bError => failed, hrErrorCode => hr);
        END_IF""")
    main: Any = built.plcs[851].instance("MAIN")
    assert (main["done"], main["failed"], main["hr"]) == (True, False, 0)
    file = next((tmp_path / "shown").rglob("log.csv"))
    header, alarm, message = _table(file)
    assert header[:3] == ["Id", "SeverityLevel", "EventClass"]
    rows = [dict(zip(header, row, strict=True)) for row in (alarm, message)]
    guid = "AC1249EC-7A00-4AA4-851B-9BA1B619868E"
    assert [row["Id"] for row in rows] == ["1", "2"]
    assert [row["SeverityLevel"] for row in rows] == ["Error", "Info"]
    assert all(guid in row["EventClass"].upper() for row in rows)
    assert [row["EventText"] for row in rows] == ['jam; at "belt"', "hello"]
    assert [row["EventClassName"] for row in rows] == ["Line events"] * 2
    assert [row["SourceName"] for row in rows] == ["feeder"] * 2
    assert rows[0]["TimeRaised"] == "2022-06-18T04:26:40.000Z"
    assert rows[0]["TimeCleared"] == "2022-06-18T04:26:41.000Z"
    assert rows[0]["TimeConfirmed"] == "2022-06-18T04:26:41.500Z"
    assert (rows[1]["TimeRaised"], rows[1]["TimeCleared"]) == ("2022-06-18T04:26:42.000Z", "")
    assert rows[1]["JsonAttribute"] == '{"a":1}'


def test_settings_choose_what_is_exported(
    station: Callable[[str], Station], tmp_path: Path
) -> None:
    built = station(f"""
        IF step = 1 THEN
            jam.Raise({RAISED}); jam.Clear(0);
            hello.Send({RAISED + 30_000_000}); hello.Send({RAISED + 10_000_000});
            hello.Send({RAISED + 20_000_000});
            filter.Clear().IsMessage();
            csv.AddFilter(filter);
            csv.SetSorting(TcEventField.TimeRaised, TcEventSortOrder.Descending);
            csv.SetLimit(TcEventLimitType.First, 2, 1);
            csv.AddField(TcEventField.TimeRaised, 'when', '');
            csv.AddField(TcEventField.EventText, '', '');
            results[0] := csv.AddField(TcEventField.JsonAttribute, 'a', '$.a');
            csv.SetTimeFormat(TcExportTimeFormat.Custom, TcExportTimeType.UTC,
                TcExportTimePrecision.Seconds, 0, 'dd.MM.yy h:mm:ss.ff t');
            csv.sDelimiter := ',';
        END_IF
        IF NOT done THEN
            done := logger.ExportLoggedEvents(
                'C:\\log.csv', csv, bError => failed, hrErrorCode => hr);
        END_IF""")
    main: Any = built.plcs[851].instance("MAIN")
    assert main["results"][0] == 0x98110701 - 2**32
    assert _table(next((tmp_path / "shown").rglob("log.csv")), ",") == [
        ["when", "EventText"],
        ["18.06.22 4:26:42.00 A", "hello"],
        ["18.06.22 4:26:41.00 A", "hello"],
    ]


def test_export_reports_the_error_of_the_file(station: Callable[[str], Station]) -> None:
    built = station("""
        IF NOT done THEN
            done := logger.ExportLoggedEvents(
                'C:\\none\\log.csv', csv, bError => failed, hrErrorCode => hr);
        END_IF""")
    main: Any = built.plcs[851].instance("MAIN")
    assert (main["done"], main["failed"]) == (True, True)
    assert main["hr"] == 0x9811070C - 2**32


def test_alarms_are_cleared_and_confirmed_by_filters(station: Callable[[str], Station]) -> None:
    built = station("""
        IF step = 1 THEN
            results[0] := logger.GetAlarmEx(TC_EVENTS.Line.Hello, 0, copy);
            jam.Raise(0);
            results[1] := logger.GetAlarm(TC_EVENTS.Line.Jam.uuidEventClass, 1, source, copy);
            flags[0] := copy.bRaised;
            filter.Clear().Severity.GreaterThan(TcEventSeverity.Error);
            results[2] := logger.ClearAlarms(0, FALSE, filter);
            flags[1] := jam.bRaised;
            filter.Clear().Severity.EqualTo(TcEventSeverity.Error);
            results[3] := logger.ClearAlarms(0, FALSE, filter);
            flags[2] := jam.bRaised; flags[3] := copy.bRaised; flags[4] := copy.bActive;
            results[4] := logger.ConfirmAlarms(0, filter);
            flags[5] := copy.bActive;
            results[5] := copy.Raise(0);
            flags[6] := jam.bRaised;
            flags[7] := logger.IsAlarmRaisedEx(TC_EVENTS.Line.Jam);
            copy.Release();
            results[6] := copy.Clear(0);
            filter.Clear().IsAlarm(); filter.AND_OP();
            results[7] := logger.ClearAlarms(0, FALSE, filter);
            results[8] := logger.SendMessage2(TC_EVENTS.Line.Hello.uuidEventClass, 2,
                TcEventSeverity.Info, 0, 0, 0, '{}');
        END_IF""")
    main: Any = built.plcs[851].instance("MAIN")
    no, bad, syntax = (code - 2**32 for code in (0x9811070C, 0x98110712, 0x9811070D))
    assert list(main["results"])[:9] == [no, 0, 0, 0, 0, 0, bad, syntax, 0]
    assert list(main["flags"])[:8] == [True, True, False, False, True, False, True, True]


LOG = """
PROGRAM MAIN
VAR
    message : FB_TcMessage;
    clearing : FB_TcClearLoggedEventsSettings;
    filter : FB_TcEventFilter;
    logger : FB_TcEventLogger;
    guid : GUID;
    i, sent, id : UDINT;
    limit, offset : DINT;
    last, ascending, filters, done : BOOL;
    ids : ARRAY [1..10] OF UDINT;
    left : ARRAY [1..10] OF ULINT;
    count : UINT;
END_VAR
FOR i := 1 TO sent DO
    message.Create(guid, ids[i], TcEventSeverity.Info, 0);
    message.Send(i);
END_FOR
clearing.Clear();
clearing.SetSorting(TcEventField.EventId, SEL(ascending, 0, 1));
clearing.SetLimit(SEL(last, 0, 1), limit, offset);
IF filters THEN
    filter.Clear().EventId.GreaterThan(2);
    clearing.AddFilter(filter);
END_IF
done := logger.ClearLoggedEvents(clearing);
count := EVENT_LOG.count;
FOR i := 1 TO count DO left[i] := EVENT_LOG.rows[EVENT_LOG.order[i]].raised; END_FOR
logger.ClearLoggedEvents(0);
END_PROGRAM
"""


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Station:
    folder = tmp_path_factory.mktemp("log")
    (folder / "a.st").write_text(LOG, encoding="utf-8")
    return Station(parse({"plc": [{"sources": "a.st"}]}, "a.toml"), base=folder)


@given(
    st.lists(st.integers(1, 5), max_size=10),
    st.integers(-1, 4),
    st.integers(0, 3),
    st.booleans(),
    st.booleans(),
    st.booleans(),
)
def test_cleared_events_are_those_of_filter_order_and_limit(
    log: Station, ids: list[int], limit: int, offset: int, last: bool, up: bool, filters: bool
) -> None:
    main: Any = log.plcs[851].instance("MAIN")
    for number, id in enumerate(ids, 1):
        main["ids"][number] = id
    main["sent"], main["limit"], main["offset"] = len(ids), limit, offset
    main["last"], main["ascending"], main["filters"] = last, up, filters
    log.advance(0.01)
    assert log.plcs[851].failure == ""
    chosen = [(id, place) for place, id in enumerate(ids, 1) if not filters or id > 2]
    chosen.sort(reverse=not up)
    if last:
        chosen = chosen[::-1]
    part = chosen[offset:] if limit < 0 else chosen[offset : offset + limit]
    gone = {place for _, place in part}
    expected = [place for place in range(1, len(ids) + 1) if place not in gone]
    assert (main["done"], list(main["left"])[: main["count"]]) == (True, expected)
