"""A station is what faults can hit."""

from achse.faults.target import FaultyStation
from achse.station import Station


def test_a_station_is_a_target() -> None:
    target: FaultyStation = Station.demo()
    happened: list[int] = []
    target.at(4_000_000, lambda: happened.append(target.time_ns))
    assert not target.strict
    assert isinstance(target, Station)
    target.advance(0.01)
    assert happened == [4_000_000]
