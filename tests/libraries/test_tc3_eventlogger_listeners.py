"""Tc3_EventLogger: listeners, their filters, and the methods that concern all alarms of a PLC."""

from collections.abc import Callable
from fnmatch import translate
from pathlib import Path
from random import Random
from re import DOTALL, fullmatch
from typing import Any

import pytest

from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.libraries.mc2 import FORMS
from tests.plc.code.conftest import Ran

CLASSES = """<T><DataType><Name GUID="{AC1249EC-7A00-4AA4-851B-9BA1B619868E}">Line</Name>
<DisplayName>Line events</DisplayName><EventId><Name Id="1">Jam</Name>
<DisplayName>jam at {0}</DisplayName><Severity>Error</Severity></EventId>
<EventId><Name Id="2">Hello</Name><DisplayName>hello</DisplayName><Severity>Info</Severity>
</EventId></DataType>
<DataType><Name GUID="{BC1249EC-7A00-4AA4-851B-9BA1B619868E}">Door</Name>
<DisplayName>Doors</DisplayName><EventId><Name Id="1">Open</Name>
<DisplayName>door open</DisplayName><Severity>Warning</Severity></EventId></DataType></T>"""

LISTENER = """
FUNCTION_BLOCK FB_Seen EXTENDS {base}
VAR seen : STRING(255); last : ULINT; busy : BOOL; END_VAR
METHOD Note : HRESULT
VAR_INPUT sign : STRING(1); fbEvent : REFERENCE TO FB_TcEvent; END_VAR
VAR text : STRING(255); END_VAR
IF busy THEN busy := FALSE; Note := 1; seen := CONCAT(seen, '?'); RETURN; END_IF
fbEvent.RequestEventText(1033, text, SIZEOF(text));
seen := CONCAT(CONCAT(CONCAT(seen, sign), TO_STRING(fbEvent.nEventId)),
    CONCAT(CONCAT('(', fbEvent.ipSourceInfo.sName), ')'));
last := fbEvent.nTimestamp;
END_METHOD
METHOD OnMessageSent {result} VAR_INPUT fbEvent : REFERENCE TO FB_TcEvent; END_VAR
{give} Note('m', fbEvent); END_METHOD
METHOD OnAlarmRaised {result} VAR_INPUT fbEvent : REFERENCE TO FB_TcEvent; END_VAR
{give} Note('r', fbEvent); END_METHOD
METHOD OnAlarmCleared {result} VAR_INPUT fbEvent : REFERENCE TO FB_TcEvent; END_VAR
{give} Note('c', fbEvent); END_METHOD
METHOD OnAlarmConfirmed {result} VAR_INPUT fbEvent : REFERENCE TO FB_TcEvent; END_VAR
{give} Note('k', fbEvent); END_METHOD
METHOD OnAlarmDisposed {result} VAR_INPUT fbEvent : REFERENCE TO FB_TcEvent; END_VAR
{give} Note('d', fbEvent); END_METHOD
END_FUNCTION_BLOCK
"""

MAIN = """
PROGRAM MAIN
VAR
    step : INT;
    heard : FB_Seen;
    config : ITcEventFilterConfig;
    filter, group : FB_TcEventFilter;
    hello, open : FB_TcMessage;
    jam : FB_TcAlarm;
    feeder : FB_TcSourceInfo;
    logger : FB_TcEventLogger;
    request : FB_RequestEventText;
    results : ARRAY [1..8] OF HRESULT;
    raised : ARRAY [1..3] OF BOOL;
    text : STRING(255);
END_VAR
step := step + 1;
IF step = 1 THEN
    feeder.sName := 'feeder';
    hello.CreateEx(TC_EVENTS.Line.Hello, 0);
    open.CreateEx(TC_EVENTS.Door.Open, feeder);
    jam.CreateEx(TC_EVENTS.Line.Jam, TRUE, feeder);
    {begin}
END_IF
{steps}
results[8] := heard.Execute();
END_PROGRAM
"""
ALL = """IF step = 2 THEN
    hello.Send(77); open.Send(0);
    jam.ipArguments.Clear().AddEventReferenceIdGuid(1, TC_EVENT_CLASSES.Door);
    jam.Raise(0); jam.Clear(0, FALSE); jam.Confirm(0); jam.Release();
END_IF"""


