"""What buses of drives and of terminals have in common."""

from achse.station.building.bus_parts import terminals_on
from achse.station.buses.ethercat_bus import EthercatBus
from achse.station.buses.interface_bus import InterfaceBus
from achse.station.configuration.station_file import parse
from achse.station.station import Station

AXES = [{"id": 1, "name": "A"}, {"id": 2, "name": "B"}]


def test_terminals_without_a_name_are_on_the_only_bus() -> None:
    config = parse({"bus": [{}], "terminal": [{"name": "a"}, {"name": "b", "bus": "EtherCAT"}]}, "")
    assert [each.name for each in terminals_on(config, config.bus[0])] == ["a", "b"]


def test_the_first_bus_with_drives_on_an_interface_leads_the_station() -> None:
    def leads(**first: object) -> list[bool]:
        document = {
            "axis": [*AXES, {"id": 3, "name": "C"}],
            "bus": [
                {"name": "here"},
                {"name": "one", "interface": "no-such-1"} | first,
                {"name": "two", "interface": "no-such-2"},
            ],
            "drive": [{"axis": n, "bus": bus} for n, bus in enumerate(("here", "one", "two"), 1)],
        }
        buses = Station(parse(document, "test")).fieldbuses.values()
        return [each.steer is not None for each in buses if isinstance(each, InterfaceBus)]

    assert leads() == [True, False]
    assert leads(pace="computer") == [False, True]
    assert leads(synchronous=False) == [False, True]


def test_each_bus_is_where_its_table_says() -> None:
    document = {
        "axis": AXES,
        "bus": [{"name": "here"}, {"name": "there", "interface": "no-such-if"}],
        "drive": [{"axis": 1, "bus": "here"}, {"axis": 2, "bus": "there"}],
    }
    station = Station(parse(document, "test"))
    here, there = station.fieldbuses.values()
    assert isinstance(here, EthercatBus)
    assert isinstance(there, InterfaceBus)
    station.advance(1.0)
    assert here.master.operational
    assert "no-such-if" in there.trouble
    assert [bus["interface"] for bus in station.statistics()["buses"]] == ["", "no-such-if"]
    station.restart()
    station.advance(1.0)
    assert station.fieldbuses["there"] is not there
