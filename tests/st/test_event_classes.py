"""Event classes from symbol files."""

from pathlib import Path
from uuid import UUID

from achse.st.event_classes import event_classes, events_source
from achse.st.project import load_project

FILE = b"""<TcModuleClass><DataTypes>
<DataType><Name GUID="{AC1249EC-7A00-4AA4-851B-9BA1B619868E}">CNC_Events</Name>
<DisplayName TxtId=""><![CDATA[CNC events]]></DisplayName>
<EventId><Name Id="1">Start</Name><DisplayName><![CDATA[It's {0} $5 of {1}]]></DisplayName>
<Severity>Warning</Severity></EventId>
<EventId><Name Id="2">Odd</Name><Severity>Loud</Severity></EventId>
<EventId><Name Id="x">NoNumber</Name></EventId><EventId><Name Id="4">no name</Name></EventId>
</DataType>
<DataType><Name GUID="{AC}">BadGuid</Name><EventId><Name Id="1">A</Name></EventId></DataType>
</DataTypes></TcModuleClass>"""
MAIN = """PROGRAM MAIN VAR e : TcEventEntry; t, n, u : STRING(255); END_VAR
e := TC_Events.CNC_Events.Start; t := TC_EVENT_TEXT(e); n := TC_EVENT_CLASS_NAME(e);
u := TC_EVENT_TEXT(TC_EVENTS.CNC_Events.Odd); END_PROGRAM"""


def test_classes_of_a_file() -> None:
    (one,) = event_classes([(FILE, "a.tmc"), (FILE, "b.tmc"), (b"<EventId>", "c.tmc")])
    assert (one.name, one.title) == ("CNC_Events", "CNC events")
    assert one.uuid == UUID("{AC1249EC-7A00-4AA4-851B-9BA1B619868E}")
    assert [(event.name, event.number, event.severity) for event in one.events] == [
        ("Start", 1, "Warning"),
        ("Odd", 2, "Info"),
    ]
    assert events_source([]) is None


def test_programs_name_them(tmp_path: Path) -> None:
    (tmp_path / "MAIN.st").write_text(MAIN)
    (tmp_path / "MAIN.tsproj").write_bytes(FILE)
    main = load_project(tmp_path / "MAIN.st").declarations.programs["main"].__iec__
    assert main.member("e").type.size == 24
