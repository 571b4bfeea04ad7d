"""Figures about a running station."""

from unittest import mock

import pytest

from achse.ams import AdsError
from achse.client import connect
from achse.station import Station, StationConfig
from achse.station.running.statistics import statistics
from achse.testing import LiveStation

ONE_OF_EACH = {"limits": {"all_handles": 1}, "plc": [{"globals": ["achse.station.demo:GVL"]}]}


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
    assert figures["buffered_bytes"] < 1000  # a sample waits behind the answer to its Add
    assert figures["samples_late"] == 0


def test_a_running_station_reports_how_it_keeps_up() -> None:
    with LiveStation(time=10.0) as station:
        station.advance(0.1)
        assert station.station.pace is not None
        assert station.run(statistics, station.station)["late_ticks"] >= 0


def test_what_limits_refuse_is_counted() -> None:
    with LiveStation(StationConfig.model_validate(ONE_OF_EACH)) as station:
        with station.connect() as plc:
            plc.read_write_raw(0xF003, 0, 4, b"GVL.nInt")
            with pytest.raises(AdsError, match="0x716"):
                plc.read_write_raw(0xF003, 0, 4, b"GVL.nInt")
        figures = station.run(statistics, station.station)
    device = next(each for each in figures["devices"] if 851 in each["ports"])
    assert (device["refused"], device["queued_bytes"], device["samples_dropped"]) == (1, 0, 0)


def test_clients_are_listed_with_what_they_requested() -> None:
    with LiveStation(time="virtual") as station, station.connect() as plc:
        before = station.run(statistics, station.station)["clients"]
        for _ in range(5):
            plc.read("MAIN.nCounter")
        with pytest.raises(AdsError):
            plc.read_raw(0x4020, 0xFFFF_FFF0, 4)
        figures = station.run(statistics, station.station)
    [client] = figures["clients"]
    assert figures["clients_known"] == 1
    assert client["peer"].startswith("127.0.0.1:")
    assert client["address"].count(".") == 5
    assert client["requests"] >= sum(each["requests"] for each in before) + 6
    assert (client["errors"], client["subscriptions"]) == (1, 1)


def test_a_client_in_this_process_is_listed_by_its_subscriptions() -> None:
    with LiveStation(time="virtual") as station:
        address = bytes.fromhex("0a0000010101") + (40_000).to_bytes(2, "little")
        subscriptions = {address: 1}
        device = station.station.devices[0]
        assert station.run(statistics, station.station)["clients"] == []
        with (
            mock.patch.object(type(device.notifications), "clients", subscriptions),
            mock.patch.object(
                device.notifications, "subscriptions_of", lambda client: subscriptions[client]
            ),
        ):
            [client] = station.run(statistics, station.station)["clients"]
    assert (client["address"], client["peer"]) == ("10.0.0.1.1.1:40000", None)
    assert client["requests"] is None


async def test_a_client_in_this_process_is_counted_until_it_goes() -> None:
    station = Station.demo()
    async with connect(station.router) as plc:
        for _ in range(4):
            await plc.read("MAIN.nCounter")
        with pytest.raises(AdsError):
            await plc.read_raw(0x4020, 0xFFFF_FFF0, 4)
        [client] = [each for each in statistics(station)["clients"] if each["errors"]]
        assert (client["requests"] >= 5, client["errors"], client["peer"]) == (True, 1, None)
    assert client["address"] not in {each["address"] for each in statistics(station)["clients"]}
