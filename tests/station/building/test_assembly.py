"""Assembly: devices, phases and their order, and faults that a configuration alone cannot show."""

import math
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AdsState, AmsAddress, Frame, RouterError
from achse.devices.plc import PlcDevice
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse


def station(base: Path | None = None, **document: Any) -> Station:
    return Station(parse(document, "a.toml"), base=base)


def test_an_empty_configuration_has_what_every_station_has_and_a_clock() -> None:
    empty = station()
    assert empty.devices[0].name == "TwinCAT System"
    assert empty.router.ports == [1, 30, 100, 110, 200, 10_000, 14_000, 26_000]
    names = [phase.name for phase in empty.cycle.phases]
    assert names == ["changes", "notifications", "scope", "sweep"]
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
        ("scope", math.inf),
        ("sweep", 1_000_000_000),
    ]
    assert built.tick_ns == 1_000_000
    assert built.router.ports == [1, 30, 100, 110, 200, 500, 501, 851, 852, 10_000, 14_000, 26_000]


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


def test_what_a_file_configures_wrongly_names_the_file(folder: Path) -> None:
    path = folder / "station.toml"
    path.write_text('[[axis]]\nid = 1\nname = "A"\nspeed = 3\n', encoding="utf-8")
    with pytest.raises(ConfigError, match=r"station\.toml: axis\[1\].speed: no such key"):
        Station.load(path)


def test_what_a_vanished_client_held_is_kept_for_a_while(client_of: Any) -> None:
    built = station(plc=[{"task": [{}]}], limits={"unreachable_time": "5s"})
    plc = client_of(built.router, 851)
    plc.address = AmsAddress("10.0.0.7.1.1:30000")
    plc.router.learn(plc.address, plc)
    plc.subscribe(0xF100, 0, 4)
    plc.router.forget(plc.address, plc)
    [device] = [each for each in built.devices if isinstance(each, PlcDevice)]
    built.advance(4.0)
    assert len(device.notifications) == 1
    built.advance(3.0)
    assert len(device.notifications) == 0


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


@settings(max_examples=5)
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
        "nc": {"code": "plain"},
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
    """Anyone who wants a port."""

    def deliver(self, frame: Frame) -> bool:
        return True