@pytest.fixture
def run(tmp_path: Path) -> Callable[..., Any]:
    def run(
        begin: str,
        steps: str = ALL,
        cycles: int = 4,
        base: str = "FB_ListenerBase2",
        form: str = "plain",
    ) -> Any:
        result, give = ("", "") if base == "FB_ListenerBase" else (": HRESULT", "{name} :=")
        listener = LISTENER.replace("{base}", base).replace("{result}", result)
        for name in ("MessageSent", "AlarmRaised", "AlarmCleared", "AlarmConfirmed"):
            listener = listener.replace("{give}", give.format(name=f"On{name}"), 1)
        listener = listener.replace("{give}", give.format(name="OnAlarmDisposed"))
        main = MAIN.replace("{begin}", begin).replace("{steps}", steps)
        (tmp_path / "a.st").write_text(listener + main, encoding="utf-8")
        (tmp_path / "a.tsproj").write_text(CLASSES, encoding="utf-8")
        document = {"plc": [{"sources": "a.st", "code": form}]}
        station = Station(parse(document, "a.toml"), base=tmp_path)
        station.advance(cycles * 0.01)
        plc = station.plcs[851]
        assert plc.failure == ""
        return plc.instance("MAIN")

    return run


EVERYTHING = "m2(MAIN.hello)m1(feeder)r1(feeder)c1(feeder)k1(feeder)d1(feeder)"


@pytest.mark.parametrize("base", ["FB_ListenerBase", "FB_ListenerBase2"])
def test_a_listener_gets_what_happens_in_order(run: Callable[..., Any], base: str) -> None:
    """As machine code where it can be made; the other tests save the time of making it."""
    begin = "results[1] := heard.Subscribe(0, 0); results[2] := heard.Subscribe(0, 0);"
    main = run(begin, base=base, form=FORMS[-1])
    assert main["heard"]["seen"] == EVERYTHING
    assert list(main["results"])[:2] == [0, 0x9811070F - 2**32]


def test_a_listener_hears_what_happens_while_it_is_subscribed(run: Callable[..., Any]) -> None:
    steps = """CASE step OF
    2: hello.Send(5); 3: results[2] := heard.Unsubscribe(); hello.Send(0);
    4: results[3] := heard.Unsubscribe(); heard.Subscribe(0, 0); hello.Send(9);
    END_CASE"""
    main = run("hello.Send(0); heard.Subscribe(0, 0);", steps, cycles=6)
    assert (main["heard"]["seen"], main["heard"]["last"]) == ("m2(MAIN.hello)" * 2, 9)
    assert list(main["results"])[1:3] == [0, 0x9811070C - 2**32]


@pytest.mark.parametrize(
    ("begin", "seen"),
    [
        ("heard.Subscribe(ADR(config), 0);", "r1(feeder)c1(feeder)k1(feeder)d1(feeder)"),
        (
            "heard.Subscribe(ADR(config), ADR(config));"
            "config.AddEventClass(TC_EVENT_CLASSES.Line, TcEventSeverity.Error);",
            "r1(feeder)c1(feeder)k1(feeder)d1(feeder)",
        ),
        (
            "heard.Subscribe(0, ADR(config)); "
            "config.AddSourceInfo(feeder, TcEventSeverity.Critical);",
            "m2(MAIN.hello)m1(feeder)",
        ),
        (
            "heard.Subscribe(ADR(config), 0);"
            "config.AddSourceInfo(feeder, TcEventSeverity.Verbose);"
            "config.RemoveSourceInfo(feeder); results[1] := config.RemoveSourceInfo(feeder);"
            "config.AddEventClass(TC_EVENT_CLASSES.Door, TcEventSeverity.Info);",
            "m1(feeder)r1(feeder)c1(feeder)k1(feeder)d1(feeder)",
        ),
        ("heard.Subscribe2(0);", EVERYTHING),
        ("filter.Clear().EventClass.EqualTo(TC_EVENT_CLASSES.Door); heard.Subscribe2(filter);",
         "m1(feeder)"),
        ("filter.Severity.GreaterThan(TcEventSeverity.Warning).AND_OP().Source.Name.Like('%eed_r');"
         "heard.Subscribe2(filter);", "r1(feeder)c1(feeder)k1(feeder)d1(feeder)"),
        ("filter.IsMessage().AND_OP().NOT_OP().EventId.EqualTo(2)"
         ".OR_OP().AlarmState.IsActive(); heard.Subscribe2(filter);",
         "m1(feeder)r1(feeder)c1(feeder)"),
        ("group.EventId.LessThan(2).OR_OP().TimeRaised.EqualTo(5);"
         "filter.IsAlarm().OR_OP().FilterExpression(group); heard.Subscribe2(filter);",
         EVERYTHING.removeprefix("m2(MAIN.hello)")),
        ("hello.SetJsonAttribute('{}'); filter.JsonAttribute.Value.EqualTo('{}');"
         "heard.Subscribe2(filter);", "m2(MAIN.hello)"),
        ("filter.IsAlarm(); filter.IsMessage(); results[1] := heard.Subscribe2(filter);", ""),
        ("filter.IsAlarm().AND_OP(); results[1] := heard.Subscribe2(filter);", ""),
    ],
)  # fmt: skip
def test_filters_let_pass_what_they_describe(
    run: Callable[..., Any], begin: str, seen: str
) -> None:
    main = run(begin)
    assert main["heard"]["seen"] == seen
    assert bool(main["results"][1]) == ("results[1]" in begin)


