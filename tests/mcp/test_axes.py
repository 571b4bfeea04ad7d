"""Buses, slaves and drives as tools show them."""

from achse.mcp.axes import bus_reports
from achse.station import Station
from achse.station.configuration.station_file import parse


def test_a_bus_shows_slaves_and_drives() -> None:
    document = {
        "axis": [{"id": 1, "name": "X"}],
        "bus": [{}],
        "drive": [{"axis": 1}],
        "terminal": [{"name": "in1", "inputs": 4}],
    }
    station = Station(parse(document, "station.toml"))
    station.advance(3.0)
    [bus] = bus_reports(station)
    assert bus.operational
    assert {slave.state for slave in bus.slaves} == {"OP"}
    assert all(slave.present and not slave.al_code for slave in bus.slaves)
    assert any(slave.power_state for slave in bus.slaves)
