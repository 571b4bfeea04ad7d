"""Parts are put together: ports, limits, the common tick."""

from pathlib import Path
from typing import Any

import pytest

from achse.station import ConfigError, Station
from achse.station.building import assembly
from achse.station.building.building import Building
from achse.station.clocks.cycle import CyclicPhase, PhasePlace
from achse.station.configuration.station_file import parse


def station(base: Path | None = None, **document: Any) -> Station:
    return Station(parse(document, "a.toml"), base=base)


def test_cycles_without_a_sensible_common_tick_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"a tick of 10000 ns.*nc 2000000 ns"):
        station(axis=[{"id": 1, "name": "A"}], plc=[{"task": [{"cycle": "3000001ns"}]}])


def test_a_port_that_is_taken_is_named() -> None:
    with pytest.raises(ConfigError, match=r"port 501 for Plc30 App: .*PORT_IN_USE"):
        station(axis=[{"id": 1, "name": "A"}], plc=[{"port": 501}])


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


def test_a_part_is_a_function_and_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    """What it adds is there again after a restart, and the tick follows its cycle."""
    seen: list[int] = []

    def make_counter(building: Building) -> None:
        phase = CyclicPhase(PhasePlace.SCOPE, "counter", 3_000_000, seen.append)
        building.add_phase(phase, phase.cycle_ns)
        building.add_state(lambda: len(seen).to_bytes(4, "little"))

    monkeypatch.setattr(assembly, "PARTS", (*assembly.PARTS, make_counter))
    built = station(nc={"cycle": "2ms"}, axis=[{"id": 1, "name": "A"}])
    assert built.tick_ns == 1_000_000
    before = built.digest()
    built.advance(0.01)
    assert seen == [3_000_000, 6_000_000, 9_000_000]
    assert built.digest() != before
    built.restart()
    built.advance(1.0)
    assert seen[-1] == 1_008_000_000
    assert [phase.name for phase in built.cycle.phases].count("counter") == 1


def test_what_was_attached_is_taken_back_if_a_later_part_fails(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fail(building: Building) -> None:
        raise ConfigError("scope: expected another")

    built = station(axis=[{"id": 1, "name": "A"}])
    monkeypatch.setattr(assembly, "PARTS", (*assembly.PARTS, fail))
    built.restart()
    built.advance(1.0)
    assert built.nc is None
    assert 501 not in built.router.ports
