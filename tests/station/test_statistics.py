"""Figures about a running station."""

from achse.station.statistics import statistics
from achse.testing import LiveStation


def test_connections_handles_and_subscriptions_are_counted() -> None:
    with LiveStation(time="virtual") as station, station.connect() as plc:
        plc.read("MAIN.nCounter")
        with plc.subscribe("GVL.nInt"):
            plc.read("MAIN.nCounter")
            figures = station.run(statistics, station.station)
    device = next(each for each in figures["devices"] if 851 in each["ports"])
    assert figures["connections"] == 1
    assert device["handles"] == 2
    assert device["subscriptions"] == 2  # that of the value, and that of the symbol version
    assert (figures["connections_refused"], figures["late_ticks"]) == (0, 0)


def test_a_running_station_tells_how_it_keeps_up() -> None:
    with LiveStation(time=10.0) as station:
        station.advance(0.1)
        assert station.station.pace is not None
        assert station.run(statistics, station.station)["late_ticks"] >= 0
