"""Channels of virtual slaves by ADS."""

import json
from typing import Any

import pytest

from achse.devices.channels import CHANNELS
from achse.devices.slave_service import SlaveService
from achse.ethercat import Loopback, Segment, Slave
from achse.ethercat.master.esi_reader import read_esi
from achse.ethercat.virtual import make_slave
from achse.faults.drive_list import DriveFaults
from tests.ethercat.virtual.esi_text import ANALOG, DIGITAL_IN, esi

CLIENT: Any = None


@pytest.fixture
def service() -> SlaveService:
    slaves = [make_slave(each) for each in read_esi(esi(DIGITAL_IN, ANALOG))]
    segment = Segment([*slaves, Slave(Loopback())])
    return SlaveService(segment, DriveFaults(segment))


def ask(service: SlaveService, **request: Any) -> Any:
    data = json.dumps(request).encode()
    return json.loads(bytes(service.read_write(CHANNELS, 0, 1 << 16, data)))


def test_inputs_are_set_by_name(service: SlaveService) -> None:
    assert ask(service, slave=1, channel="PDO 1A03.Input", value=True) == {"value": True}
    assert ask(service, slave=2, channel="Level", value=1.5) == {"value": 1.5}
    assert ask(service, slave=2, channel="6000:01", value="ff01") == {"value": 0x1FF}
    assert ask(service, slave=2, channel="Valve") == {"value": 0}
    rows = json.loads(bytes(service.read(CHANNELS, 0, 1 << 16)))
    assert len(rows) == 8 + 5
    assert rows[3] == {
        "slave": 1,
        "type": "DI8",
        "state": "INIT",
        "channel": "PDO 1A03.Input",
        "output": False,
        "value": True,
    }


@pytest.mark.parametrize(
    ("request_", "message"),
    [
        ({"slave": 9, "channel": "X"}, "there are 3 slaves, got 9"),
        ({"slave": 3, "channel": "X"}, "slave 3 is not made from an ESI file"),
        ({"slave": 2, "channel": "Vale"}, "no channel 'Vale'"),
        ({"slave": 2}, "channel"),
        ({"slave": 2, "channel": "Valve", "value": 1}, "is an output"),
        ({"slave": 2, "channel": "Value", "value": 1e9}, "expected -32768"),
        ({"slave": 2, "channel": "Value", "value": None}, "expected a number"),
        ({"slave": 2, "channel": "Value", "what": 1}, "expected channel, slave, value"),
    ],
)
def test_what_cannot_be_is_reported(service: SlaveService, request_: Any, message: str) -> None:
    assert message in ask(service, **request_)["error"]
