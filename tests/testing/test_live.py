"""A station in a thread of its own, and a client that blocks."""

import contextlib
import logging.handlers
import queue
import socket
from pathlib import Path

import pytest

from achse.ams import AdsError, DeviceError
from achse.faults.fault import FaultError
from achse.station import Station, StationConfig
from achse.station.clocks.cycle import CyclicPhase, PhasePlace
from achse.testing import LiveStation

COUNTER = "MAIN.nCounter"


@pytest.fixture
def station() -> LiveStation:
    return LiveStation(time="virtual")


def test_virtual_time_stands_until_it_is_advanced(station: LiveStation) -> None:
    with station, station.connect() as plc:
        assert plc.read(COUNTER) == 0
        station.advance(2.5)
        assert (plc.read(COUNTER), station.time) == (250, 2.5)


def test_real_time_goes_on_by_itself_and_advance_waits_for_it() -> None:
    with LiveStation(time=20.0) as station, station.connect() as plc:
        before = plc.read(COUNTER)
        station.advance(1.0)
        assert plc.read(COUNTER) >= before + 100


def test_a_restart_brings_initial_values_at_the_same_address(station: LiveStation) -> None:
    with station:
        where = (station.host, station.tcp_port, station.net_id)
        station.fault("error", symbol=COUNTER, code=0x705)
        with station.connect() as plc:
            plc.write("GVL.nInt", 7)
            with pytest.raises(DeviceError, match="0x705"):
                plc.read(COUNTER)
            station.restart()
            assert plc.read("GVL.nInt") == -16
            assert plc.read(COUNTER) == 0
        assert (station.host, station.tcp_port, station.net_id) == where
        assert station.time == 0


def test_faults_are_added_and_cleared_from_the_test(station: LiveStation) -> None:
    with station, station.connect() as plc, station.connect() as impatient:
        impatient._client.timeout = 0.1
        lost = station.fault("drop", command="read_state")
        with pytest.raises(AdsError, match="0x745"):
            impatient.state()
        station.clear_faults()
        plc.state()
        assert lost.hits == 1
        with pytest.raises(FaultError, match="kind"):
            station.fault("melt")


def test_two_stations_stand_side_by_side() -> None:
    with LiveStation(time="virtual") as one, LiveStation(time="virtual") as two:
        assert one.net_id != two.net_id
        one.advance(1.0)
        with one.connect() as first, two.connect() as second:
            assert (first.read(COUNTER), second.read(COUNTER)) == (100, 0)


def test_the_station_may_come_from_a_file_a_configuration_or_a_function(tmp_path: Path) -> None:
    file = tmp_path / "station.toml"
    file.write_text('name = "mine"\n[router]\nnet_id = "5.6.7.8.1.1"\n')
    for config in (file, str(file), {"name": "mine"}, StationConfig(name="mine")):
        with LiveStation(config, time="virtual") as station:
            assert station.station.config.name == "mine"
            assert station.net_id == f"{station.host}.1.1"
    with LiveStation(lambda: Station(StationConfig(name="made")), time="virtual") as station:
        assert (station.station.config.name, station.net_id) == ("made", "127.0.0.1.1.1")


def test_what_prevents_the_start_is_raised() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(OSError, match="in use"):
            LiveStation(host="127.0.0.1", tcp_port=port).start()
    with pytest.raises(ValueError, match="time: expected"):
        LiveStation(time="yesterday")  # type: ignore[arg-type]


def test_what_runs_in_the_thread_gives_its_result_or_exception(station: LiveStation) -> None:
    with pytest.raises(RuntimeError, match="not running"):
        station.run(int)
    with station:
        assert station.run(int, "12") == 12
        with pytest.raises(ZeroDivisionError):
            station.run(divmod, 1, 0)
    station.stop()


def test_a_broken_cycle_is_reported_at_the_end() -> None:
    station = LiveStation(time=50.0)
    station.start()

    def breaks(_: int) -> None:
        raise ArithmeticError("broken")

    bad = CyclicPhase(PhasePlace.SCOPE, "bad", station.station.tick_ns, breaks)
    records = queue.SimpleQueue[logging.LogRecord]()
    handler = logging.handlers.QueueHandler(records)
    logging.getLogger("achse").addHandler(handler)
    try:
        station.run(station.station.cycle.add, bad)
        assert "broke" in records.get().getMessage()
    finally:
        logging.getLogger("achse").removeHandler(handler)
    with pytest.raises(ArithmeticError, match="broken"):
        station.stop()


def test_a_broken_connection_is_closed_when_the_fault_returns(station: LiveStation) -> None:
    with station, socket.create_connection((station.host, station.tcp_port)) as client:
        with station.connect() as plc:
            plc.read(COUNTER)  # the first one was accepted before
        station.fault("drop_link")
        client.setblocking(False)
        with contextlib.suppress(ConnectionResetError):
            assert client.recv(1) == b""
