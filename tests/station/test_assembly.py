"""Assembly: devices, phases and their order, and faults that a configuration alone cannot show."""

import math
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AdsState, AmsAddress, Frame, RouterError
from achse.motion.kernel import cycles
from achse.native.compiled import Kernel
from achse.station import ConfigError, Station
from achse.station.config import parse

PROGRAM = """
from achse.iec import GlobalVariables, INT, Program, var

class Count(Program):
    nValue = var(INT)

    def cycle(self) -> None:
        self.nValue = self.nValue + 1

class Values(GlobalVariables):
    nGlobal = var(INT, 7)

class Neither:
    pass
"""


def station(base: Path | None = None, **document: Any) -> Station:
    return Station(parse(document, "a.toml"), base=base)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "program.py").write_text(PROGRAM, encoding="utf-8")
    (tmp_path / "broken.py").write_text("1 / 0\n", encoding="utf-8")
    return tmp_path


def test_an_empty_configuration_has_what_every_station_has_and_a_clock() -> None:
    empty = station()
    assert empty.devices[0].name == "TwinCAT System"
    assert empty.router.ports == [1, 100, 110, 10_000, 26_000]
    assert [phase.name for phase in empty.cycle.phases] == ["changes", "notifications", "sweep"]
    empty.advance(0.5)
    assert empty.time_ns == 500_000_000


def test_the_cycle_goes_from_axes_over_plcs_to_notifications(folder: Path) -> None:
    task = {"cycle": "10ms", "programs": ["program.py:Count"]}
    built = station(
        folder,
        nc={"cycle": "2ms"},
        axis=[{"id": 5, "name": "A"}],
        plc=[{"task": [task, {"name": "Slow", "cycle": "15ms"}]}, {"port": 852}],
    )
    assert [(phase.name, phase.due_ns) for phase in built.cycle.phases] == [
        ("changes", math.inf),
        ("nc", 2_000_000),
        ("plc 851", 10_000_000),
        ("plc 852", 10_000_000),
        ("notifications", math.inf),
        ("sweep", 1_000_000_000),
    ]
    assert built.tick_ns == 1_000_000
    assert built.router.ports == [1, 100, 110, 500, 501, 851, 852, 10_000, 26_000]


def test_each_phase_runs_at_its_own_cycle(folder: Path) -> None:
    built = station(
        folder,
        axis=[{"id": 1, "name": "A"}],
        plc=[{"task": [{"cycle": "5ms", "programs": ["program.py:Count"]}]}],
    )
    built.advance(0.1)
    assert built.nc is not None
    assert built.nc.cycle_count == 50
    count: Any = built.plcs[851].instance("Count")
    assert count.nValue == 20


def test_further_ports_answer_for_the_same_plc(folder: Path, client_of: Any) -> None:
    built = station(folder, plc=[{"globals": ["program.py:Values"], "also": [801]}])
    first, second = client_of(built.router, 851), client_of(built.router, 801)
    handle = int.from_bytes(first.exchange(0xF003, 0, 4, b"Values.nGlobal\0"), "little")
    first.put(0xF005, handle, "<h", -3)
    handle = int.from_bytes(second.exchange(0xF003, 0, 4, b"Values.nGlobal\0"), "little")
    assert second.get(0xF005, handle, "<h") == -3


def test_axis_parameters_reach_the_axis() -> None:
    axis = {"id": 9, "name": "A", "unit": "inch", "modulo": True, "max_velocity": 12.5}
    built = station(axis=[axis])
    assert built.nc is not None
    made = built.nc.axis(9)
    assert (made.name, made.unit, made.max_velocity) == ("A", "inch", 12.5)
    assert made.unit_interpretation == 4


@pytest.mark.parametrize(
    ("values", "period", "begin"),
    [
        ({}, 360.0, -68.0),
        ({"encoder_modulo_factor": 100.0, "simulation_cam_end": 5.0}, 100.0, 0.0),
        ({"simulation_period": 0.0, "simulation_cam_begin": -60.0}, 0.0, -60.0),
    ],
)
def test_the_machine_of_a_modulo_axis_is_a_rotary_table(
    values: dict[str, float], period: float, begin: float
) -> None:
    built = station(axis=[{"id": 1, "name": "C", "unit": "degree", "modulo": True, **values}])
    assert built.nc is not None
    made = built.nc.axis(1)
    assert (made.machine.period, made.machine.cam_begin) == (period, begin)


