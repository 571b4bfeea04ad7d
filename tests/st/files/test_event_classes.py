"""Event classes from symbol files."""

from pathlib import Path
from uuid import UUID

import pytest

from achse.plc.bodies import Bodies
from achse.plc.code.execution import CodeForm
from achse.plc.runtime import PlcRuntime
from achse.plc.task import Task
from achse.st.check import check
from achse.st.files.event_classes import event_classes, events_sources
from achse.st.project import load_project

FILE = b"""<TcModuleClass><DataTypes>
<DataType><Name GUID="{AC1249EC-7A00-4AA4-851B-9BA1B619868E}">CNC_Events</Name>
<DisplayName TxtId=""><![CDATA[CNC events]]></DisplayName>
<EventId><Name Id="1">Start</Name><DisplayName><![CDATA[It's {0} $5 of {1}]]></DisplayName>
<Severity>Warning</Severity></EventId>
<EventId><Name Id="2">__2</Name><Severity>Loud</Severity></EventId>
<EventId><Name Id="x">NoNumber</Name></EventId><EventId><Name Id="4">no name</Name></EventId>
</DataType>
<DataType><Name GUID="{AC}">BadGuid</Name><EventId><Name Id="1">A</Name></EventId></DataType>
</DataTypes></TcModuleClass>"""
MAIN = """PROGRAM MAIN VAR e : TcEventEntry; t, n, u : STRING(255); END_VAR
e := TC_Events.CNC_Events.Start; t := TC_EVENT_TEXT(e); n := TC_EVENT_CLASS_NAME(e);
u := TC_EVENT_TEXT(TC_EVENTS.CNC_Events._IECCONF_2); END_PROGRAM"""


def test_classes_of_a_file() -> None:
    (one,) = event_classes([(FILE, "a.tmc"), (FILE, "b.tmc"), (b"<EventId>", "c.tmc")])
    assert (one.name, one.title) == ("CNC_Events", "CNC events")
    assert one.uuid == UUID("{AC1249EC-7A00-4AA4-851B-9BA1B619868E}")
    assert [(event.name, event.number, event.severity) for event in one.events] == [
        ("Start", 1, "Warning"),
        ("__2", 2, "Info"),
    ]
    assert events_sources([]) == []


def test_programs_name_them(tmp_path: Path) -> None:
    (tmp_path / "MAIN.st").write_text(MAIN)
    (tmp_path / "MAIN.tsproj").write_bytes(FILE)
    main = load_project(tmp_path / "MAIN.st").declarations.programs["main"].__iec__
    assert main.member("e").type.size == 24


CLASSES = """PROGRAM MAIN VAR g : GUID; e : TcEventEntry; same : BOOL; d : DWORD; END_VAR
g := TC_EVENT_CLASSES.CNC_Events; e := TC_EVENTS.CNC_Events.Start;
same := GuidsEqualByVal(TC_Event_Classes.cnc_events, e.uuidEventClass);
d := TC_EVENT_CLASSES.CNC_Events.Data1; END_PROGRAM"""


def test_classes_are_guids(tmp_path: Path) -> None:
    (tmp_path / "MAIN.st").write_text(CLASSES)
    (tmp_path / "MAIN.tsproj").write_bytes(FILE)
    declared = load_project(tmp_path / "MAIN.st").declarations
    typed = check(declared)
    assert [str(fault) for fault in typed.faults] == []
    for form in (CodeForm.PLAIN, CodeForm.AUTO):
        task = Task("PlcTask", 10_000_000, [declared.programs["main"]])
        plc = PlcRuntime([task], declared.units, bodies=Bodies(typed, form=form))
        plc.run_due(10_000_000)
        main = plc.instance("MAIN")
        assert (plc.fault, main["same"], main["d"]) == (None, True, 0xAC1249EC)
        assert main["g"]["Data4"][7] == 0x8E


@pytest.mark.parametrize("name", ["TC_EVENT_CLASSES.Mine", "TC_EVENTS.Mine.Start"])
def test_a_class_that_no_file_has_is_named(tmp_path: Path, name: str) -> None:
    (tmp_path / "MAIN.st").write_text(
        f"PROGRAM MAIN VAR g : GUID; END_VAR g := {name}; END_PROGRAM"
    )
    (fault,) = check(load_project(tmp_path / "MAIN.st").declarations).faults
    assert fault.message.endswith("neither .tsproj nor .tmc of the project has that event class")


def test_a_project_names_the_classes_that_all_projects_have(tmp_path: Path) -> None:
    (tmp_path / "MAIN.st").write_text(
        "PROGRAM MAIN VAR a : TcEventEntry := TC_EVENTS.TcGeneralAdsEventClass.InvalidIndexGroup;"
        " g : GUID; END_VAR g := TC_EVENT_CLASSES.TcRouterEventClass; END_PROGRAM"
    )
    declared = load_project(tmp_path).declarations
    assert check(declared).faults == ()


def test_events_are_in_files_below_a_project_without_solution(tmp_path: Path) -> None:
    (tmp_path / "TMC").mkdir()
    (tmp_path / "TMC" / "Events.tmc").write_bytes(FILE)
    (tmp_path / "a.plcproj").write_text('<P><Compile Include="a.st"/></P>')
    (tmp_path / "a.st").write_text(CLASSES)
    assert check(load_project(tmp_path).declarations).faults == ()
