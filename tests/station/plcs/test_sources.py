"""PLCs from sources, symbol files and Python, with behaviour; online changes of a station."""

import asyncio
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import achse
from achse.iec.symbols import SymbolEntry
from achse.plc import Area, PlcState
from achse.st.symbolfiles import read_tmc, write_tmc
from achse.station import ConfigError, Station

MAIN = """PROGRAM MAIN
VAR
    nCounter : UDINT;
    fbValve : FB_Valve;
    aParts : ARRAY[1..2] OF ST_Part := [(nId := 5), (nId := 6)];
END_VAR
nCounter := nCounter + 1;
END_PROGRAM
"""
TYPES = """TYPE ST_Part :
STRUCT
    nId : INT := 1;
    sName : STRING(10) := 'part';
    tWait : TIME := T#2s;
END_STRUCT
END_TYPE
FUNCTION_BLOCK FB_Valve
VAR_OUTPUT
    bOpen : BOOL;
END_VAR
VAR
    nCalls : INT;
END_VAR
{attribute 'TcRpcEnable'}
METHOD Open : BOOL
VAR_INPUT
    fHow : LREAL;
END_VAR
END_METHOD
END_FUNCTION_BLOCK
"""
GVL = """VAR_GLOBAL
    nLimit : INT := 42;
    bIn AT %IX3.1 : BOOL;
END_VAR
"""
BEHAVIOUR = """
class MAIN:
    def __init__(self):
        self.calls = 0

    def cycle(self):
        self.calls += 1
        self.nCounter += 1
        self.fbValve.cycle()


class FB_Valve:
    def cycle(self):
        self.nCalls += 1

    def Open(self, how):
        self.bOpen = how > 0.5
        return self.bOpen
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    plc = tmp_path / "plc"
    plc.mkdir()
    (plc / "MAIN.st").write_text(MAIN)
    (plc / "types.st").write_text(TYPES)
    (plc / "GVL.st").write_text(GVL)
    (tmp_path / "behaviour.py").write_text(BEHAVIOUR)
    return tmp_path


def _station(folder: Path, text: str) -> Station:
    path = folder / "station.toml"
    path.write_text(text)
    return Station.load(path)


FROM_SOURCES = """
[[plc]]
sources = "plc"
behaviour = ["behaviour.py:MAIN", "behaviour.py:FB_Valve"]
[[plc.task]]
name = "Fast"
cycle = "1ms"
programs = ["main"]
"""


def _value(station: Station, name: str, port: int = 851) -> bytes:
    device = next(d for d in station.devices if d.addresses and d.address.port == port)
    return device.read_write(0xF004, 0, 1000, name.encode())


def test_variables_start_as_declared_and_python_runs_the_programs(folder: Path) -> None:
    station = _station(folder, FROM_SOURCES)
    gvl: Any = station.plcs[851].instance("GVL")
    main: Any = station.plcs[851].instance("MAIN")
    assert (gvl.nLimit, main.aParts[2].nId, main.aParts[1].sName) == (42, 6, "part")
    station.advance(0.01)
    assert (main.nCounter, main.calls, main.fbValve.nCalls) == (10, 10, 10)
    assert _value(station, "MAIN.nCounter") == b"\x0a\0\0\0"


def test_without_any_task_one_runs_all_programs(folder: Path) -> None:
    station = _station(
        folder,
        '[[plc]]\nsources = "plc"\nbehaviour = ["behaviour.py:MAIN", "behaviour.py:FB_Valve"]\n',
    )
    station.advance(0.05)
    assert _value(station, "MAIN.nCounter") == b"\x05\0\0\0"


def test_a_declared_method_is_a_python_call_for_clients(folder: Path) -> None:
    station = _station(folder, FROM_SOURCES)
    device = next(d for d in station.devices if d.addresses and d.address.port == 851)
    handle = int.from_bytes(device.read_write(0xF003, 0, 4, b"MAIN.fbValve#Open"), "little")
    assert device.read_write(0xF005, handle, 1, bytes.fromhex("000000000000f03f")) == b"\1"
    assert _value(station, "MAIN.fbValve.bOpen") == b"\1"


def test_several_plcs_each_with_their_own_memory(folder: Path) -> None:
    second = FROM_SOURCES.replace("[[plc]]", "[[plc]]\nport = 852").replace("1ms", "5ms")
    station = _station(folder, FROM_SOURCES + second)
    station.advance(0.02)
    assert _value(station, "MAIN.nCounter") == b"\x14\0\0\0"
    assert _value(station, "MAIN.nCounter", 852) == b"\x04\0\0\0"


def test_a_symbol_file_puts_everything_where_it_says(folder: Path) -> None:
    from achse.plc.symbol_file import symbol_file

    first = _station(folder, FROM_SOURCES)
    (folder / "plant.tmc").write_bytes(write_tmc(symbol_file(first.plcs[851])))
    second = _station(
        folder,
        '[[plc]]\nsymbols = "plant.tmc"\nbehaviour = ["behaviour.py:MAIN",'
        ' "behaviour.py:FB_Valve"]\n',
    )
    places = [
        {
            p.name: (p.area, p.offset, p.bit)
            for p in s.plcs[851].variables
            if "TwinCAT" not in p.name
        }
        for s in (first, second)
    ]
    assert places[0] == places[1]
    second.advance(0.01)
    main: Any = second.plcs[851].instance("MAIN")
    assert (main.nCounter, main.fbValve.nCalls, main.aParts[1].nId) == (10, 10, 5)
    task = second.plcs[851].tasks[0]
    assert (task.name, task.cycle_ns) == ("Fast", 1_000_000)
    assert read_tmc((folder / "plant.tmc").read_bytes(), "plant.tmc").name == "plc"


def test_an_image_large_enough_for_the_file(folder: Path) -> None:
    (folder / "pool.tpy").write_text(
        "<PlcProjectInfo><Symbols><Symbol><Name>.x</Name><Type>INT</Type><IGroup>61472</IGroup>"
        "<IOffset>128000</IOffset><BitSize>16</BitSize></Symbol></Symbols></PlcProjectInfo>"
    )
    station = _station(folder, '[[plc]]\nsymbols = "pool.tpy"\nport = 801\n')
    assert len(station.plcs[801].memory[Area.INPUT]) >= 128_002
    assert _value(station, ".x", 801) == b"\0\0"


def test_an_image_large_enough_for_the_sources(folder: Path) -> None:
    (folder / "wide.st").write_text("VAR_GLOBAL nFar AT %IW99998 : INT := 7; END_VAR")
    station = _station(folder, '[[plc]]\nsources = "wide.st"\n')
    assert len(station.plcs[851].memory[Area.INPUT]) >= 100_000
    assert _value(station, "wide.nFar") == b"\7\0"


@pytest.mark.skipif(sys.platform != "linux", reason="Linux tells in KiB what a process takes")
@pytest.mark.parametrize(("checks", "after"), [(True, 0), (False, 5)])
def test_unchecked_bounds_let_an_index_reach_the_next_variable(
    folder: Path, checks: bool, after: int
) -> None:
    (folder / "index.st").write_text(
        "PROGRAM MAIN VAR a : ARRAY[0..1] OF INT; after : INT; i : INT := 2; END_VAR"
        " a[i] := 5; END_PROGRAM"
    )
    key = "" if checks else "check_bounds = false\n"
    station = _station(folder, f'[[plc]]\nsources = "index.st"\n{key}')
    station.advance(0.01)
    assert station.plcs[851].instance("MAIN")["after"] == after
    assert (station.plcs[851].fault is not None) is checks


@pytest.mark.parametrize(
    ("key", "option", "runs"),
    [
        ("", "", False),
        ("", "DisableFpExceptions='true'", True),
        ("floating_point_exceptions = true", "DisableFpExceptions='true'", False),
        ("floating_point_exceptions = false", "", True),
    ],
)
def test_the_solution_says_whether_tasks_have_floating_point_exceptions(
    folder: Path, key: str, option: str, runs: bool
) -> None:
    (folder / "root.st").write_text(
        "PROGRAM MAIN VAR r, less : LREAL; END_VAR less := -1; r := SQRT(less); END_PROGRAM"
    )
    option = option.replace("'", '"')
    (folder / "a.tsproj").write_text(f"<Task {option}><Name>PlcTask</Name></Task>")
    (folder / "PlcTask.TcTTO").write_text(
        '<TcPlcObject><Task Name="PlcTask"><CycleTime>1000</CycleTime><Priority>20</Priority>'
        "<PouCall><Name>MAIN</Name></PouCall></Task></TcPlcObject>"
    )
    (folder / "a.plcproj").write_text(
        '<P><Compile Include="root.st"/><Compile Include="PlcTask.TcTTO"/></P>'
    )
    station = _station(folder, f'[[plc]]\nsources = "a.plcproj"\n{key}\n')
    station.advance(0.01)
    assert (station.plcs[851].fault is None) is runs


def test_areas_that_share_a_large_range_take_memory_where_something_is(folder: Path) -> None:
    import resource

    groups = {".i": 61472, ".q": 61488, ".m": 16416, ".d": 16448, ".r": 16432}
    symbols = "".join(
        f"<Symbol><Name>{name}</Name><Type>INT</Type><IGroup>{group}</IGroup>"
        f"<IOffset>{200_000_000 + group}</IOffset><BitSize>16</BitSize></Symbol>"
        for name, group in groups.items()
    )
    (folder / "far.tpy").write_text(
        f"<PlcProjectInfo><Symbols>{symbols}</Symbols></PlcProjectInfo>"
    )
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    station = _station(folder, '[[plc]]\nsymbols = "far.tpy"\nport = 801\n')
    plc = station.plcs[801]
    units: Any = plc.instance("")
    for number, name in enumerate(groups, 1):
        units[name[1:]] = number
        assert _value(station, name, 801) == bytes([number, 0])
    plc.online_change()
    station.advance(0.02)
    plc.reset(origin=True)
    assert _value(station, ".d", 801) == b"\0\0"
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    assert grown < 100_000, "KiB; the five areas have 200,000,000 bytes each"


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ('sources = "nowhere"', r"plc\[1\]\.sources: .*nowhere does not exist"),
        ('symbols = "no.tmc"', r"plc\[1\]\.symbols: .*no\.tmc cannot be read"),
        ('symbols = "behaviour.py"', r"plc\[1\]\.symbols: .*ends in \.tmc or \.tpy"),
        ('sources = "bad.st"', r"plc\[1\]\.sources: .*bad\.st.*2"),
        ('sources = "far.st"', r"plc\[1\]\.sources: far\.st:3:8: an address is below byte"),
        ('sources = "plc"\nbehaviour = ["behaviour.py:Nothing"]', "behaviour.py has no class"),
        ('sources = "plc"\nbehaviour = ["station:X"]', r"behaviour: station cannot be imported"),
        ('sources = "plc"\nbehaviour = ["other.py:Lonely"]', "no program.*named 'Lonely'"),
        (
            'sources = "plc"\n[[plc.task]]\nprograms = ["MIAN"]',
            r"task\[1\]\.programs: expected one of MAIN, or module:Class.* got 'MIAN'",
        ),
    ],
)
def test_faults_name_key_and_expectation(folder: Path, text: str, fault: str) -> None:
    (folder / "bad.st").write_text("PROGRAM P\nVAR x : ; END_VAR\nEND_PROGRAM\n")
    (folder / "far.st").write_text(
        "PROGRAM P\nVAR\n  x AT %MB1000000000 : BYTE;\nEND_VAR\nEND_PROGRAM\n"
    )
    (folder / "other.py").write_text("class Lonely: pass\n")
    with pytest.raises(ConfigError, match=fault):
        _station(folder, f"[[plc]]\n{text}\n")


def test_an_online_change_takes_the_new_sources(folder: Path) -> None:
    station = _station(folder, FROM_SOURCES)
    station.advance(0.01)
    version = station.plcs[851].online_changes
    main = folder / "plc" / "MAIN.st"
    main.write_text(MAIN.replace("nCounter : UDINT;", "fNew : LREAL := 1.5; nCounter : UDINT;"))
    station.online_change(851)
    station.advance(0.01)
    running: Any = station.plcs[851].instance("MAIN")
    assert (running.nCounter, running.calls, running.fNew) == (20, 20, 1.5)
    assert station.plcs[851].online_changes == version + 1


@pytest.mark.parametrize("far", [70_000, 5_000_000])
def test_an_online_change_makes_areas_larger(folder: Path, far: int) -> None:
    (folder / "small.st").write_text(
        "PROGRAM P VAR a AT %MB8 : BYTE := 5; b AT %MB5000000 : INT; END_VAR END_PROGRAM"
        if far > 4_000_000
        else "PROGRAM P VAR a AT %MB8 : BYTE := 5; b : INT; END_VAR END_PROGRAM"
    )
    station = _station(folder, '[[plc]]\nsources = "small.st"\n')
    running: Any = station.plcs[851].instance("P")
    running.a = 6
    (folder / "small.st").write_text(
        f"PROGRAM P VAR a AT %MB8 : BYTE := 5; b AT %MW{far} : INT := 7;"
        f" c AT %MB{2 * far} : BYTE := 9; END_VAR END_PROGRAM"
    )
    station.online_change(851)
    assert _value(station, "P.a") == b"\6"
    assert _value(station, "P.c") == b"\t"


def test_sources_with_faults_leave_the_plc_as_it_was(folder: Path) -> None:
    station = _station(folder, FROM_SOURCES)
    (folder / "plc" / "MAIN.st").write_text("PROGRAM MAIN\nVAR x : ; END_VAR\n")
    with pytest.raises(ConfigError, match=r"MAIN\.st"):
        station.online_change()
    station.advance(0.005)
    assert station.plcs[851].state is PlcState.RUN
    assert _value(station, "MAIN.nCounter") == b"\5\0\0\0"
    with pytest.raises(ConfigError, match="port 999 is not a PLC"):
        station.online_change(999)


def test_bodies_with_new_faults_leave_the_plc_as_it_was(folder: Path) -> None:
    source = folder / "own.st"
    text = "PROGRAM P VAR n : INT; END_VAR n := n + 1; {more} END_PROGRAM"
    text += "\nFUNCTION Old : INT Old := gone; END_FUNCTION\n"
    source.write_text(text.replace("{more}", ""))
    task = '[[plc.task]]\nname = "T"\ncycle = "1ms"\nprograms = ["P"]\n'
    station = _station(folder, f'[[plc]]\nsources = "own.st"\n{task}')
    source.write_text(text.replace("{more}", "n := m;"))
    with pytest.raises(ConfigError, match=r"own\.st:1:49: nothing is named 'm' here"):
        station.online_change()
    station.advance(0.005)
    assert station.plcs[851].state is PlcState.RUN
    assert _value(station, "P.n") == b"\5\0"
    source.write_text(text.replace("{more}", "\nn := n + 1;"))
    station.online_change()  # What was at fault before may stay so.
    station.advance(0.005)
    assert _value(station, "P.n") == b"\17\0"


def test_stamps_report_when_a_source_changed(folder: Path) -> None:
    from achse.station.configuration.plc import PlcConfig
    from achse.station.plcs.sources import PlcSource

    source = PlcSource(PlcConfig(sources="plc", behaviour=["behaviour.py:MAIN"]), "plc", folder)
    before = source.stamps()
    assert {path.name for path in before} == {"MAIN.st", "types.st", "GVL.st", "behaviour.py"}
    (folder / "plc" / "GVL.st").write_text(GVL + "\n(* more *)\n")
    assert source.stamps() != before


def test_types_of_libraries_come_from_their_sources(folder: Path) -> None:
    (folder / "axis.st").write_text("PROGRAM P VAR a : Tc2_NCI.NCI_REF; END_VAR END_PROGRAM")
    (folder / "library.st").write_text(
        "TYPE NCI_REF : STRUCT n : DINT := 5; END_STRUCT END_TYPE\n"
        "VAR_GLOBAL nOfTheLibrary : INT; END_VAR\n"
    )
    with pytest.raises(ConfigError, match=r"named 'Tc2_NCI\.NCI_REF'") as refusal:
        _station(folder, '[[plc]]\nsources = "axis.st"\n')
    assert "there or beside the sources" in str(refusal.value)
    station = _station(folder, '[[plc]]\nsources = "axis.st"\nlibraries = ["library.st"]\n')
    assert _value(station, "P.a.n") == b"\5\0\0\0"
    with pytest.raises(ConfigError, match="libraries go with sources"):
        _station(folder, '[[plc]]\nlibraries = ["library.st"]\n')


def test_each_task_has_its_information(folder: Path) -> None:
    (folder / "two.st").write_text(
        "PROGRAM A VAR n, m : UDINT; END_VAR"
        " n := _TaskInfo[2].CycleTime; m := _TaskInfo[1].CycleTime; END_PROGRAM"
        " PROGRAM B END_PROGRAM"
    )
    station = _station(
        folder,
        '[[plc]]\nsources = "two.st"\n[[plc.task]]\nname = "Slow"\ncycle = "50ms"\n'
        'programs = ["A"]\n[[plc.task]]\nname = "Fast"\ncycle = "2ms"\nprograms = ["B"]\n',
    )
    station.advance(0.2)
    assert station.plcs[851].failure == ""
    main = station.plcs[851].instance("A")
    assert (main["n"], main["m"]) == (20_000, 500_000)


def test_a_type_that_is_nearly_named_right(folder: Path) -> None:
    (folder / "near.st").write_text(
        "TYPE ST_Feeder : STRUCT n : INT; END_STRUCT END_TYPE\n"
        "PROGRAM P VAR a : ST_Feder; END_VAR END_PROGRAM\n"
    )
    with pytest.raises(ConfigError, match="named 'ST_Feder'; near: ST_Feeder"):
        _station(folder, '[[plc]]\nsources = "near.st"\n')


def test_only_who_has_sources_loads_the_parser() -> None:
    program = (
        "import sys; from achse.station import Station; Station.demo();"
        "print('achse.st.project' in sys.modules)"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (run.stdout, run.stderr) == ("False\n", "")


def test_unknown_types_may_be_opaque(folder: Path, caplog: pytest.LogCaptureFixture) -> None:
    (folder / "pump.st").write_text(
        "PROGRAM MAIN VAR fb : Lib.FB_Pump; e : E_Mode := E_Mode.Auto; n : INT; END_VAR"
        " fb(bRun := TRUE); n := n + 1; END_PROGRAM"
    )
    text = '[[plc]]\nsources = "pump.st"\n'
    with pytest.raises(ConfigError, match=r"missing types: E_Mode, Lib\.FB_Pump"):
        _station(folder, text)
    station = _station(folder, text + 'unknown_types = "opaque"\n')
    assert "lines of stubs for undeclared names" in caplog.text
    station.advance(0.02)
    main = station.plcs[851].instance("MAIN")
    assert main["n"] > 0
    assert main["fb"]["bRun"] is True
    with pytest.raises(ConfigError, match="unknown_types goes with sources"):
        _station(folder, '[[plc]]\nunknown_types = "opaque"\n')


TEXTS = """TYPE ST_Text : STRUCT
    {attribute 'TcEncoding' := 'UTF-8'} sName : STRING(20) := sLiteral_TO_UTF8('äß');
    sPlain : STRING(20) := 'ä';