def test_words_of_enumerations_and_flags() -> None:
    values = {"override_type": "original", "encoder_ids": [1, 7]}
    element = {"encoder_count_direction": True, "controller_type": "PID_POSITION"}
    built = station(axis=[{"id": 1, "name": "A", **values, "element": [element]}])
    assert built.nc is not None
    made = built.nc.axis(1)
    other = made.encoders[1]
    assert made.override_type == 2
    assert (other.encoder_count_direction, other.controller_type) == (1, 3)
    assert type(other.encoder_count_direction) is int


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"max_velocty": 1.0}, r"axis\[2\]: .*no parameter 'max_velocty'"),
        ({"max_velocity": "fast"}, r"axis\[2\]\.max_velocity: expected a number, got 'fast'"),
        ({"max_velocity": True}, r"axis\[2\]\.max_velocity: expected a number, got True"),
        (
            {"override_type": "fast"},
            r"axis\[2\]\.override_type: expected a number or REDUCED or .*, got 'fast'",
        ),
        ({"encoder_ids": [2, 1]}, r"axis: encoder id 1 is given twice"),
        ({"max_velocity": float("nan")}, r"axis\[2\]: .*max_velocity = nan"),
        ({"max_velocity": -1.0}, r"axis\[2\]: .*max_velocity = -1.0, expected .*mm/s"),
        (
            {"modulo": True, "unit_interpretation": math.inf},
            r"axis\[2\]: .*unit_interpretation = inf",
        ),
        ({"override_type": 1.5}, r"axis\[2\]: .*override_type = 1.5, expected a whole number"),
    ],
)
def test_a_wrong_axis_parameter_is_located(values: dict[str, Any], message: str) -> None:
    axes = [{"id": 1, "name": "A"}, {"id": 2, "name": "B", **values}]
    with pytest.raises(ConfigError, match=message):
        station(axis=axes)


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ("program.py", r"expected module:Class or file\.py:Class, got 'program\.py'"),
        ("nowhere.py:Count", r"nowhere\.py cannot be imported: FileNotFoundError"),
        ("no.such.module:Count", r"no\.such\.module cannot be imported: ModuleNotFoundError"),
        ("broken.py:Count", r"broken\.py cannot be imported: ZeroDivisionError"),
        ("program.py:Missing", r"program\.py has no Program 'Missing'"),
        ("program.py:Neither", r"program\.py has no Program 'Neither'"),
        ("program.py:Values", r"program\.py has no Program 'Values'"),
    ],
)
def test_a_wrong_program_is_located(folder: Path, program: str, message: str) -> None:
    plc = [{}, {"port": 852, "task": [{}, {"programs": [program]}]}]
    with pytest.raises(ConfigError, match=r"plc\[2\]\.task\[2\]\.programs: " + message):
        station(folder, plc=plc)


def test_a_wrong_variable_list_is_located(folder: Path) -> None:
    with pytest.raises(ConfigError, match=r"plc\[1\]\.globals: .*no GlobalVariables 'Count'"):
        station(folder, plc=[{"globals": ["program.py:Count"]}])


def test_a_port_that_is_taken_is_named() -> None:
    with pytest.raises(ConfigError, match=r"port 501 for Plc30 App: .*PORT_IN_USE"):
        station(axis=[{"id": 1, "name": "A"}], plc=[{"port": 501}])


def test_cycles_without_a_sensible_common_tick_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"a tick of 10000 ns.*nc 2000000 ns"):
        station(axis=[{"id": 1, "name": "A"}], plc=[{"task": [{"cycle": "3000001ns"}]}])