def test_one_condition_too_many_is_refused(run: Callable[..., Any]) -> None:
    begin = """filter.IsAlarm();
    WHILE results[2] < 127 DO
        filter.OR_OP().IsAlarm(); results[2] := results[2] + 1;
    END_WHILE
    results[1] := heard.Subscribe2(filter);
    filter.OR_OP();
    results[3] := heard.Subscribe2(filter);"""
    assert list(run(begin)["results"])[:3] == [0, 127, 0x98110716 - 2**32]


def test_an_event_that_was_not_taken_comes_again(run: Callable[..., Any]) -> None:
    main = run("heard.Subscribe(0, 0); heard.busy := TRUE;")
    assert main["heard"]["seen"] == f"?{EVERYTHING}"


def test_a_listener_that_falls_behind_loses_the_oldest(run: Callable[..., Any]) -> None:
    steps = """IF step = 2 THEN
    WHILE results[1] < 70 DO hello.Send(INT_TO_ULINT(step)); results[1] := results[1] + 1; END_WHILE
    heard.reader_ := heard.reader_ + 56;
    END_IF"""
    main = run("heard.Subscribe(0, 0);", steps)
    assert main["heard"]["seen"] == "m2(MAIN.hello)" * 14


def test_all_alarms_are_cleared_and_confirmed(run: Callable[..., Any]) -> None:
    steps = """CASE step OF
    2: jam.Raise(0); raised[1] := logger.IsAlarmRaised(TC_EVENT_CLASSES.Line, 1, feeder);
       raised[2] := logger.IsAlarmRaised(TC_EVENT_CLASSES.Line, 2, feeder);
    3: logger.ClearAllAlarms(); raised[3] := logger.IsAlarmRaised(TC_EVENT_CLASSES.Line, 1);
    4: logger.ConfirmAllAlarms(); logger.ConfirmAllAlarms(); logger.ClearAllAlarms();
    END_CASE"""
    main = run("heard.Subscribe(0, 0);", steps, cycles=6)
    assert main["heard"]["seen"] == "r1(feeder)c1(feeder)k1(feeder)"
    assert list(main["raised"])[:3] == [True, False, False]


def test_texts_of_events_are_requested(run: Callable[..., Any]) -> None:
    begin = """jam.ipArguments.AddString('belt');
    request.Request(TC_EVENT_CLASSES.Line, 1, 1033, jam.ipArguments);
    raised[1] := NOT request.bBusy AND NOT request.bError; request.GetString(text, SIZEOF(text));"""
    main = run(begin)
    assert (main["text"], main["raised"][1]) == ("jam at belt", True)


def test_patterns_describe_texts() -> None:
    random = Random(5)
    pairs = [
        ("".join(random.choices("ab", k=random.randrange(6))), "".join(random.choices("ab%_", k=n)))
        for n in range(6)
        for _ in range(25)
    ]
    calls = "".join(
        f"is[{number}] := EVENT_TEXT_IS_LIKE('{text}', '{pattern}');"
        for number, (text, pattern) in enumerate(pairs)
    )
    variables = "VAR is : ARRAY [0..149] OF BOOL; e : FB_TcEvent; END_VAR"
    ran = Ran(f"PROGRAM MAIN {variables} {calls} END_PROGRAM")
    shell = [pattern.replace("%", "*").replace("_", "?") for _, pattern in pairs]
    expected = [
        fullmatch(translate(glob), text, DOTALL) is not None
        for (text, _), glob in zip(pairs, shell, strict=True)
    ]
    assert 20 < sum(expected) < 130
    assert list(ran.cycle()["is"]) == expected


def test_names_of_a_derived_listener_are_its_own() -> None:
    names = ("subscribed", "messages", "alarms", "filter", "reader", "record", "event")
    ran = Ran(
        "FUNCTION_BLOCK FB_Own EXTENDS FB_ListenerBase2 VAR_OUTPUT "
        + " ".join(f"{name} : INT := {number};" for number, name in enumerate(names, start=1))
        + " END_VAR END_FUNCTION_BLOCK PROGRAM MAIN VAR own : FB_Own; sum : INT; ok : BOOL; END_VAR"
        " ok := NOT own.bSubscribed; own.Subscribe2(0); ok := ok AND own.bSubscribed;"
        " own.Execute(); sum := " + " + ".join(f"own.{name}" for name in names) + "; END_PROGRAM"
    ).cycle()
    assert (ran.plc.failure, ran["sum"], ran["ok"]) == ("", 28, True)