END_STRUCT END_TYPE
PROGRAM MAIN
VAR stText : ST_Text; dtMade : DT := DT#2026-01-02-03:04:05; END_VAR
END_PROGRAM"""


def test_members_in_utf_8_are_neither_garbled_nor_destroyed(folder: Path) -> None:
    (folder / "texts.st").write_text(TEXTS)
    station = _station(folder, '[[plc]]\nsources = "texts.st"\n')

    async def main() -> None:
        async with achse.connect(station.router, port=851) as plc:
            assert await plc.read("MAIN.stText.sName") == "äß"
            await plc.write("MAIN.stText.sName", "Ωmega→€")
            await plc.write("MAIN.stText.sPlain", "ö")
            assert await plc.read("MAIN.stText.sName") == "Ωmega→€"
            whole = await plc.read("MAIN.stText")
            assert (whole["sName"], whole["sPlain"]) == ("Ωmega→€", "ö")

    asyncio.run(main())
    assert _value(station, "MAIN.stText.sName").rstrip(b"\0") == "Ωmega→€".encode()
    assert _value(station, "MAIN.stText.sPlain").rstrip(b"\0") == b"\xf6"


def test_dt_is_date_and_time_to_clients(folder: Path) -> None:
    (folder / "texts.st").write_text(TEXTS)
    station = _station(folder, '[[plc]]\nsources = "texts.st"\n')
    plc = next(d for d in station.devices if d.addresses and d.address.port == 851)
    entry = SymbolEntry.decode(plc.read_write(0xF009, 0, 1000, b"MAIN.dtMade"))
    assert (entry.type_name, entry.size) == ("DATE_AND_TIME", 4)


def test_faulty_units_that_no_task_reaches_are_left_out(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "MAIN.st").write_text("PROGRAM MAIN VAR n : INT; END_VAR n := n + 1; END_PROGRAM")
    (tmp_path / "BAD.st").write_text("FUNCTION_BLOCK BAD v := 1; END_FUNCTION_BLOCK")
    (tmp_path / "INIT.st").write_text(
        "FUNCTION_BLOCK INIT METHOD FB_init : BOOL\n"
        "VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; END_VAR\n"
        "nothing := 1; END_METHOD END_FUNCTION_BLOCK"
    )
    (tmp_path / "OLD.st").write_text("VAR_GLOBAL b : BAD; i : INIT; x : Nothing; END_VAR")
    (tmp_path / "USES.st").write_text("VAR_GLOBAL i : INIT; n : INT := 5; END_VAR")
    toml = tmp_path / "station.toml"
    task = '[[plc.task]]\nname = "T"\nprograms = ["MAIN"]\n'
    for code in ("plain", "auto"):
        caplog.clear()
        toml.write_text(f'[[plc]]\nsources = "."\ncode = "{code}"\n{task}')
        station = Station.load(toml)
        logged = [record.getMessage() for record in caplog.records]
        assert logged == [
            "plc[1]: 3 errors in units that no task reaches, which are left out: BAD.st, INIT.st,"
            " OLD.st; achse check shows them"
        ]
        station.advance(0.05)
        plc = station.plcs[851]
        assert not plc.failure
        assert plc.instance("MAIN").n == 5  # type: ignore[attr-defined]
    toml.write_text('[[plc]]\nsources = "."\n')
    with pytest.raises(ConfigError, match="no type is named 'Nothing'"):
        Station.load(toml)
