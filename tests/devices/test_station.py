"""The station's own service: faults, taps and statistics for any ADS client."""

import json
import struct
from pathlib import Path
from typing import Any

import pytest

from achse.ams import AmsAddress, Frame
from achse.codes.station import MISSING_CONDITION, ONLINE_CHANGE, SERVICE_PORT
from achse.devices.station import FAULTS, STATISTICS
from achse.devices.taps import TAPS
from achse.router.tap import decode_batch
from achse.station import Station


@pytest.fixture
def station() -> Station:
    return Station.demo()


@pytest.fixture
def own(station: Station, client_of: Any) -> Any:
    return client_of(station.router, SERVICE_PORT)


class Sink:
    """A client that keeps what it gets."""

    def __init__(self) -> None:
        self.frames: list[Frame] = []

    def deliver(self, frame: Frame) -> bool:
        self.frames.append(frame)
        return True


def add(own: Any, **fields: Any) -> Any:
    return json.loads(own.exchange(FAULTS, 0, 1000, json.dumps(fields).encode()))


def test_faults_are_added_listed_and_cleared(station: Station, own: Any, refused: Any) -> None:
    assert add(own, kind="drop", at=5.0) == {"number": 1}
    assert add(own, kind="delay", by=0.1) == {"number": 2}
    listed = json.loads(own.read(FAULTS, 0, 10_000))
    assert [each["fault"]["kind"] for each in listed] == ["drop", "delay"]
    own.put(FAULTS, 0, "<I", 1)
    assert len(station.faults) == 1
    with refused(0x70C):
        own.put(FAULTS, 0, "<I", 1)
    with refused(0x705):
        own.write(FAULTS, 0, b"\1")
    own.put(FAULTS, 0, "<I", 0)
    assert len(station.faults) == 0


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b'{"kind": "melt"}', "kind: expected one of"),
        (b'{"kind": "error", "code": 1, "symbol": "X.y"}', "symbol: no device"),
        (b'{"kind": "error"}', "code: a fault of kind error needs it"),
        (b"[]", "a fault is a JSON object"),
        (b"\xff", "codec can't decode"),
        (b"[" * 100_000, "nested too deep"),
        (b'{"kind": "drop", "at": Infinity}', "at: expected 0.."),
    ],
)
def test_a_fault_that_cannot_be_is_reported(own: Any, data: bytes, message: str) -> None:
    assert message in json.loads(own.exchange(FAULTS, 0, 1000, data))["error"]


def test_a_tap_shows_what_others_do(station: Station, own: Any, client_of: Any) -> None:
    (tap,) = struct.unpack("<I", own.exchange(TAPS, 0, 4, b""))
    plc = client_of(station.router, 851)
    plc.read(0x4020, 0, 4)
    request, answer = decode_batch(own.read(TAPS, tap, 100_000))
    assert (request.inwards, answer.inwards) == (True, False)
    assert request.frame.target == plc.target
    assert answer.frame.data[8:] == bytes(4)
    assert own.read(TAPS, tap, 100_000) == b""


def test_a_tap_belongs_to_who_opened_it_and_goes_with_him(
    station: Station, own: Any, client_of: Any, refused: Any
) -> None:
    taps = [struct.unpack("<I", own.exchange(TAPS, 0, 4, b""))[0] for _ in range(4)]
    with refused(0x716):
        own.exchange(TAPS, 0, 4, b"")
    other = client_of(station.router, SERVICE_PORT)
    with refused(0x70C):
        other.read(TAPS, taps[0], 100)
    own.write(TAPS, taps[0])
    with refused(0x70C):
        own.read(TAPS, taps[0], 100)
    station.router.unregister(own.address.port)
    assert not station.router.attended


def test_taps_of_many_addresses_have_a_limit_together_and_harm_no_client(
    station: Station, own: Any, client_of: Any
) -> None:
    codes = []
    for number in range(163):
        source = AmsAddress(f"10.0.0.{number // 4 + 1}.1.1:30000")
        data = struct.pack("<IIII", TAPS, 0, 4, 0)
        request = Frame(own.target, source, 9, 4, 0, number, data)
        sink = Sink()
        request.origin = sink
        station.router.deliver(request)
        codes.append(int.from_bytes(sink.frames[0].data[:4], "little"))
    assert codes == [0] * 32 + [0x716] * 131
    plc = client_of(station.router, 851)
    assert plc.read(0x4020, 0, 4) == bytes(4)


def test_statistics(station: Station, own: Any, client_of: Any) -> None:
    client_of(station.router, 851).subscribe(0x4020, 0, 4)
    station.advance(0.5)
    figures = json.loads(own.read(STATISTICS, 0, 100_000))
    assert (figures["time"], figures["tick"], figures["connections"]) == (0.5, 0.002, 0)
    by_port = {device["ports"][0]: device for device in figures["devices"]}
    assert (by_port[851]["subscriptions"], by_port[851]["clients"]) == (1, 1)
    assert by_port[500]["subscriptions"] == 0


def test_an_online_change_on_demand(tmp_path: Path, client_of: Any) -> None:
    (tmp_path / "GVL.st").write_text("VAR_GLOBAL nOld : INT; END_VAR\n")
    toml = tmp_path / "station.toml"
    toml.write_text('[[plc]]\nsources = "GVL.st"\n')
    station = Station.load(toml)
    own = client_of(station.router, SERVICE_PORT)
    assert json.loads(own.exchange(ONLINE_CHANGE, 851, 1000, b"")) == {"851": 1}
    (tmp_path / "GVL.st").write_text("VAR_GLOBAL nOld : ; END_VAR\n")
    assert "GVL.st:1" in json.loads(own.exchange(ONLINE_CHANGE, 0, 1000, b""))["error"]
    assert "port 7" in json.loads(own.exchange(ONLINE_CHANGE, 7, 1000, b""))["error"]
    assert station.plcs[851].online_changes == 1


def test_missing_condition_is_a_text_for_each_axis(own: Any) -> None:
    assert own.read(MISSING_CONDITION, 1, 1000) == b""  # an axis without a drive on a bus
