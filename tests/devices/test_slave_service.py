"""The service beside the master: states, objects, faults."""

import json
from typing import Any

import pytest

from achse.ams import NetId
from achse.codes import AlState
from achse.codes.station import SERVICE_PORT
from achse.devices.slave_service import OBJECTS, STATES, SlaveService
from achse.devices.station import FAULTS
from achse.drive import Drive
from achse.drive.identity import VENDOR
from achse.ethercat import Loopback, Segment, Slave
from achse.faults.drive_list import DriveFaults
from achse.router import Router


@pytest.fixture
def segment() -> Segment:
    return Segment([Slave(Drive()), Slave(Loopback()), Slave(Drive())])


@pytest.fixture
def own(segment: Segment, client_of: Any) -> Any:
    router = Router(NetId("127.0.0.1.1.1"))
    SlaveService(segment, DriveFaults(segment)).attach(router, SERVICE_PORT)
    return client_of(router, SERVICE_PORT)


def ask(own: Any, **request: Any) -> Any:
    return json.loads(own.exchange(OBJECTS, 0, 1000, json.dumps(request).encode()))


def test_states_are_those_of_the_slaves(segment: Segment, own: Any) -> None:
    segment.break_link(segment.slaves[2])
    first, second, third = json.loads(own.read(STATES, 0, 10_000))
    assert (first["slave"], first["state"], first["reachable"]) == (1, AlState.INIT.name, True)
    assert (second["name"], "power" in second) == ("Loopback", False)
    assert (third["slave"], third["reachable"]) == (3, False)
    assert {"power", "mode", "position", "velocity", "torque", "alarm"} <= first.keys()


def test_objects_are_read_and_written(own: Any) -> None:
    assert ask(own, index=0x6085, value=77, slave=3) == {"value": 77}
    assert ask(own, index=0x6085, slave=3) == {"value": 77}
    assert ask(own, index=0x1018, subindex=1) == {"value": VENDOR}
    assert ask(own, index=0x6041, value=1)["error"].startswith("0x06010002")


@pytest.mark.parametrize(
    "request_",
    [
        {},
        {"index": 0x6041, "slave": 2},
        {"index": 0x6041, "slave": 4},
        {"index": 0x6041, "colour": 1},
        {"index": "x"},
        {"index": 0x6085, "value": None},
    ],
)
def test_what_is_no_request_is_reported(own: Any, request_: dict[str, Any]) -> None:
    assert "error" in ask(own, **request_)


def test_no_json_is_reported(own: Any) -> None:
    assert "error" in json.loads(own.exchange(OBJECTS, 0, 1000, b"\xff"))
    assert "error" in json.loads(own.exchange(OBJECTS, 0, 1000, b"[]"))


def test_faults_come_the_same_way_as_those_of_a_station(own: Any) -> None:
    request = json.dumps({"kind": "jam", "drive": 1}).encode()
    assert json.loads(own.exchange(FAULTS, 0, 1000, request)) == {"number": 1}
    [listed] = json.loads(own.read(FAULTS, 0, 10_000))
    assert listed["fault"] == {"kind": "jam", "drive": 1}
    own.put(FAULTS, 0, "<I", 0)
    assert json.loads(own.read(FAULTS, 0, 10_000)) == []