def test_the_compiled_kernel_needs_llvmlite(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("achse.motion.nc.KERNEL", Kernel("fresh", cycles, {}))
    monkeypatch.setitem(sys.modules, "llvmlite", None)
    with pytest.raises(ConfigError, match=r"nc\.kernel: compiled needs llvmlite.*achse\[fast\]"):
        station(nc={"kernel": "compiled"}, axis=[{"id": 1, "name": "A"}])


def test_what_a_file_configures_wrongly_names_the_file(folder: Path) -> None:
    path = folder / "station.toml"
    path.write_text('[[axis]]\nid = 1\nname = "A"\nspeed = 3\n', encoding="utf-8")
    with pytest.raises(ConfigError, match=r"station\.toml: axis\[1\]: .*'speed'"):
        Station.load(path)


def test_programs_beside_the_file_are_found(folder: Path) -> None:
    path = folder / "station.toml"
    path.write_text('[[plc]]\n[[plc.task]]\nprograms = ["program.py:Count"]\n', encoding="utf-8")
    assert {unit.name for unit in Station.load(path).plcs[851].units} >= {"Count"}


def test_limits_hold_for_each_device(client_of: Any, refused: Any) -> None:
    built = station(
        plc=[{"task": [{}]}],
        axis=[{"id": 1, "name": "A"}],
        limits={"handles": 1, "notifications": 2, "sample_bytes": 8},
    )
    plc = client_of(built.router, 851)
    plc.exchange(0xF003, 0, 4, b"TwinCAT_SystemInfoVarList._AppInfo\0")
    with refused(0x716):
        plc.exchange(0xF003, 0, 4, b"TwinCAT_SystemInfoVarList._AppInfo\0")
    for port in (851, 501, 10_000):
        client = client_of(built.router, port)
        client.subscribe(0xF100, 0, 4)
        client.subscribe(0xF100, 0, 4)
        with refused(0x716):
            client.subscribe(0xF100, 0, 4)
    with refused(0x717):
        client_of(built.router, 851).subscribe(0x4020, 0, 16)


def test_what_a_vanished_client_held_is_kept_for_a_while(client_of: Any) -> None:
    built = station(plc=[{"task": [{}]}], limits={"unreachable_time": "5s"})
    plc = client_of(built.router, 851)
    plc.address = AmsAddress("10.0.0.7.1.1:30000")
    plc.router.learn(plc.address, plc)
    plc.subscribe(0xF100, 0, 4)
    plc.router.forget(plc.address, plc)
    device = built.devices[-1]
    built.advance(4.0)
    assert len(device.notifications) == 1
    built.advance(3.0)
    assert len(device.notifications) == 0


def test_the_characteristic_of_a_drive_is_a_table_of_the_configuration() -> None:
    valve = {"id": 7, "name": "valve", "points": [[-1, -1], [0, 0], [0.1, 0.5], [1, 1]]}
    axis = {
        "id": 1, "name": "X", "drive_table_id": 7, "drive_table_interpolation_type": "spline",
        "simulation_table_id": 7,
    }  # fmt: skip
    nc = station(table=[valve], axis=[axis]).nc
    assert nc is not None
    assert nc.tables.find(7).table_name == "valve"
    assert nc.axis(1).curve_count == 4
    assert nc.axis(1).drive_table_interpolation_type == 2
    assert nc.tables.user_count(7) == 2


@pytest.mark.parametrize(
    ("table", "axis", "message"),
    [
        ({"points": [[0, 0], [0, 1]]}, {}, "table: table 7: its places do not rise"),
        ({"points": [[0, 0]]}, {}, r"a.toml: table\[1\].points: .* at least 2"),
        ({"points": [[0, 0], [float("inf"), 1]]}, {}, "finite number"),
        ({"points": [[0, 0], [1, 1]]}, {"drive_table_id": 8}, "table: no table 8, for axis 1"),
        (
            {"points": [[0, 0], [0.1, 1], [1, 2]], "type": "equidistant_linear"}, {},
            "table: table 7: its steps are not equal",
        ),
    ],
)  # fmt: skip
def test_a_table_that_no_drive_could_use(table: Any, axis: Any, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        station(table=[{"id": 7} | table], axis=[{"id": 1, "name": "X"} | axis])


@pytest.mark.parametrize(
    ("document", "what"),
    [
        ({"system": {"root": "."}}, "the configuration's folder"),
        ({"system": {"root": ".."}}, "the configuration's folder"),
        (
            {"system": {"root": "files"}, "router": {"static_routes": "files/r.xml"}},
            "router.static_routes",
        ),
        ({"system": {"root": "files", "persistent_data": "files/s"}}, "system.persistent_data"),
        ({"system": {"root": "link"}}, "the configuration's folder"),
    ],
)
def test_clients_are_not_shown_what_the_station_reads_itself(
    tmp_path: Path, document: dict[str, Any], what: str
) -> None:
    """Who may write a station.toml, or a behaviour beside it, runs code with our rights."""
    (tmp_path / "files").mkdir()
    (tmp_path / "link").symlink_to(tmp_path)
    with pytest.raises(ConfigError, match=f"a folder for clients alone, .* has {what}"):
        Station(parse(document, "a.toml"), base=tmp_path)


steps = st.lists(
    st.one_of(
        st.sampled_from(["restart", "configure", "advance", "break", "mend"]),
        st.sampled_from([500, 501, 851, 801, 852, 100, 10_000, 26_000, 300]),
    ),
    max_size=30,
)


@settings(max_examples=25)
@given(drawn=steps)
def test_configured_ports_stay_the_stations_through_restarts(
    drawn: list[str | int], tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Clients register any port at any moment; before, one had 851 after a restart."""
    folder = tmp_path_factory.mktemp("ports")
    source = folder / "gvl.st"
    source.write_text("VAR_GLOBAL a : INT; END_VAR")
    document = {
        "plc": [{"sources": "gvl.st", "also": [801]}],
        "axis": [{"id": 1, "name": "X"}],
        "nc": {"kernel": "interpreted"},
    }
    station = Station(parse(document, "a.toml"), base=folder)
    configured = set(station.router.ports)
    taken: set[int] = set()
    for step in drawn:
        if isinstance(step, int):
            with suppress(RouterError):
                station.router.register(step, Nobody())
                taken.add(step)
        elif step == "advance":
            station.advance(0.3)
        elif step in ("break", "mend"):
            source.write_text(f"VAR_GLOBAL a : {'INT' if step == 'mend' else 'NONE'}; END_VAR")
        else:
            getattr(station, step)()
    assert not taken & configured
    source.write_text("VAR_GLOBAL a : INT; END_VAR")
    station.restart()
    station.advance(1.0)
    assert station.state is AdsState.RUN
    assert set(station.router.ports) == configured | taken


class Nobody:
    """Whoever wants a port."""

    def deliver(self, frame: Frame) -> bool:
        return True
