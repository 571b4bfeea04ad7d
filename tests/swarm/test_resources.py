"""Invariants of resources: what is held, and what is given back."""

from typing import Any

import pytest

from achse.station import Station
from achse.swarm.resources import Replaced, check_bounds, check_released, is_released


def test_station_without_clients_holds_nothing() -> None:
    station, reported = Station.demo(), list[str]()
    station.advance(0.1)
    check_bounds(station, 1, lambda name, what: reported.append(name))
    check_released(station, lambda name, what: reported.append(name))
    assert reported == []
    assert is_released(station)


@pytest.mark.parametrize(
    ("name", "value"), [("connections", 1), ("queued_bytes", 5), ("buffered_bytes", 7)]
)
def test_what_is_held_is_reported(name: str, value: int, monkeypatch: pytest.MonkeyPatch) -> None:
    station, reported = Station.demo(), list[str]()
    figures: dict[str, Any] = {**station.statistics(), name: value}
    monkeypatch.setattr(station, "statistics", lambda: figures)
    check_released(station, lambda invariant, what: reported.append(what))
    assert len(reported) == 1
    assert str(value) in reported[0]
    assert not is_released(station)


def test_more_than_the_limit_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    station, reported = Station.demo(), list[str]()
    figures = {**station.statistics(), "handles_abandoned": 1 << 20}
    monkeypatch.setattr(station, "statistics", lambda: figures)
    check_bounds(station, 1, lambda invariant, what: reported.append(invariant))
    assert reported == ["bounded"]


def test_nc_of_before_a_restart_that_is_kept_is_reported() -> None:
    station, reported, replaced = Station.demo(), list[str](), Replaced()
    station.advance(0.1)
    replaced.look(station)
    nc = station.nc
    station.restart()
    station.advance(2.0)
    replaced.check(station, lambda invariant, what: reported.append(what))
    assert nc is not None
    assert reported == ["NC of before a restart is still there"]
    del nc
    replaced.check(station, lambda invariant, what: reported.append(what))
    assert len(reported) == 1
