"""The watch over a scope: each sample is there, and a sample that is lost or wrong is found."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.motion import commands
from achse.scope.data import ScopeTrack
from achse.station import Station
from achse.station.configuration.station_file import parse
from achse.station.station import DEFAULT_EPOCH_NS
from achse.swarm.services.scope_watch import ScopeWatch

Change = Callable[[list[Any]], list[Any]]


def watched() -> tuple[list[str], ScopeWatch, Station]:
    table = {"id": 1, "name": "A1", "control_dword": 7, "velocity_override": 1_000_000}
    document = {"nc": {"cycle": "2ms", "code": "plain"}, "axis": [table]}
    station = Station(parse(document, "world"))
    reports: list[str] = []
    watch = ScopeWatch(station, DEFAULT_EPOCH_NS, lambda name, what: reports.append(name))
    station.cycle.add(watch)
    station.cycle.go_to(20_000_000)
    assert station.nc is not None
    assert commands.universal_start(station.nc.axis(1), 1, 20.0, 50.0) == 0
    return reports, watch, station


def test_scope_has_each_sample_also_after_a_restart() -> None:
    reports, watch, station = watched()
    station.cycle.go_to(700_000_000)
    before = watch.compared
    assert before >= 200
    station.restart()
    station.cycle.go_to(2_500_000_000)
    assert reports == []
    assert watch.compared > before


@pytest.mark.parametrize(
    "change", [lambda values: values[1:], lambda values: [each + 1e-9 for each in values]]
)
def test_lost_or_changed_sample_is_found(change: Change, monkeypatch: pytest.MonkeyPatch) -> None:
    part = ScopeTrack.part
    monkeypatch.setattr(ScopeTrack, "part", lambda self, *arguments: change(part(self, *arguments)))
    reports, _, station = watched()
    station.cycle.go_to(700_000_000)
    assert set(reports) == {"scope-samples"}
